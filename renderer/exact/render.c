/* The exact reference: tiles of pixels over all cores, each ray followed by trace.c.
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
#include "mesh_tree.h"
#include "scene.h"
#include "trace.h"

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
    const struct vr_scene *scene;
    struct vr_look look;
    struct brick_view view;
    struct brick_image *image;
    double *hit_mm;
    uint32_t tiles_x, tiles_y;
    struct worker *workers;
    struct vr_clip clip;
    struct vr_mesh_view meshes;
};

static int render_pixel(struct frame *frame, struct worker *worker, uint32_t x, uint32_t y,
                        struct brick_error *err)
{
    size_t pixel = (size_t)y * frame->image->width + x;
    float *rgba = &frame->image->rgba[4 * pixel];
    struct vr_traced traced = {.hit_mm = INFINITY};
    struct brick_ray ray;
    double t_enter_mm, t_leave_mm, mesh_rgb[3];
    const double mesh_mm = vr_mesh_view_pixel(&frame->meshes, x, y, mesh_rgb);
    brick_view_ray(&frame->view, x, y, &ray);
    if (brick_ray_span(&ray, frame->grid, &t_enter_mm, &t_leave_mm) &&
        vr_clip_span(&frame->clip, &ray, &t_enter_mm, &t_leave_mm) && t_enter_mm < mesh_mm) {
        t_leave_mm = fmin(t_leave_mm, mesh_mm);
        int result = vr_trace(&frame->look, &worker->cells.cells, &ray, t_enter_mm, t_leave_mm, &traced, err);
        if (result)
            return result;
    }
    if (mesh_mm < INFINITY) { /* behind all that the ray has gathered, and nothing is behind it */
        for (int c = 0; c < 3; c++)
            traced.light.rgb[c] += exp(-traced.light.depth) * mesh_rgb[c];
        traced.light.depth = INFINITY;
    }
    for (int c = 0; c < 3; c++)
        rgba[c] = (float)traced.light.rgb[c];
    rgba[3] = (float)-expm1(-traced.light.depth);
    if (frame->hit_mm)
        frame->hit_mm[pixel] = traced.hit_mm;
    worker->evaluations += traced.light.evaluations;
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
    bool iso = scene->mode == BRICK_MODE_ISO;
    if ((unsigned)scene->mode > BRICK_MODE_MIP || (unsigned)params->field > VR_FIELD_PRECLASSIFIED)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: no mode %d or no field %d", (int)scene->mode,
                          (int)params->field);
    if (params->field == VR_FIELD_PRECLASSIFIED && (iso || scene->mode == BRICK_MODE_MIP))
        return brick_fail(
            err, BRICK_ERR_UNSUPPORTED,
            "exact: a field of pre-classified voxels has colours, but no values for iso or mip");
    if (!iso && !scene->transfer)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: this mode needs a transfer function");
    if (iso && !isfinite(scene->isovalue))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: the isovalue is not finite");
    if (scene->level >= grid->levels)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: no level %u; the file has %u", scene->level,
                          grid->levels);
    if (!image->rgba || image->width != scene->width || image->height != scene->height)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: the picture is %u x %u, the scene %u x %u",
                          image->width, image->height, scene->width, scene->height);
    if (!(params->tolerance >= MIN_TOLERANCE && params->tolerance < 1.0))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "exact: a tolerance of %g; %g or more is possible",
                          params->tolerance, MIN_TOLERANCE);
    return vr_scene_check_parts(scene, err);
}

static void set_look(struct vr_look *look, const struct brick_grid *grid, const struct vr_scene *scene,
                     const struct vr_exact_params *params)
{
    double inverse[3][4], sigma;
    *look = (struct vr_look){.mode = scene->mode,
                             .field = params->field,
                             .transfer = scene->transfer,
                             .tolerance = 0.9 * params->tolerance, /* the rest is for ending early */
                             .isovalue = scene->isovalue,
                             .ambient = scene->ambient,
                             .diffuse = scene->diffuse,
                             .specular = scene->specular,
                             .shininess = scene->shininess};
    memcpy(look->surface, scene->iso_rgb, sizeof look->surface);
    if (scene->mode == BRICK_MODE_ISO && scene->transfer)
        brick_transfer_eval(scene->transfer, scene->isovalue, look->surface, &sigma);
    /* Gradients turn by the inverse, transposed, of the affine times the level's scale. */
    brick_affine_invert(grid->affine, inverse);
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++) {
            look->linear[i][a] = grid->affine[i][a];
            look->normal[i][a] = inverse[a][i] / grid->level[scene->level].scale[a];
        }
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
    struct frame frame = {.grid = grid, .scene = scene, .image = image, .hit_mm = params->hit_mm};
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
    const struct brick_active_query query = {scene->mode, scene->transfer, scene->isovalue, scene->level};
    active = brick_active_set(volume, &query, states);
    set_look(&frame.look, grid, scene, params);
    vr_scene_clip(scene, grid, &frame.clip);

    result = vr_mesh_view_begin(&frame.meshes, scene, grid, &frame.view, err);
    if (result)
        goto fail;
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
        vr_brick_cells_init(&frame.workers[i].cells, volume, cache, &query, states);
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
    vr_mesh_view_finish(&frame.meshes);
    brick_pool_destroy(&pool);
    brick_cache_destroy(&cache);
    free(states);
    return result;
}
