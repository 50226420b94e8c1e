/* Cells from bricks. A cell belongs to the brick of floor / edge, clamped, whose border holds all eight
 * corners, at the volume's edge the repeated ones too.
 *
 * Invariants: at most one brick is pinned, and it is let go before the next is asked for, so that a cache of
 * one brick a thread is enough. A brick stays pinned from one ray to the next. */
#include "cells.h"

#include <math.h>
#include <string.h>

#include <brick/active.h>

static int load_cell(struct vr_cells *base, const int64_t cell[3], double corners[8],
                     struct brick_error *err);

void vr_brick_cells_init(struct vr_brick_cells *cells, const struct brick_volume *volume,
                         struct brick_cache *cache, const struct brick_transfer *transfer,
                         const uint8_t *states, uint32_t level)
{
    memset(cells, 0, sizeof *cells);
    cells->grid = brick_volume_grid(volume);
    cells->cache = cache;
    cells->transfer = transfer;
    cells->states = states;
    cells->level = level;
    cells->cells.load = load_cell;
    for (int i = 0; i < 3; i++) {
        cells->cells.dims[i] = cells->grid->level[level].dims[i];
        cells->cells.scale[i] = cells->grid->level[level].scale[i];
        cells->cells.offset[i] = cells->grid->level[level].offset[i];
    }
}

void vr_brick_cells_finish(struct vr_brick_cells *cells)
{
    if (cells->data)
        brick_cache_unpin(cells->cache, cells->id);
    cells->data = NULL;
}

static int enter_brick(struct vr_brick_cells *c, const int64_t cell[3], struct brick_error *err)
{
    const struct brick_level *level = &c->grid->level[c->level];
    uint64_t at[3];
    vr_brick_cells_finish(c);
    for (int i = 0; i < 3; i++) {
        at[i] = (cell[i] > 0 ? (uint64_t)cell[i] : 0) / c->grid->edge;
        c->first[i] = at[i] == 0 ? -1 : (int64_t)(at[i] * c->grid->edge);
        c->end[i] = (int64_t)((at[i] + 1) * c->grid->edge);
    }
    c->id = brick_grid_id(c->grid, c->level, at[0], at[1], at[2]);
    if (c->states[c->id - level->first_brick] != BRICK_STATE_ACTIVE)
        return BRICK_OK;
    brick_grid_place(c->grid, c->id, &c->place);
    int result = brick_cache_pin(c->cache, c->id, &c->data, err);
    if (result) {
        c->data = NULL;
        c->end[0] = c->first[0]; /* owns nothing: asked again next time */
    }
    return result;
}

static int load_cell(struct vr_cells *base, const int64_t cell[3], double corners[8], struct brick_error *err)
{
    struct vr_brick_cells *c = (struct vr_brick_cells *)base; /* its first member */
    size_t at[3];
    for (int i = 0; i < 3; i++)
        if (cell[i] < c->first[i] || cell[i] >= c->end[i]) {
            int result = enter_brick(c, cell, err);
            if (result)
                return result;
            break;
        }
    if (!c->data)
        return 0;
    for (int i = 0; i < 3; i++)
        at[i] = (size_t)(cell[i] - c->place.lo[i]);
    size_t row = c->place.stored[0], slice = row * c->place.stored[1];
    size_t first = at[2] * slice + at[1] * row + at[0];
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < 8; i++) {
        size_t voxel = first + (i & 1) + (i >> 1 & 1) * row + (i >> 2) * slice;
        double value = brick_type_load(c->grid->type, c->data, voxel) * c->grid->slope + c->grid->intercept;
        if (!isfinite(value))
            return 0;
        lo = fmin(lo, value);
        hi = fmax(hi, value);
        corners[i] = value;
    }
    return brick_transfer_visible(c->transfer, lo, hi);
}
