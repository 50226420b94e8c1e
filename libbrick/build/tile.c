/* Tiles. Invariant: following tile_next through a row meets its bricks in ascending order, every one once.
 * Cores begin at multiples of the brick's edge, which is even: no coarse voxel is made from two tiles. */
#include "tile.h"

static uint64_t least(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

struct tile tile_first(const struct brick_grid *grid, const uint64_t shape[2], uint32_t level, uint64_t row)
{
    const uint64_t *bricks = grid->level[level].bricks;
    return (struct tile){level, row, {0, 0}, {least(shape[0], bricks[0]), least(shape[1], bricks[1])}};
}

bool tile_next(const struct brick_grid *grid, const uint64_t shape[2], struct tile *t)
{
    const uint64_t *bricks = grid->level[t->level].bricks;
    t->from[0] = t->to[0];
    if (t->from[0] == bricks[0]) {
        t->from[0] = 0;
        t->from[1] = t->to[1];
    }
    t->to[0] = least(t->from[0] + shape[0], bricks[0]);
    t->to[1] = least(t->from[1] + shape[1], bricks[1]);
    return t->from[1] < bricks[1];
}

uint64_t tile_first_brick(const struct brick_grid *grid, const struct tile *t)
{
    return brick_grid_id(grid, t->level, t->from[0], t->from[1], t->row);
}

uint64_t tile_bricks(const struct tile *t)
{
    return (t->to[0] - t->from[0]) * (t->to[1] - t->from[1]);
}

struct box tile_core(const struct brick_grid *grid, const struct tile *t)
{
    const uint64_t from[3] = {t->from[0], t->from[1], t->row}, to[3] = {t->to[0], t->to[1], t->row + 1};
    struct box box;
    for (int a = 0; a < 3; a++) {
        box.lo[a] = from[a] * grid->edge;
        box.hi[a] = least(to[a] * grid->edge, grid->level[t->level].dims[a]);
    }
    return box;
}

struct box tile_stored(const struct brick_grid *grid, const struct tile *t)
{
    struct box box = tile_core(grid, t);
    for (int a = 0; a < 3; a++) {
        box.lo[a] -= least(box.lo[a], grid->border);
        box.hi[a] = least(box.hi[a] + grid->border, grid->level[t->level].dims[a]);
    }
    return box;
}

struct box tile_coarse(const struct brick_grid *grid, const struct tile *t, bool halved[3])
{
    const struct brick_level *fine = &grid->level[t->level], *coarse = fine + 1;
    struct box box = tile_core(grid, t);
    for (int a = 0; a < 3; a++) {
        halved[a] = coarse->scale[a] > fine->scale[a];
        if (halved[a]) {
            box.lo[a] /= 2;
            box.hi[a] = (box.hi[a] + 1) / 2;
        }
    }
    return box;
}
