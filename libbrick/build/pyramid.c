/* Every level holds edge + 2 border slices, just what a row of bricks needs; each arriving slice may complete
 * a row (emitted at once) and a slice of the next level (computed at once, recursively). So memory is that of
 * a few slices a level, every voxel is touched once, and the order of emissions depends on the sizes alone.
 */
#include "pyramid.h"

#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>

#include "downsample.h"

static uint64_t window_capacity(const struct brick_grid *grid, uint32_t level)
{
    uint64_t slices = (uint64_t)grid->edge + 2 * grid->border, n = grid->level[level].dims[2];
    return slices < n ? slices : n;
}

static uint64_t slice_bytes(const struct brick_grid *grid, uint32_t level)
{
    return grid->level[level].dims[0] * grid->level[level].dims[1] * brick_type_bytes(grid->type);
}

uint64_t pyramid_bytes(const struct brick_grid *grid)
{
    uint64_t sum = 0, part;
    for (uint32_t l = 0; l < grid->levels; l++)
        if (!brick_mul3_u64(slice_bytes(grid, l), window_capacity(grid, l), l ? 3 : 1, &part) ||
            !brick_add_u64(sum, part, &sum))
            return UINT64_MAX;
    return sum;
}

int pyramid_init(struct pyramid *p, const struct brick_grid *grid, struct brick_pool *pool, bool nearest,
                 pyramid_emit *emit, void *context, struct brick_error *err)
{
    memset(p, 0, sizeof *p);
    p->grid = grid;
    p->pool = pool;
    p->nearest = nearest;
    p->emit = emit;
    p->context = context;
    for (uint32_t l = 0; l < grid->levels; l++) {
        struct window *w = &p->window[l];
        w->level = &grid->level[l];
        w->slice_bytes = (size_t)slice_bytes(grid, l);
        w->capacity = window_capacity(grid, l);
        size_t bytes = w->slice_bytes * w->capacity;
        w->voxels = malloc(bytes);
        w->min = l ? malloc(bytes) : w->voxels;
        w->max = l ? malloc(bytes) : w->voxels;
        if (!w->voxels || !w->min || !w->max) {
            pyramid_finish(p);
            return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for slabs of %llu bytes",
                              (unsigned long long)pyramid_bytes(grid));
        }
    }
    return BRICK_OK;
}

void pyramid_finish(struct pyramid *p)
{
    for (uint32_t l = 0; l < BRICK_MAX_LEVELS; l++) {
        free(p->window[l].voxels);
        if (l) {
            free(p->window[l].min);
            free(p->window[l].max);
        }
    }
    memset(p->window, 0, sizeof p->window);
}

/* Slices that row `row` needs: [0, row_end). */
static uint64_t row_end(const struct pyramid *p, const struct window *w, uint64_t row)
{
    uint64_t end = (row + 1) * p->grid->edge + p->grid->border;
    return end < w->level->dims[2] ? end : w->level->dims[2];
}

void *pyramid_room(struct pyramid *p, uint64_t *count)
{
    struct window *w = &p->window[0];
    uint64_t n = row_end(p, w, w->next_row) - w->filled, unwrapped = w->capacity - w->filled % w->capacity;
    *count = n < unwrapped ? n : unwrapped;
    return w->voxels + window_slot(w, w->filled);
}

struct downsample_job {
    const struct window *fine, *coarse;
    enum brick_type type;
    bool halved[3], nearest;
    uint64_t z, rows_a_item;
};

static int downsample_item(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    (void)worker;
    (void)err;
    const struct downsample_job *j = context;
    uint64_t end = (item + 1) * j->rows_a_item;
    if (end > j->coarse->level->dims[1])
        end = j->coarse->level->dims[1];
    for (uint64_t y = item * j->rows_a_item; y < end; y++)
        downsample_row(kernels_best(), j->fine, j->coarse, j->halved, j->type, j->nearest, y, j->z);
    return BRICK_OK;
}

static int advance(struct pyramid *p, uint32_t l, struct brick_error *err)
{
    struct window *w = &p->window[l];
    while (w->next_row < w->level->bricks[2] && w->filled >= row_end(p, w, w->next_row)) {
        int code = p->emit(p->context, l, w->next_row, w, err);
        if (code)
            return code;
        w->next_row++;
    }
    if (l + 1 == p->grid->levels)
        return BRICK_OK;
    struct window *coarse = &p->window[l + 1];
    struct downsample_job job = {.fine = w, .coarse = coarse, .type = p->grid->type, .nearest = p->nearest};
    for (int a = 0; a < 3; a++)
        job.halved[a] = coarse->level->scale[a] > w->level->scale[a];
    /* Items of about 64 KiB of input, so that a slice is worth sharing out. */
    job.rows_a_item = 1 + 16384 / (w->level->dims[0] * brick_type_bytes(p->grid->type));
    for (;;) {
        job.z = coarse->filled;
        uint64_t needs = job.halved[2] ? 2 * job.z + 2 : job.z + 1;
        if (needs > w->level->dims[2])
            needs = w->level->dims[2];
        if (job.z == coarse->level->dims[2] || w->filled < needs)
            return BRICK_OK;
        uint64_t items = (coarse->level->dims[1] + job.rows_a_item - 1) / job.rows_a_item;
        int code = brick_pool_run(p->pool, items, downsample_item, &job, err);
        coarse->filled++;
        if (code || (code = advance(p, l + 1, err)))
            return code;
    }
}

int pyramid_push(struct pyramid *p, uint64_t count, struct brick_error *err)
{
    p->window[0].filled += count;
    return advance(p, 0, err);
}
