/* Isosurfaces by ray tracing: from a scene to a picture (Parker et al. 1998).
 *
 * Tiles of 16 x 8 pixels wait in a queue; each thread takes as many as are left divided by 8 times the
 * threads, so that grants are large at first and single tiles at the end (section 2.2). A pixel depends on
 * nothing but its own ray: neither threads nor cache change a bit. */
#include <renderer/renderer.h>

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <brick/checked.h>
#include <brick/threads.h>

#include "bounds.h"
#include "layout.h"
#include "map.h"
#include "pins.h"
#include "scene.h"
#include "shade.h"
#include "split.h"

enum { TILE_WIDTH = 16, TILE_HEIGHT = 8, TILE_PIXELS = TILE_WIDTH * TILE_HEIGHT };
_Static_assert((int)TILE_PIXELS <= (int)VR_ISO_RAYS, "a tile is traced in one go");

const struct vr_isotracer_params vr_isotracer_defaults = {.host_cache_bytes = UINT64_C(1) << 30};
const struct vr_isotrace_params vr_isotrace_defaults = {.termination = 1e-4, .skip = true};

struct worker {
    struct vr_iso_activity activity;
    struct vr_iso_pin pin;
    struct vr_iso_walk walk[TILE_PIXELS], shadow[TILE_PIXELS];
    struct brick_ray ray[TILE_PIXELS];
};

struct vr_isotracer {
    const struct brick_volume *volume;
    const struct brick_grid *grid;
    uint64_t budget_bytes;
    struct brick_cache *cache;
    struct brick_pool *pool;
    struct worker *workers;
    unsigned threads;
    struct vr_iso_layout_copy copy;
    struct vr_iso_map map;
    struct vr_iso_bounds bounds;
};

struct picture {
    struct vr_isotracer *tracer;
    struct vr_iso_frame frame;
    struct vr_iso_shading shading;
    struct brick_view view;
    struct vr_clip clip;
    struct brick_image *image;
    uint32_t tiles_x, tiles;
    atomic_uint_fast32_t next; /* tiles handed out */
    atomic_bool stop;          /* a thread has failed */
};

int vr_isotracer_create(struct vr_isotracer **out, const struct brick_volume *volume,
                        const struct vr_isotracer_params *params, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    uint64_t bricks = params->host_cache_bytes / brick_grid_max_payload_bytes(grid);
    unsigned threads = params->threads ? params->threads : brick_cores();
    *out = NULL;
    struct vr_isotracer *t = calloc(1, sizeof *t);
    if (!t)
        return brick_fail(err, BRICK_ERR_MEMORY, "isotrace: out of memory");
    t->volume = volume;
    t->grid = grid;
    t->budget_bytes = params->host_cache_bytes;
    t->copy.layout = params->layout;
    int code = brick_cache_create(&t->cache, volume, params->host_cache_bytes, err);
    if (code)
        goto fail;
    if (threads > bricks)
        threads = (unsigned)bricks;
    code = brick_pool_create(&t->pool, threads, err);
    if (code)
        goto fail;
    t->workers = calloc(threads, sizeof *t->workers);
    if (!t->workers) {
        code = brick_fail(err, BRICK_ERR_MEMORY, "isotrace: no memory for %u threads", threads);
        goto fail;
    }
    t->threads = threads;
    *out = t;
    return BRICK_OK;
fail:
    vr_isotracer_destroy(&t);
    return code;
}

void vr_isotracer_destroy(struct vr_isotracer **tracer)
{
    struct vr_isotracer *t = *tracer;
    if (!t)
        return;
    for (unsigned i = 0; i < t->threads; i++)
        for (int k = 0; k < TILE_PIXELS; k++) {
            vr_iso_walk_finish(&t->workers[i].walk[k]);
            vr_iso_walk_finish(&t->workers[i].shadow[k]);
        }
    free(t->workers);
    vr_iso_layout_finish(&t->copy);
    vr_iso_map_finish(&t->map);
    vr_iso_bounds_finish(&t->bounds);
    brick_pool_destroy(&t->pool);
    brick_cache_destroy(&t->cache);
    free(t);
    *tracer = NULL;
}

static int trace_shadows(struct worker *w, struct vr_iso_hit *const *lit, size_t n, struct brick_error *err)
{
    int code = vr_iso_trace(w->shadow, n, &w->pin, err);
    for (size_t i = 0; i < n && !code; i++)
        lit[i]->light = w->shadow[i].transmittance;
    return code;
}

/* How much of the light reaches each of the tile's hits. */
static int cast_shadows(const struct picture *p, struct worker *w, size_t n, struct brick_error *err)
{
    struct vr_iso_hit *lit[TILE_PIXELS];
    size_t waiting = 0;
    int code = BRICK_OK;
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < w->walk[i].hit_count && !code; k++) {
            struct brick_ray to_light;
            double enter, leave;
            lit[waiting] = &w->walk[i].hits[k];
            if (!vr_iso_shadow_ray(&p->shading, &w->ray[i], lit[waiting], &to_light, &enter, &leave) ||
                !vr_clip_span(&p->clip, &to_light, &enter, &leave)) /* what is cut away casts no shadow */
                continue;
            vr_iso_start(&w->shadow[waiting], &to_light, enter, leave);
            if (++waiting == TILE_PIXELS) {
                code = trace_shadows(w, lit, waiting, err);
                waiting = 0;
            }
        }
    return code ? code : trace_shadows(w, lit, waiting, err);
}

static int render_tile(const struct picture *p, struct worker *w, uint32_t tile, struct brick_error *err)
{
    const uint32_t x0 = tile % p->tiles_x * TILE_WIDTH, y0 = tile / p->tiles_x * TILE_HEIGHT,
                   x1 = x0 + TILE_WIDTH < p->image->width ? x0 + TILE_WIDTH : p->image->width,
                   y1 = y0 + TILE_HEIGHT < p->image->height ? y0 + TILE_HEIGHT : p->image->height;
    float *rgba[TILE_PIXELS];
    struct vr_iso_reach reach = {0};
    size_t n = 0;
    for (uint32_t y = y0; y < y1; y++) {
        float *row = &p->image->rgba[(size_t)y * p->image->width * 4];
        memset(row + 4 * x0, 0, (x1 - x0) * 4 * sizeof *row);
        for (uint32_t x = x0; x < x1; x++) {
            double enter, leave;
            if (x % VR_ISO_BLOCK == 0)
                reach = vr_iso_bounds_of(&p->tracer->bounds, x, y);
            if (!(reach.near < reach.far))
                continue;
            rgba[n] = row + 4 * x;
            brick_view_ray(&p->view, x, y, &w->ray[n]);
            if (!brick_ray_span(&w->ray[n], p->frame.grid, &enter, &leave) ||
                !vr_clip_span(&p->clip, &w->ray[n], &enter, &leave))
                continue;
            enter = enter > (double)reach.near ? enter : (double)reach.near;
            leave = leave < (double)reach.far ? leave : (double)reach.far;
            if (!(enter < leave))
                continue;
            vr_iso_start(&w->walk[n], &w->ray[n], enter, leave);
            n++;
        }
    }
    int code = vr_iso_trace(w->walk, n, &w->pin, err);
    vr_iso_now(&w->activity, VR_ISO_SHADING);
    if (!code && p->shading.shadows)
        code = cast_shadows(p, w, n, err);
    for (size_t i = 0; i < n && !code; i++)
        if (w->walk[i].hit_count)
            vr_iso_shade(&p->shading, &w->walk[i], &w->ray[i], rgba[i]);
    vr_iso_now(&w->activity, VR_ISO_TRAVERSAL);
    return code;
}

/* The next grant: tiles [*first, return value). */
static uint32_t take_grant(struct picture *p, uint32_t *first)
{
    uint_fast32_t at = atomic_load(&p->next), end;
    do {
        uint_fast32_t share = (p->tiles - at) / (8 * p->tracer->threads);
        end = at + (share ? share : 1);
        if (at >= p->tiles)
            end = at;
    } while (!atomic_compare_exchange_weak(&p->next, &at, end));
    *first = (uint32_t)at;
    return (uint32_t)end;
}

static int work(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct picture *p = context;
    uint32_t tile, end;
    (void)item;
    while (tile = 0, end = take_grant(p, &tile), tile < end)
        for (; tile < end && !atomic_load_explicit(&p->stop, memory_order_relaxed); tile++) {
            int code = render_tile(p, &p->tracer->workers[worker], tile, err);
            if (code) {
                atomic_store(&p->stop, true);
                return code;
            }
        }
    return BRICK_OK;
}

static int check(const struct brick_grid *grid, const struct vr_scene *scene,
                 const struct vr_isotrace_params *params, const struct brick_image *image,
                 struct brick_error *err)
{
    if (scene->level >= grid->levels)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "there is no level %u; the last is %u", scene->level,
                          grid->levels - 1);
    if (image->width != scene->width || image->height != scene->height)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the image's size is not the scene's");
    if (scene->mesh_count > 0)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "isotrace draws no meshes; raycast and the exact method do");
    if (params->surface_count > VR_ISO_MAX_SURFACES)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%u isosurfaces are more than %d", params->surface_count,
                          VR_ISO_MAX_SURFACES);
    if (!(params->termination >= 0.0 && params->termination < 1.0))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the termination %g is not in [0,1)", params->termination);
    for (uint32_t k = 0; k < params->surface_count; k++)
        if (!isfinite(params->surfaces[k].isovalue) ||
            !(params->surfaces[k].opacity >= 0.0 && params->surfaces[k].opacity <= 1.0))
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "isosurface %u: the value is not finite, or the opacity not "
                              "in [0,1]",
                              k);
    if (!params->surface_count && !isfinite(scene->isovalue))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the isovalue is not finite");
    const double *l = params->light;
    if (params->lit && !(isfinite(l[0] + l[1] + l[2]) && (l[0] != 0.0 || l[1] != 0.0 || l[2] != 0.0)))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the direction to the light is zero or not finite");
    return vr_scene_check_parts(scene, err);
}

static void set_surfaces(struct picture *p, const struct vr_scene *scene,
                         const struct vr_isotrace_params *params)
{
    struct vr_iso_surface one = {.isovalue = scene->isovalue, .opacity = 1.0};
    double sigma;
    memcpy(one.rgb, scene->iso_rgb, sizeof one.rgb);
    if (scene->transfer)
        brick_transfer_eval(scene->transfer, scene->isovalue, one.rgb, &sigma);
    p->frame.surfaces = params->surface_count ? params->surface_count : 1;
    for (uint32_t k = 0; k < p->frame.surfaces; k++) {
        const struct vr_iso_surface *s = params->surface_count ? &params->surfaces[k] : &one;
        p->frame.surface[k] = (struct vr_iso_level){.isovalue = s->isovalue, .opacity = s->opacity};
        vr_iso_split(p->frame.grid, &p->frame.surface[k]);
        memcpy(p->shading.rgb[k], s->rgb, sizeof s->rgb);
    }
}

/* What the bounds take at a time. */
enum { BOUNDS_BRICKS = 64 };

static int bound(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct vr_isotracer *t = context;
    const uint64_t first = item * BOUNDS_BRICKS, end = first + BOUNDS_BRICKS;
    return vr_iso_bounds_add(&t->bounds, worker, first, end < t->map.bricks ? end : t->map.bricks, err);
}

struct sampler {
    struct vr_isotracer *tracer;
    struct vr_iso_profile *profile;
    atomic_bool stop;
};

static void *sample_phases(void *argument)
{
    struct sampler *s = argument;
    const struct timespec pause = {.tv_nsec = 50000};
    while (!atomic_load(&s->stop)) {
        nanosleep(&pause, NULL);
        for (unsigned i = 0; i < s->tracer->threads; i++)
            switch (atomic_load_explicit(&s->tracer->workers[i].activity.phase, memory_order_relaxed)) {
            case VR_ISO_TRAVERSAL:
                s->profile->traversal++;
                break;
            case VR_ISO_INTERSECTION:
                s->profile->intersection++;
                break;
            default:
                s->profile->shading++;
            }
    }
    return NULL;
}

static int run(struct picture *p, struct vr_iso_profile *profile, struct brick_error *err)
{
    struct sampler sampler = {.tracer = p->tracer, .profile = profile};
    pthread_t thread;
    bool sampling = profile && pthread_create(&thread, NULL, sample_phases, &sampler) == 0;
    if (profile && !sampling)
        return brick_fail(err, BRICK_ERR_MEMORY, "isotrace: the system refuses a thread for the profile");
    int code = brick_pool_run(p->tracer->pool, (p->tracer->map.bricks + BOUNDS_BRICKS - 1) / BOUNDS_BRICKS,
                              bound, p->tracer, err);
    if (!code)
        code = brick_pool_run(p->tracer->pool, p->tracer->threads, work, p, err);
    if (sampling) {
        atomic_store(&sampler.stop, true);
        pthread_join(thread, NULL);
    }
    return code;
}

int vr_render_isotrace(struct vr_isotracer *t, const struct vr_scene *scene,
                       const struct vr_isotrace_params *params, struct brick_image *image,
                       struct vr_report *report, struct brick_error *err)
{
    uint64_t started_ns = brick_now_ns(), cells = 0;
    struct brick_cache_counters before, after;
    struct picture p = {.tracer = t, .image = image};

    int code = check(t->grid, scene, params, image, err);
    if (!code)
        code = brick_view_init(&p.view, &scene->camera, t->grid, scene->width, scene->height, err);
    if (!code)
        code = vr_iso_layout_make(&t->copy, t->volume, scene->level, t->budget_bytes, err);
    if (code)
        return code;
    p.frame.grid = t->grid;
    p.frame.level = &t->grid->level[scene->level];
    p.frame.kernel = vr_iso_kernel_of(t->grid->type, t->copy.layout == VR_ISO_TILED);
    p.frame.termination = params->termination;
    p.frame.skip = params->skip;
    p.frame.flat = t->copy.layout == VR_ISO_FLAT ? t->copy.blocks : NULL;
    vr_scene_clip(scene, t->grid, &p.clip);
    vr_iso_shading_init(&p.shading, t->grid, scene, params);
    set_surfaces(&p, scene, params);
    p.tiles_x = (image->width + TILE_WIDTH - 1) / TILE_WIDTH;
    p.tiles = p.tiles_x * ((image->height + TILE_HEIGHT - 1) / TILE_HEIGHT);
    p.frame.map = &t->map;
    code = vr_iso_map_make(&t->map, t->volume, &p.frame, err);
    if (!code)
        code =
            vr_iso_bounds_begin(&t->bounds, &p.frame, &p.view, image->width, image->height, t->threads, err);
    if (code)
        return code;
    for (unsigned i = 0; i < t->threads; i++) {
        struct worker *w = &t->workers[i];
        w->pin.grid = t->grid;
        w->pin.cache = t->cache;
        w->pin.tiled = t->copy.layout == VR_ISO_TILED ? t->copy.blocks : NULL;
        w->pin.tiled_first = p.frame.level->first_brick;
        w->activity.cells = 0;
        for (int k = 0; k < TILE_PIXELS; k++) {
            w->walk[k].frame = w->shadow[k].frame = &p.frame;
            w->walk[k].activity = w->shadow[k].activity = &w->activity;
            w->walk[k].want_gradient = true;
        }
    }
    brick_cache_count(t->cache, &before);
    code = run(&p, params->profile, err);
    brick_cache_count(t->cache, &after);
    for (unsigned i = 0; i < t->threads; i++) {
        vr_iso_pin_release(&t->workers[i].pin);
        cells += t->workers[i].activity.cells;
    }
    if (!code && report)
        *report = (struct vr_report){.passes = 1,
                                     .bricks_total = t->map.bricks,
                                     .bricks_active = t->map.active,
                                     .bricks_loaded = after.loads - before.loads,
                                     .bytes_read = after.bytes_read - before.bytes_read,
                                     .samples = cells,
                                     .seconds_frame = (double)(brick_now_ns() - started_ns) * 1e-9};
    return code;
}
