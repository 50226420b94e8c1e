/* The caster: a picture's tiles among the pool's threads. A pixel depends on its own ray only, so neither
 * threads nor caches change a bit. */
#include "cast.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include <brick/threads.h>

#include "footprint.h"
#include "scene.h"
#include "tile.h"

struct vr_caster {
    const struct brick_volume *volume;
    struct brick_cache *cache;
    struct brick_pool *pool;
    struct vr_cast_activity activity;
    struct vr_mesh_view meshes;
    uint32_t *shows; /* a flag a tile: may it show an active brick? */
    size_t tiles;    /* that there is room for */
    unsigned threads;
    struct worker {
        struct vr_cast_tile *tile;
        uint32_t words; /* that it has room for */
        uint64_t samples;
    } * workers;
};

int vr_caster_create(struct vr_caster **out, const struct brick_volume *volume,
                     const struct vr_renderer_params *params, struct brick_error *err)
{
    struct vr_caster *c = calloc(1, sizeof *c);
    *out = NULL;
    if (!c)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the renderer");
    c->volume = volume;
    c->threads = params->threads ? params->threads : brick_cores();
    int code = brick_cache_create(&c->cache, volume, params->host_cache_bytes, err);
    if (code)
        goto fail;
    if (c->threads > brick_cache_slots(c->cache))
        c->threads = (unsigned)brick_cache_slots(c->cache);
    if ((code = brick_pool_create(&c->pool, c->threads, err)))
        goto fail;
    c->workers = calloc(c->threads, sizeof *c->workers);
    if (!c->workers) {
        code = brick_fail(err, BRICK_ERR_MEMORY, "no memory for %u threads", c->threads);
        goto fail;
    }
    *out = c;
    return BRICK_OK;
fail:
    vr_caster_destroy(&c);
    return code;
}

void vr_caster_destroy(struct vr_caster **caster)
{
    struct vr_caster *c = *caster;
    if (!c)
        return;
    for (unsigned i = 0; c->workers && i < c->threads; i++)
        vr_cast_tile_destroy(c->workers[i].tile);
    free(c->workers);
    free(c->shows);
    vr_cast_activity_finish(&c->activity);
    vr_mesh_view_finish(&c->meshes);
    brick_pool_destroy(&c->pool);
    brick_cache_destroy(&c->cache);
    free(c);
    *caster = NULL;
}

int vr_caster_check(const struct vr_scene *scene, const struct vr_quality *quality, struct brick_error *err)
{
    const char *what = NULL;
    if (quality->method != VR_METHOD_RAYCAST)
        what = "this method needs OpenGL; raycast, isotrace and exact do not";
    else if (scene->mode == BRICK_MODE_ISO)
        what = "without OpenGL raycast draws no isosurfaces; isotrace does";
    else if (quality->classification != VR_CLASSIFY_POST)
        what = "without OpenGL values are classified after interpolation only";
    else if (quality->setup != VR_SETUP_BOX)
        what = "without OpenGL no geometry is drawn for rays to begin at";
    else if (scene->transfer->emission == BRICK_EMISSION_INDEPENDENT)
        what = "raycast emits colour scaled by extinction only; methods slices and exact do both";
    return what ? brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s", what) : BRICK_OK;
}

static void set_light(struct vr_cast_light *light, const struct vr_scene *scene,
                      const struct vr_cast_set *set)
{
    vr_scene_normals(set->grid, set->level, light->normal);
    light->ambient = (float)scene->ambient;
    light->diffuse = (float)scene->diffuse;
    light->specular = (float)scene->specular;
    light->shininess = (float)scene->shininess;
}

static int begin(struct vr_caster *c, const struct vr_scene *scene, const struct vr_quality *quality,
                 struct vr_cast_frame *frame, struct brick_error *err)
{
    const struct brick_active_query query = {scene->mode, scene->transfer, scene->isovalue, scene->level};
    struct vr_cast_set *set = &frame->set;
    set->grid = brick_volume_grid(c->volume);
    set->level = &set->grid->level[scene->level];
    for (int a = 0; a < 3; a++)
        set->per_voxel[a] = 1.0 / set->level->scale[a];
    set->step_mm = quality->step_vox * brick_grid_min_spacing_mm(set->grid);
    set->interleaved = quality->interleaved;
    set->cut = quality->interleaved || scene->clip_count;
    vr_scene_clip(scene, set->grid, &set->clip);
    int code = vr_scene_check_step(set->grid, set->step_mm, err);
    if (code ||
        (code = brick_view_init(&set->view, &scene->camera, set->grid, scene->width, scene->height, err)) ||
        (code = vr_mesh_view_begin(&c->meshes, scene, set->grid, &set->view, err)) ||
        (code = vr_cast_activity_begin(&c->activity, c->volume, &query, quality->skip, err)) ||
        (code = vr_transfer_table_init(&frame->table, scene->transfer, set->grid, err)) ||
        (code = vr_cast_pieces_init(&frame->pieces, &frame->table, err)))
        return code;
    frame->scene = scene;
    frame->kernels = vr_cast_kernels_table(0);
    frame->activity = &c->activity;
    frame->meshes = &c->meshes;
    frame->cache = c->cache;
    frame->field = (struct vr_cast_field){.sign = set->grid->slope < 0.0 ? -1.0f : 1.0f,
                                          .visible = {frame->table.visible[0], frame->table.visible[1]},
                                          .nonfinite = brick_volume_stats(c->volume)->nonfinite};
    if (scene->mode == BRICK_MODE_MIP)
        frame->field.visible[0] = -INFINITY, frame->field.visible[1] = INFINITY;
    frame->unit_mm = (float)scene->transfer->unit_mm;
    frame->depth_end = quality->termination > 0.0 && scene->mode != BRICK_MODE_MIP
                           ? (float)-log(quality->termination)
                           : FLT_MAX;
    set_light(&frame->light, scene, set);
    return BRICK_OK;
}

/* Which tiles can show something. */
static int find_tiles(struct vr_caster *c, const struct vr_cast_frame *frame, uint32_t across, uint32_t down,
                      struct brick_error *err)
{
    const struct vr_tiles tiles = {.width = (int)frame->scene->width,
                                   .height = (int)frame->scene->height,
                                   .edge = VR_CAST_TILE,
                                   .across = (int)across};
    const size_t n = (size_t)across * down;
    if (n > c->tiles) {
        free(c->shows);
        c->tiles = 0;
        if (!(c->shows = malloc(n * sizeof *c->shows)))
            return brick_fail(err, BRICK_ERR_MEMORY, "no memory for %zu tiles of a picture", n);
        c->tiles = n;
    }
    vr_footprint(&frame->set.view, frame->set.grid, frame->scene->level, c->activity.state, &tiles, c->shows);
    return BRICK_OK;
}

struct job {
    struct vr_caster *caster;
    const struct vr_cast_frame *frame;
    uint32_t across;
};

static int draw(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    const struct job *job = context;
    const uint32_t x = (uint32_t)(item % job->across) * VR_CAST_TILE,
                   y = (uint32_t)(item / job->across) * VR_CAST_TILE;
    struct worker *w = &job->caster->workers[worker];
    if (!w->tile || w->words < job->frame->activity->words) {
        vr_cast_tile_destroy(w->tile);
        w->words = job->frame->activity->words;
        if (!(w->tile = vr_cast_tile_create(job->frame->activity)))
            return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a tile of the picture");
    }
    return vr_cast_tile_draw(w->tile, job->frame, x, y, job->caster->shows[item], &w->samples, err);
}

int vr_cast(struct vr_caster *c, const struct vr_scene *scene, const struct vr_quality *quality,
            struct brick_image *image, struct vr_report *report, struct brick_error *err)
{
    const uint64_t start_ns = brick_now_ns();
    struct vr_cast_frame frame = {.image = image};
    struct brick_cache_counters before, after;
    const uint32_t across = (image->width + VR_CAST_TILE - 1) / VR_CAST_TILE;
    const uint32_t down = (image->height + VR_CAST_TILE - 1) / VR_CAST_TILE;
    struct job job = {c, &frame, across};
    uint64_t samples = 0;
    int code = vr_caster_check(scene, quality, err);
    if (!code)
        code = begin(c, scene, quality, &frame, err);
    if (!code)
        code = find_tiles(c, &frame, across, down, err);
    brick_cache_count(c->cache, &before);
    for (unsigned i = 0; i < c->threads; i++)
        c->workers[i].samples = 0;
    if (!code)
        code = brick_pool_run(c->pool, (uint64_t)across * down, draw, &job, err);
    brick_cache_count(c->cache, &after);
    for (unsigned i = 0; i < c->threads; i++)
        samples += c->workers[i].samples;
    vr_cast_pieces_finish(&frame.pieces);
    vr_transfer_table_finish(&frame.table);
    if (!code && report)
        *report = (struct vr_report){.passes = 1,
                                     .bricks_total = c->activity.bricks,
                                     .bricks_active = c->activity.active,
                                     .bricks_loaded = after.loads - before.loads,
                                     .bricks_read = after.loads - before.loads,
                                     .bytes_read = after.bytes_read - before.bytes_read,
                                     .host_cache_peak_bytes = after.peak_bytes,
                                     .samples = samples,
                                     .seconds_frame = (double)(brick_now_ns() - start_ns) * 1e-9};
    return code;
}
