/* Cells from bricks. A cell belongs to the brick of floor / edge, clamped, whose border holds all eight
 * corners, at the volume's edge the repeated ones too.
 *
 * For iso a brick that is not active stands in with a value on its side of the isovalue: cells at which the
 * side could change belong to active ones.
 *
 * Invariants: at most one brick is pinned, and it is let go before the next is asked for, so that a cache of
 * one brick a thread is enough. A brick stays pinned from one ray to the next. */
#include "cells.h"

#include <math.h>
#include <string.h>

static int load_cell(struct vr_cells *base, const int64_t cell[3], struct vr_corners *corners,
                     struct brick_error *err);
static void cell_gradient(struct vr_cells *base, const int64_t cell[3], double gradient[3][8]);

void vr_brick_cells_init(struct vr_brick_cells *cells, const struct brick_volume *volume,
                         struct brick_cache *cache, const struct brick_active_query *query,
                         const uint8_t *states)
{
    bool integral = query->mode == BRICK_MODE_DVR || query->mode == BRICK_MODE_SHADED;
    memset(cells, 0, sizeof *cells);
    cells->grid = brick_volume_grid(volume);
    cells->cache = cache;
    cells->volume = volume;
    cells->transfer = integral ? query->transfer : NULL;
    cells->states = states;
    cells->sides = query->mode == BRICK_MODE_ISO;
    cells->level = query->level;
    cells->cells.load = load_cell;
    cells->cells.gradient = cell_gradient;
    for (int i = 0; i < 3; i++) {
        const struct brick_level *level = &cells->grid->level[query->level];
        cells->cells.dims[i] = level->dims[i];
        cells->cells.scale[i] = level->scale[i];
        cells->cells.offset[i] = level->offset[i];
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
    c->side = NAN;
    if (c->states[c->id - level->first_brick] < BRICK_STATE_ACTIVE) {
        double lo, hi;
        if (c->sides && brick_volume_physical_range(c->volume, c->id, &lo, &hi))
            c->side = c->states[c->id - level->first_brick] == BRICK_STATE_ABOVE ? lo : hi;
        return BRICK_OK;
    }
    brick_grid_place(c->grid, c->id, &c->place);
    int result = brick_cache_pin(c->cache, c->id, &c->data, err);
    if (result) {
        c->data = NULL;
        c->end[0] = c->first[0]; /* owns nothing: asked again next time */
    }
    return result;
}

/* A cell of a brick that is not active. */
static int load_side(const struct vr_brick_cells *c, struct vr_corners *corners)
{
    if (isnan(c->side))
        return 0;
    corners->lo = corners->hi = c->side;
    for (int i = 0; i < 8; i++)
        corners->value[i] = c->side;
    return 1;
}

/* Number of a cell's first voxel in the pinned brick; strides of the axes. */
static size_t first_voxel(const struct vr_brick_cells *c, const int64_t cell[3], size_t stride[3])
{
    stride[0] = 1;
    stride[1] = c->place.stored[0];
    stride[2] = stride[1] * c->place.stored[1];
    size_t first = 0;
    for (int i = 0; i < 3; i++)
        first += (size_t)(cell[i] - c->place.lo[i]) * stride[i];
    return first;
}

static double physical(const struct vr_brick_cells *c, size_t voxel)
{
    return brick_type_load(c->grid->type, c->data, voxel) * c->grid->slope + c->grid->intercept;
}

static int load_cell(struct vr_cells *base, const int64_t cell[3], struct vr_corners *corners,
                     struct brick_error *err)
{
    struct vr_brick_cells *c = (struct vr_brick_cells *)base; /* its first member */
    size_t stride[3];
    for (int i = 0; i < 3; i++)
        if (cell[i] < c->first[i] || cell[i] >= c->end[i]) {
            int result = enter_brick(c, cell, err);
            if (result)
                return result;
            break;
        }
    if (!c->data)
        return load_side(c, corners);
    size_t first = first_voxel(c, cell, stride);
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < 8; i++) {
        double value = physical(c, first + (i & 1) + (i >> 1 & 1) * stride[1] + (i >> 2) * stride[2]);
        if (!isfinite(value))
            return 0;
        lo = fmin(lo, value);
        hi = fmax(hi, value);
        corners->value[i] = value;
    }
    corners->lo = lo;
    corners->hi = hi;
    return !c->transfer || brick_transfer_visible(c->transfer, lo, hi);
}

static void cell_gradient(struct vr_cells *base, const int64_t cell[3], double gradient[3][8])
{
    const struct vr_brick_cells *c = (const struct vr_brick_cells *)base;
    size_t stride[3];
    memset(gradient, 0, 3 * sizeof *gradient);
    if (!c->data)
        return;
    size_t first = first_voxel(c, cell, stride);
    for (int a = 0; a < 3; a++) {
        bool finite = true;
        for (size_t i = 0; i < 8; i++) {
            size_t voxel = first + (i & 1) + (i >> 1 & 1) * stride[1] + (i >> 2) * stride[2];
            double behind = physical(c, voxel - stride[a]), ahead = physical(c, voxel + stride[a]);
            finite = finite && isfinite(behind) && isfinite(ahead);
            gradient[a][i] = 0.5 * (ahead - behind);
        }
        if (!finite)
            memset(gradient[a], 0, sizeof gradient[a]);
    }
}
