/* Boxes of a regular grid are in visibility order when each axis is walked from the far side to the near one,
 * whatever the axes' nesting: that is what makes eight orders enough for parallel rays. Those of a
 * perspective run away from the eye on each axis, to either side of it, so an axis is walked from both ends
 * to where the eye is; parallel rays are the limit of an eye beyond one end. It holds for bricks, for the
 * macrocells of a brick and for the cells of a macrocell, so whole macrocells are passed over at the cost of
 * one test.
 *
 * Cell c spans voxels c and c + 1. A brick has the cells of its own voxels, and at the volume's low side
 * those half cells in front of its first ones; the last ones at the high side are half cells too. */
#include "walk.h"

#include <math.h>

static bool at_low_side(const struct vr_cell_walk *w, int axis)
{
    return w->first[axis] == 0;
}

void vr_cell_walk_init(struct vr_cell_walk *w, const struct brick_grid *grid, const struct brick_place *place)
{
    w->level = &grid->level[place->level];
    w->macrocell = grid->macrocell;
    for (int a = 0; a < 3; a++) {
        w->first[a] = place->lo[a] + (int64_t)grid->border;
        w->core[a] = place->core[a];
        w->macrocells[a] = place->macrocells[a];
    }
}

size_t vr_cell_walk_most(const struct vr_cell_walk *w)
{
    size_t edge = (size_t)w->macrocell + 1;
    return 2 * edge * edge * edge;
}

/* Of count boxes in a row, each of length edge, the first one beginning at `begin`: which one the eye is in,
 * or the one nearest to it. */
static int32_t nearest(double eye, double begin, double edge, int32_t count)
{
    return (int32_t)fmin(fmax(floor((eye - begin) / edge), 0.0), count - 1.0);
}

/* Number `turn` from back to front of count boxes in a row: those below the nearest upwards, then the others
 * downwards. */
static int32_t from_back(int32_t turn, int32_t nearest, int32_t count)
{
    return turn < nearest ? turn : count - 1 - (turn - nearest);
}

static uint32_t piece(const int32_t cell[3], uint32_t number)
{
    return (uint32_t)(cell[0] + 1) | (uint32_t)(cell[1] + 1) << 9 | (uint32_t)(cell[2] + 1) << 18 |
           number << VR_CELL_PIECE_BIT;
}

static int outside(const struct vr_cell_walk *w, int axis, int32_t cell)
{
    int64_t at = w->first[axis] + cell;
    return at < 0 || at + 1 == (int64_t)w->level->dims[axis];
}

size_t vr_cell_walk_macrocell(const struct vr_cell_walk *w, uint32_t turn, uint32_t *entries)
{
    const uint32_t turns[3] = {turn % w->macrocells[0], turn / w->macrocells[0] % w->macrocells[1],
                               turn / w->macrocells[0] / w->macrocells[1]};
    uint32_t m[3];
    int32_t begin[3], count[3], near[3], cell[3];
    double low[3], high[3];
    size_t n = 0;
    for (int a = 0; a < 3; a++) {
        int32_t macrocells = (int32_t)w->macrocells[a];
        int32_t eye = nearest(w->eye[a], (double)w->first[a], w->macrocell, macrocells);
        m[a] = (uint32_t)from_back((int32_t)turns[a], eye, macrocells);
        int32_t end = (int32_t)((m[a] + 1) * w->macrocell);
        if (end > (int32_t)w->core[a])
            end = (int32_t)w->core[a];
        begin[a] = m[a] == 0 && at_low_side(w, a) ? -1 : (int32_t)(m[a] * w->macrocell);
        count[a] = end - begin[a];
        low[a] = (double)(w->first[a] + begin[a]);
        high[a] = (double)(w->first[a] + end);
        near[a] = nearest(w->eye[a], low[a], 1.0, count[a]);
    }
    uint32_t bit = m[0] + m[1] * w->macro_strides[0] + m[2] * w->macro_strides[1];
    if ((w->active && !(w->active[bit / 32] >> bit % 32 & 1)) || !w->visible(w->visible_context, low, high))
        return 0;
    for (int32_t z = 0; z < count[2]; z++)
        for (int32_t y = 0; y < count[1]; y++) {
            cell[1] = begin[1] + from_back(y, near[1], count[1]);
            cell[2] = begin[2] + from_back(z, near[2], count[2]);
            int rim = outside(w, 1, cell[1]) + outside(w, 2, cell[2]);
            for (int32_t x = 0; x < count[0]; x++) {
                cell[0] = begin[0] + from_back(x, near[0], count[0]);
                bool six = rim + outside(w, 0, cell[0]) == 1;
                entries[n++] = piece(cell, w->whole && six);
                if (!w->whole && six)
                    entries[n++] = piece(cell, 1);
            }
        }
    return n;
}

uint64_t vr_cell_tetrahedra(const struct brick_level *level)
{
    const uint64_t x = level->dims[0], y = level->dims[1], z = level->dims[2];
    return 5 * (x + 1) * (y + 1) * (z + 1) + 2 * ((x - 1) * (y - 1) + (y - 1) * (z - 1) + (z - 1) * (x - 1));
}
