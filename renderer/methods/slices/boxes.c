/* A tree of halves: what is active is bounded; where less than half of the bounds is active they are halved
 * along their longest edge. An inactive macrocell that is drawn costs fragments which add nothing; one more
 * box costs polygons. */
#include "boxes.h"

#include <stdbool.h>

struct search {
    const uint32_t *bits;
    const int *cells;
    struct vr_cell_box *boxes;
    size_t count;
};

static bool active(const struct search *s, int x, int y, int z)
{
    int bit = (z * s->cells[1] + y) * s->cells[0] + x;
    return s->bits[bit >> 5] >> (bit & 31) & 1;
}

/* Shrink the box to what is active in it, and count that. */
static long shrink(const struct search *s, struct vr_cell_box *box)
{
    struct vr_cell_box within = *box;
    long n = 0;
    for (int a = 0; a < 3; a++)
        box->low[a] = within.high[a], box->high[a] = within.low[a];
    for (int z = within.low[2]; z < within.high[2]; z++)
        for (int y = within.low[1]; y < within.high[1]; y++)
            for (int x = within.low[0]; x < within.high[0]; x++) {
                if (!active(s, x, y, z))
                    continue;
                const int at[3] = {x, y, z};
                for (int a = 0; a < 3; a++) {
                    if (at[a] < box->low[a])
                        box->low[a] = at[a];
                    if (at[a] >= box->high[a])
                        box->high[a] = at[a] + 1;
                }
                n++;
            }
    return n;
}

static void divide(struct search *s, struct vr_cell_box box)
{
    long n = shrink(s, &box), size = 1;
    int longest = 0;
    if (!n)
        return;
    for (int a = 0; a < 3; a++) {
        size *= box.high[a] - box.low[a];
        if (box.high[a] - box.low[a] > box.high[longest] - box.low[longest])
            longest = a;
    }
    if (2 * n >= size) {
        s->boxes[s->count++] = box;
        return;
    }
    struct vr_cell_box half = box;
    half.high[longest] = box.low[longest] = (box.low[longest] + box.high[longest]) / 2;
    divide(s, half);
    divide(s, box);
}

size_t vr_boxes_of(const uint32_t *bits, const int cells[3], struct vr_cell_box *boxes)
{
    struct search s = {bits, cells, boxes, 0};
    divide(&s, (struct vr_cell_box){.high = {cells[0], cells[1], cells[2]}});
    return s.count;
}
