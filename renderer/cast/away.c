/* Chessboard distances in two passes (Rosenfeld and Pfaltz 1968: of the moves of a shortest way, in any
 * order, one pass makes those forward and the other those backward). */
#include "away.h"

#include <string.h>

/* One pass over the bricks, forward or (sign -1) backward: away is no more than one more than that of any
 * neighbour passed before. least: room for a row and one more at each end. */
static void sweep(uint8_t *away, const uint64_t bricks[3], int sign, uint8_t *least)
{
    static const int rows[4][2] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}}; /* y and z of those before a row */
    const int64_t n[3] = {(int64_t)bricks[0], (int64_t)bricks[1], (int64_t)bricks[2]};
    for (int64_t i = 0; i < n[1] * n[2]; i++) {
        const int64_t row = sign > 0 ? i : n[1] * n[2] - 1 - i, y = row % n[1], z = row / n[1];
        uint8_t *at = away + row * n[0];
        memset(least, UINT8_MAX, (size_t)n[0] + 2);
        for (int r = 0; r < 4; r++) {
            const int64_t other[2] = {y + sign * rows[r][0], z + sign * rows[r][1]};
            if (other[0] < 0 || other[0] >= n[1] || other[1] < 0 || other[1] >= n[2])
                continue;
            const uint8_t *before = away + (other[1] * n[1] + other[0]) * n[0];
            for (int64_t x = 0; x < n[0]; x++)
                least[x + 1] = before[x] < least[x + 1] ? before[x] : least[x + 1];
        }
        uint8_t last = UINT8_MAX;
        for (int64_t k = 0; k < n[0]; k++) {
            const int64_t x = sign > 0 ? k : n[0] - 1 - k;
            for (int d = 0; d < 3; d++)
                last = least[x + d] < last ? least[x + d] : last;
            last = last < at[x] ? (uint8_t)(last + 1) : at[x];
            at[x] = last;
        }
    }
}

void vr_cast_find_away(uint8_t *away, const uint64_t bricks[3])
{
    uint8_t *room = away + bricks[0] * bricks[1] * bricks[2];
    sweep(away, bricks, 1, room);
    sweep(away, bricks, -1, room);
}
