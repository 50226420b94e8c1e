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

#include "layout.h"
#include "map.h"
#include "split.h"
#include "tile.h"

const struct vr_isotracer_params vr_isotracer_defaults = {.host_cache_bytes = UINT64_C(1) << 30};
const struct vr_isotrace_params vr_isotrace_defaults = {.termination = 1e-4, .skip = true};

struct vr_isotracer {
    const struct brick_volume *volume;
    const struct brick_grid *grid;
    uint64_t budget_bytes;
    struct brick_cache *cache;
    struct brick_pool *pool;
    struct vr_iso_worker *workers;
    unsigned threads;
    struct vr_iso_layout_copy copy;
    struct vr_iso_map map;
    struct vr_iso_bounds bounds;
    struct vr_mesh_view meshes;
};

struct job {
    struct vr_isotracer *tracer;
    struct vr_iso_picture picture;
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
        for (int k = 0; k < VR_ISO_TILE_PIXELS; k++) {
            vr_iso_walk_finish(&t->workers[i].walk[k]);
            vr_iso_walk_finish(&t->workers[i].shadow[k]);
        }
    free(t->workers);
    vr_iso_layout_finish(&t->copy);
    vr_iso_map_finish(&t->map);
    vr_iso_bounds_finish(&t->bounds);
    vr_mesh_view_finish(&t->meshes);
    brick_pool_destroy(&t->pool);
    brick_cache_destroy(&t->cache);
    free(t);
    *tracer = NULL;
}

/* The next grant: tiles [*first, return value). */
static uint32_t take_grant(struct job *j, uint32_t *first)
{
    uint_fast32_t at = atomic_load(&j->next), end;
    do {
        uint_fast32_t share = (j->picture.tiles - at) / (8 * j->tracer->threads);
        end = at + (share ? share : 1);
        if (at >= j->picture.tiles)
            end = at;
    } while (!atomic_compare_exchange_weak(&j->next, &at, end));
    *first = (uint32_t)at;
    return (uint32_t)end;
}

static int work(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct job *j = context;
    uint32_t tile, end;
    (void)item;
    while (tile = 0, end = take_grant(j, &tile), tile < end)
        for (; tile < end && !atomic_load_explicit(&j->stop, memory_order_relaxed); tile++) {
            int code = vr_iso_tile_draw(&j->picture, &j->tracer->workers[worker], tile, err);
            if (code) {
                atomic_store(&j->stop, true);
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

static void set_surfaces(struct vr_iso_picture *p, const struct vr_scene *scene,
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

static int run(struct job *j, struct vr_iso_profile *profile, struct brick_error *err)
{
    struct sampler sampler = {.tracer = j->tracer, .profile = profile};
    pthread_t thread;
    bool sampling = profile && pthread_create(&thread, NULL, sample_phases, &sampler) == 0;
    if (profile && !sampling)
        return brick_fail(err, BRICK_ERR_MEMORY, "isotrace: the system refuses a thread for the profile");
    int code = brick_pool_run(j->tracer->pool, (j->tracer->map.bricks + BOUNDS_BRICKS - 1) / BOUNDS_BRICKS,
                              bound, j->tracer, err);
    if (!code)
        code = brick_pool_run(j->tracer->pool, j->tracer->threads, work, j, err);
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
    struct job job = {.tracer = t, .picture = {.bounds = &t->bounds, .meshes = &t->meshes, .image = image}};
    struct vr_iso_picture *p = &job.picture;

    int code = check(t->grid, scene, params, image, err);
    if (!code)
        code = brick_view_init(&p->view, &scene->camera, t->grid, scene->width, scene->height, err);
    if (!code)
        code = vr_iso_layout_make(&t->copy, t->volume, scene->level, t->budget_bytes, err);
    if (code)
        return code;
    p->frame.grid = t->grid;
    p->frame.level = &t->grid->level[scene->level];
    p->frame.kernel = vr_iso_kernel_of(t->grid->type, t->copy.layout == VR_ISO_TILED);
    p->frame.termination = params->termination;
    p->frame.skip = params->skip;
    p->frame.flat = t->copy.layout == VR_ISO_FLAT ? t->copy.blocks : NULL;
    vr_scene_clip(scene, t->grid, &p->clip);
    vr_iso_shading_init(&p->shading, t->grid, scene, params);
    set_surfaces(p, scene, params);
    p->tiles_x = (image->width + VR_ISO_TILE_WIDTH - 1) / VR_ISO_TILE_WIDTH;
    p->tiles = p->tiles_x * ((image->height + VR_ISO_TILE_HEIGHT - 1) / VR_ISO_TILE_HEIGHT);
    p->frame.map = &t->map;
    code = vr_mesh_view_begin(&t->meshes, scene, t->grid, &p->view, err);
    if (!code)
        code = vr_iso_map_make(&t->map, t->volume, &p->frame, err);
    if (!code)
        code = vr_iso_bounds_begin(&t->bounds, &p->frame, &p->view, image->width, image->height, t->threads,
                                   err);
    if (code)
        return code;
    for (unsigned i = 0; i < t->threads; i++) {
        struct vr_iso_worker *w = &t->workers[i];
        w->pin.grid = t->grid;
        w->pin.cache = t->cache;
        w->pin.tiled = t->copy.layout == VR_ISO_TILED ? t->copy.blocks : NULL;
        w->pin.tiled_first = p->frame.level->first_brick;
        w->activity.cells = 0;
        for (int k = 0; k < VR_ISO_TILE_PIXELS; k++) {
            w->walk[k].frame = w->shadow[k].frame = &p->frame;
            w->walk[k].activity = w->shadow[k].activity = &w->activity;
            w->walk[k].want_gradient = true;
        }
    }
    brick_cache_count(t->cache, &before);
    code = run(&job, params->profile, err);
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
