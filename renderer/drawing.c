/* Drawing with OpenGL: a context, what is resident in it, and the methods that draw from there.
 *
 * The context is current only inside the functions here, so that several renderers, through EGL and OSMesa,
 * can take turns in one thread. */
#include "drawing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "method.h"
#include "scene.h"

struct vr_drawing {
    const struct brick_volume *volume;
    struct vr_context *context;
    struct brick_pool *pool;
    struct vr_residency *residency;
    struct vr_frame_store store;
    void *state[VR_METHODS]; /* NULL until a method draws for the first time */

    /* The picture at hand, while `open`. */
    bool open;
    struct vr_frame frame;
    struct vr_report drawn;
};

static const struct vr_method_row *const methods[VR_METHODS] = {
    [VR_METHOD_RAYCAST] = &vr_raycast,
    [VR_METHOD_MULTIPASS] = &vr_multipass,
    [VR_METHOD_SLICES] = &vr_slices,
    [VR_METHOD_CELLS] = &vr_cells,
};

static void close_picture(struct vr_drawing *r)
{
    if (r->open)
        vr_frame_finish(&r->frame);
    r->open = false;
}

int vr_drawing_create(struct vr_drawing **out, const struct brick_volume *volume,
                      const struct vr_renderer_params *params, struct brick_error *err)
{
    int result;
    struct vr_drawing *r = calloc(1, sizeof *r);
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
    vr_drawing_destroy(&r);
    return result;
}

void vr_drawing_destroy(struct vr_drawing **drawing)
{
    struct vr_drawing *r = *drawing;
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
    *drawing = NULL;
}

bool vr_drawing_has_gpu(void)
{
    return vr_context_has_gpu();
}

static int check_method(const struct vr_drawing *r, const struct vr_scene *scene,
                        const struct vr_quality *quality, struct brick_error *err)
{
    const struct vr_method_row *method = methods[quality->method];
    if (!method->filters && vr_residency_filter(r->residency) == VR_FILTER_FAST)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this method does not draw with the fast filter");
    if ((scene->clip_count && !method->clips) || (scene->mesh_count && !method->meshes))
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this method draws no %s; others do",
                          scene->clip_count && !method->clips ? "clip planes" : "meshes");
    if (scene->mode != BRICK_MODE_ISO && scene->transfer->emission == BRICK_EMISSION_INDEPENDENT &&
        !method->independent)
        return brick_fail(
            err, BRICK_ERR_UNSUPPORTED,
            "this method emits colour scaled by extinction only; methods slices and exact do both");
    return BRICK_OK;
}

int vr_drawing_begin(struct vr_drawing *r, const struct vr_scene *scene, const struct vr_quality *quality,
                     struct brick_error *err)
{
    const struct brick_active_query query = {scene->mode, scene->transfer, scene->isovalue, scene->level};
    const uint64_t start_ns = brick_now_ns();
    close_picture(r);
    int result = check_method(r, scene, quality, err);
    if (result)
        return result;
    const struct vr_method_row *method = methods[quality->method];
    const struct vr_texels *texels = NULL;
    void **state = &r->state[quality->method];
    if (!*state && !(*state = calloc(1, method->state_bytes)))
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a method's state");
    if ((result = vr_context_bind(r->context, err)))
        return result;
    r->frame = (struct vr_frame){
        .context = r->context, .store = &r->store, .volume = r->volume, .residency = r->residency};
    r->drawn = (struct vr_report){0};
    r->open = true;
    if ((result = vr_frame_init(&r->frame, scene, quality, err)) ||
        (method->texels && (result = method->texels(*state, &r->frame, &texels, err))) ||
        (result = vr_residency_set_texels(r->residency, texels, err)) ||
        (result = vr_residency_begin(r->residency, &query, &scene->camera, err)))
        close_picture(r);
    vr_context_unbind(r->context);
    r->drawn.seconds_frame = 1e-9 * (double)(brick_now_ns() - start_ns);
    return result;
}

static void count(struct vr_drawing *r, double seconds)
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

int vr_drawing_continue(struct vr_drawing *r, const struct vr_budget *budget, struct brick_image *image,
                        bool *final, struct vr_report *report, struct brick_error *err)
{
    const uint64_t start_ns = brick_now_ns();
    struct vr_frame *frame = &r->frame;
    int result;
    if ((result = vr_context_bind(r->context, err)))
        return result;
    frame->final = true;
    frame->deadline_ns = frame->upload_bytes = UINT64_MAX;
    if (budget && budget->seconds > 0.0)
        frame->deadline_ns = start_ns + (uint64_t)(1e9 * fmin(budget->seconds, 1e9));
    if (budget && budget->upload_bytes)
        frame->upload_bytes = budget->upload_bytes;
    const enum vr_method method = frame->quality->method;
    result = methods[method]->draw(r->state[method], frame, image, &r->drawn, err);
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
