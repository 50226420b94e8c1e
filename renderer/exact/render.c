/* The exact reference: tiles of pixels over all cores, each ray integrated by march.c.
 *
 * A pixel depends on nothing but its own ray, so neither the number of threads nor the cache's size changes a
 * bit. */
#include <renderer/renderer.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>
#include <brick/threads.h>

#include "cells.h"

#define TILE          16
#define MIN_TOLERANCE 1e-13 /* what rounding in double precision leaves room for */

const struct vr_exact_params vr_exact_defaults = {
    .host_cache_bytes = UINT64_C(1) << 30,
    .threads = 0,
    .tolerance = 1e-10,
};

struct worker {
    struct vr_brick_cells cells;
    uint64_t evaluations;
};

struct frame {
    const struct brick_grid *grid;
    const struct brick_transfer *transfer;
    struct brick_view view;
    struct brick_image *image;
    double tolerance;
    uint32_t tiles_x, tiles_y;
    struct worker *workers;
};

static int render_pixel(struct frame *frame, struct worker *worker, uint32_t x, uint32_t y,
                        struct brick_error *err)
{
    float *rgba = &frame->image->rgba[((size_t)y * frame->image->width + x) * 4];
    struct vr_ray_integral integral = {0};
    struct brick_ray ray;
    double t_enter_mm, t_leave_mm;
    brick_view_ray(&frame->view, x, y, &ray);
    if (brick_ray_span(&ray, frame->grid, &t_enter_mm, &t_leave_mm)) {
        int result = vr_march(&worker->cells.cells, frame->transfer, &ray, t_enter_mm, t_leave_mm,
                              frame->tolerance, &integral, err);
        if (result)
            return result;
    }
    for (int c = 0; c < 3; c++)
        rgba[c] = (float)integral.rgb[c];
    rgba[3] = (float)-expm1(-integral.depth);
    worker->evaluations += integral.evaluations;
    return BRICK_OK;
}

static int render_tile(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct frame *frame = context;
    uint32_t x0 = (uint32_t)(item % frame->tiles_x) * TILE, y0 = (uint32_t)(item / frame->tiles_x) * TILE;
    for (uint32_t y = y0; y < y0 + TILE && y < frame->image->height; y++)
        for (uint32_t x = x0; x < x0 + TILE && x < frame->image->width; x++) {
            int result = render_pixel(frame, &frame->workers[worker], x, y, err);
            if (result)
                return result;
        }
    return BRICK_OK;
}

static int check(const struct brick_grid *grid, const struct vr_scene *scene,
                 const struct vr_exact_params *params, const struct brick_image *image,
                 struct brick_error *err)
{
    if (scene->mode != BRICK_MODE_DVR)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "the exact method renders mode dvr only");
    if (!scene->transfer)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: mode dvr needs a transfer function");
    if (scene->level >= grid->levels)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: no level %u; the file has %u", scene->level,
                          grid->levels);
    if (!image->rgba || image->width != scene->width || image->height != scene->height)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: the picture is %u x %u, the scene %u x %u",
                          image->width, image->height, scene->width, scene->height);
    if (!(params->tolerance >= MIN_TOLERANCE && params->tolerance < 1.0))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: a tolerance of %g; %g or more is possible",
                          params->tolerance, MIN_TOLERANCE);
    return BRICK_OK;
}

/* Each thread pins a brick, so no more of them than bricks in the cache. */
static unsigned thread_count(const struct brick_grid *grid, const struct vr_exact_params *params)
{
    unsigned threads = params->threads ? params->threads : brick_cores();
    uint64_t bricks = params->host_cache_bytes / brick_grid_max_payload_bytes(grid);
    if (threads > bricks)
        threads = (unsigned)bricks;
    return threads ? threads : 1;
}

int vr_render_exact(const struct brick_volume *volume, const struct vr_scene *scene,
                    const struct vr_exact_params *params, struct brick_image *image, struct vr_report *report,
                    struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    struct frame frame = {
        .grid = grid, .transfer = scene->transfer, .image = image, .tolerance = params->tolerance};
    struct brick_cache *cache = NULL;
    struct brick_pool *pool = NULL;
    struct brick_cache_counters counters;
    uint8_t *states = NULL;
    unsigned threads = 0;
    uint64_t started_ns = brick_now_ns(), bricks, active, evaluations = 0;

    int result = check(grid, scene, params, image, err);
    if (result)
        return result;
    result = brick_view_init(&frame.view, &scene->camera, grid, scene->width, scene->height, err);
    if (result)
        return result;
    const struct brick_level *level = &grid->level[scene->level];
    if (!brick_mul3_u64(level->bricks[0], level->bricks[1], level->bricks[2], &bricks) ||
        !(states = malloc((size_t)bricks)))
        return brick_fail(err, BRICK_ERR_MEMORY, "exact: no memory for the states of the level's bricks");
    const struct brick_active_query query = {
        .mode = BRICK_MODE_DVR, .transfer = scene->transfer, .level = scene->level};
    active = brick_active_set(volume, &query, states);

    result = brick_cache_create(&cache, volume, params->host_cache_bytes, err);
    if (result)
        goto fail;
    result = brick_pool_create(&pool, thread_count(grid, params), err);
    if (result)
        goto fail;
    frame.workers = calloc(brick_pool_threads(pool), sizeof *frame.workers);
    if (!frame.workers) {
        result = brick_fail(err, BRICK_ERR_MEMORY, "exact: no memory for the threads' state");
        goto fail;
    }
    threads = brick_pool_threads(pool);
    for (unsigned i = 0; i < threads; i++)
        vr_brick_cells_init(&frame.workers[i].cells, volume, cache, scene->transfer, states, scene->level);
    frame.tiles_x = (image->width + TILE - 1) / TILE;
    frame.tiles_y = (image->height + TILE - 1) / TILE;
    result = brick_pool_run(pool, (uint64_t)frame.tiles_x * frame.tiles_y, render_tile, &frame, err);
    if (result)
        goto fail;

    for (unsigned i = 0; i < threads; i++)
        evaluations += frame.workers[i].evaluations;
    brick_cache_count(cache, &counters);
    if (report)
        *report = (struct vr_report){.passes = 1,
                                     .bricks_total = bricks,
                                     .bricks_active = active,
                                     .bricks_loaded = counters.loads,
                                     .bytes_read = counters.bytes_read,
                                     .samples = evaluations,
                                     .seconds_frame = (double)(brick_now_ns() - started_ns) * 1e-9};
fail:
    for (unsigned i = 0; i < threads; i++)
        vr_brick_cells_finish(&frame.workers[i].cells);
    free(frame.workers);
    brick_pool_destroy(&pool);
    brick_cache_destroy(&cache);
    free(states);
    return result;
}
