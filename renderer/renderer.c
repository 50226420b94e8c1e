/* The renderer: a context, what is resident in it, and the methods that draw from there.
 *
 * The context is current only inside the functions here, so that several renderers, through EGL and OSMesa,
 * can take turns in one thread. */
#include <renderer/renderer.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "method.h"
#include "scene.h"

struct vr_renderer {
    const struct brick_volume *volume;
    struct vr_context *context;
    struct brick_pool *pool;
    struct vr_residency *residency;
    struct vr_frame_store store;
    void *state[VR_METHODS]; /* NULL until a method draws for the first time */

    /* The picture at hand, while `open`. */
    bool open;
    struct vr_scene scene;
    struct vr_quality quality;
    struct vr_frame frame;
    struct vr_report drawn;
};

static const struct vr_method_row *const methods[VR_METHODS] = {
    [VR_METHOD_RAYCAST] = &vr_raycast,
    [VR_METHOD_MULTIPASS] = &vr_multipass,
    [VR_METHOD_SLICES] = &vr_slices,
    [VR_METHOD_CELLS] = &vr_cells,
};

static void close_picture(struct vr_renderer *r)
{
    if (r->open)
        vr_frame_finish(&r->frame);
    r->open = false;
}

int vr_renderer_create(struct vr_renderer **out, const struct brick_volume *volume,
                       const struct vr_renderer_params *params, struct brick_error *err)
{
    int result;
    struct vr_renderer *r = calloc(1, sizeof *r);
    *out = NULL;
    if (!r)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the renderer");
    r->volume = volume;
    if ((result = brick_pool_create(&r->pool, params->threads, err)) ||
        (result = vr_context_create(&r->context, params->context, err)) ||
        (result = vr_context_bind(r->context, err)))
        goto fail;
    result = vr_residency_create(&r->residency, r->context, volume, params, r->pool, err);
    vr_context_unbind(r->context);
    if (result)
        goto fail;
    *out = r;
    return BRICK_OK;
fail:
    vr_renderer_destroy(&r);
    return result;
}

void vr_renderer_destroy(struct vr_renderer **renderer)
{
    struct vr_renderer *r = *renderer;
    if (!r)
        return;
    if (r->residency && vr_context_bind(r->context, NULL) == BRICK_OK) {
        for (int m = 0; m < VR_METHODS; m++)
            if (r->state[m])
                methods[m]->finish(r->state[m], r->context);
        vr_frame_store_finish(&r->store, r->context);
        vr_residency_destroy(&r->residency);
        vr_context_unbind(r->context);
    }
    close_picture(r);
    vr_context_destroy(&r->context);
    brick_pool_destroy(&r->pool);
    for (int m = 0; m < VR_METHODS; m++)
        free(r->state[m]);
    free(r);
    *renderer = NULL;
}

static int check_scene(const struct vr_renderer *r, const struct vr_scene *scene,
                       const struct vr_quality *quality, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    if ((unsigned)quality->method >= VR_METHODS)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "method %d does not exist", (int)quality->method);
    if ((unsigned)quality->setup > VR_SETUP_GEOMETRY)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "ray set-up %d does not exist", (int)quality->setup);
    if (!methods[quality->method]->filters && vr_residency_filter(r->residency) == VR_FILTER_FAST)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this method does not draw with the fast filter");
    if ((unsigned)quality->classification > VR_CLASSIFY_PREINTEGRATED)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "classification %d does not exist",
                          (int)quality->classification);
    if ((unsigned)scene->mode > BRICK_MODE_MIP)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "mode %d does not exist", (int)scene->mode);
    if (scene->mode != BRICK_MODE_ISO && !scene->transfer)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "this mode needs a transfer function");
    if (scene->mode == BRICK_MODE_ISO && !isfinite(scene->isovalue))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the isovalue is not finite");
    if (scene->level >= grid->levels)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "level %u does not exist; the volume has %u", scene->level,
                          grid->levels);
    if ((scene->clip_count && !methods[quality->method]->clips) ||
        (scene->mesh_count && !methods[quality->method]->meshes))
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this method draws no %s; others do",
                          scene->clip_count && !methods[quality->method]->clips ? "clip planes" : "meshes");
    if (scene->mode != BRICK_MODE_ISO && scene->transfer->emission == BRICK_EMISSION_INDEPENDENT &&
        !methods[quality->method]->independent)
        return brick_fail(
            err, BRICK_ERR_UNSUPPORTED,
            "this method emits colour scaled by extinction only; methods slices and exact do both");
    if (quality->distances && (scene->mode != BRICK_MODE_ISO || scene->mesh_count))
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "distances are of isosurfaces, without meshes");
    if (!(quality->step_vox > 0.0) || !isfinite(quality->step_vox))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "a step of %g voxels; it must be above 0",
                          quality->step_vox);
    if (!(quality->termination >= 0.0 && quality->termination < 1.0))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "a termination at %g; it must be in [0, 1)",
                          quality->termination);
    return vr_scene_check_parts(scene, err);
}

int vr_render_begin(struct vr_renderer *r, const struct vr_scene *scene, const struct vr_quality *quality,
                    struct brick_error *err)
{
    const struct brick_active_query query = {scene->mode, scene->transfer, scene->isovalue, scene->level};
    const uint64_t start_ns = brick_now_ns();
    int result = check_scene(r, scene, quality, err);
    if (result)
        return result;
    close_picture(r);
    const struct vr_method_row *method = methods[quality->method];
    const struct vr_texels *texels = NULL;
    void **state = &r->state[quality->method];
    if (!*state && !(*state = calloc(1, method->state_bytes)))
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a method's state");
    if ((result = vr_context_bind(r->context, err)))
        return result;
    r->scene = *scene;
    r->quality = *quality;
    r->frame = (struct vr_frame){
        .context = r->context, .store = &r->store, .volume = r->volume, .residency = r->residency};
    r->drawn = (struct vr_report){0};
    r->open = true;
    if ((result = vr_frame_init(&r->frame, &r->scene, &r->quality, err)) ||
        (method->texels && (result = method->texels(*state, &r->frame, &texels, err))) ||
        (result = vr_residency_set_texels(r->residency, texels, err)) ||
        (result = vr_residency_begin(r->residency, &query, &scene->camera, err)))
        close_picture(r);
    vr_context_unbind(r->context);
    r->drawn.seconds_frame = 1e-9 * (double)(brick_now_ns() - start_ns);
    return result;
}

static void count(struct vr_renderer *r, double seconds)
{
    struct vr_report *report = &r->drawn;
    struct vr_residency_counters counters;
    vr_residency_count(r->residency, &counters);
    report->bricks_total = counters.bricks_total;
    report->bricks_active = counters.bricks_active;
    report->bricks_loaded = counters.bricks_loaded;
    report->bricks_read = counters.bricks_read;
    report->bytes_read = counters.bytes_read;
    report->host_cache_peak_bytes = counters.host_cache_peak_bytes;
    report->gpu_cache_bytes = counters.cache_bytes;
    report->gpu_cache_peak_bytes = counters.cache_peak_bytes;
    report->seconds_frame += seconds;
    snprintf(report->gl_renderer, sizeof report->gl_renderer, "%s", r->context->renderer);
}

int vr_render_continue(struct vr_renderer *r, const struct vr_budget *budget, struct brick_image *image,
                       bool *final, struct vr_report *report, struct brick_error *err)
{
    const uint64_t start_ns = brick_now_ns();
    struct vr_frame *frame = &r->frame;
    int result;
    if (!r->open)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "no picture has been begun, or it is final");
    if (r->scene.width != image->width || r->scene.height != image->height || !image->rgba)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the image has %u x %u pixels, the scene %u x %u",
                          image->width, image->height, r->scene.width, r->scene.height);
    if ((result = vr_context_bind(r->context, err)))
        return result;
    frame->final = true;
    frame->deadline_ns = frame->upload_bytes = UINT64_MAX;
    if (budget && budget->seconds > 0.0)
        frame->deadline_ns = start_ns + (uint64_t)(1e9 * fmin(budget->seconds, 1e9));
    if (budget && budget->upload_bytes)
        frame->upload_bytes = budget->upload_bytes;
    result = methods[r->quality.method]->draw(r->state[r->quality.method], frame, image, &r->drawn, err);
    vr_context_unbind(r->context);
    frame->begun = true;
    *final = frame->final;
    if (result || frame->final)
        close_picture(r);
    if (!result)
        count(r, 1e-9 * (double)(brick_now_ns() - start_ns));
    if (!result && report)
        *report = r->drawn;
    return result;
}

int vr_render(struct vr_renderer *renderer, const struct vr_scene *scene, const struct vr_quality *quality,
              struct brick_image *image, struct vr_report *report, struct brick_error *err)
{
    bool final;
    int result = vr_render_begin(renderer, scene, quality, err);
    return result ? result : vr_render_continue(renderer, NULL, image, &final, report, err);
}
