/* Why: the pictures of `brick render`, one or a film: what all frames share is made once and kept warm. */
#include "render.h"

#include <stdio.h>
#include <string.h>

#include "message.h"
#include "options.h"
#include "transfer.h"

/* Surfaces coloured by the transfer function at their values, or else the first as any isosurface and the
 * others each in a colour of its own. */
static int trace_surfaces(const struct tool_request *request, struct vr_isotracer *tracer,
                          const struct vr_scene *scene, struct brick_image *image, struct vr_report *report,
                          struct brick_error *err)
{
    static const double others[][3] = {
        {0.7, 0.25, 0.15}, {0.2, 0.5, 0.75}, {0.3, 0.65, 0.25}, {0.75, 0.6, 0.15}};
    struct vr_iso_surface surfaces[TOOL_REALS_MAX];
    struct vr_isotrace_params params = request->isotrace;
    double sigma;
    for (uint32_t k = 0; k < request->iso.count; k++) {
        surfaces[k].isovalue = request->iso.value[k];
        surfaces[k].opacity = request->has_opacity ? request->iso_opacity.value[k] : 1.0;
        memcpy(surfaces[k].rgb, k ? others[(k - 1) % TOOL_COUNT(others)] : scene->iso_rgb,
               sizeof surfaces[k].rgb);
        if (scene->transfer)
            brick_transfer_eval(scene->transfer, surfaces[k].isovalue, surfaces[k].rgb, &sigma);
    }
    params.surfaces = surfaces;
    params.surface_count = request->iso.count;
    params.skip = !request->no_skip;
    if (request->has_termination)
        params.termination = request->quality.termination;
    return vr_render_isotrace(tracer, scene, &params, image, report, err);
}

/* "img.exr" for a single picture; "img-0003.exr" in a film. */
static int frame_path(const char *output, bool film, size_t frame, char *path, size_t size,
                      struct brick_error *err)
{
    const char *slash = strrchr(output, '/'), *name = slash ? slash + 1 : output, *dot = strrchr(name, '.');
    int stem = (int)((dot && dot > name ? dot : output + strlen(output)) - output);
    int length = film ? snprintf(path, size, "%.*s-%04zu%s", stem, output, frame, output + stem)
                      : snprintf(path, size, "%s", output);
    return length < (int)size
               ? BRICK_OK
               : brick_fail(err, BRICK_ERR_ARGUMENT, "%.200s...: the name is too long", output);
}

/* What a film's frames share. */
struct studio {
    const struct tool_request *request;
    const struct brick_volume *volume;
    struct vr_renderer *renderer; /* by the method, one of these, or neither: exact keeps nothing warm */
    struct vr_isotracer *tracer;
    struct vr_scene scene;
    struct brick_mesh meshes[TOOL_LIST_MAX];
    struct vr_mesh drawn[TOOL_LIST_MAX];
    struct brick_image image;
    bool final; /* no frame's budget was used up before its end */
};

static int load_meshes(struct studio *studio, struct brick_error *err)
{
    const struct tool_request *request = studio->request;
    int code = BRICK_OK;
    for (size_t m = 0; m < request->mesh.count && !code; m++) {
        code = fmt_mesh_read(&studio->meshes[m], request->mesh.item[m], err);
        studio->drawn[m].mesh = &studio->meshes[m];
        memcpy(studio->drawn[m].rgb, request->mesh_rgb, sizeof studio->drawn[m].rgb);
    }
    studio->scene.meshes = studio->drawn;
    studio->scene.mesh_count = (uint32_t)request->mesh.count;
    studio->scene.meshes_number = 1; /* the same in all frames */
    return code;
}

static int make_frame(struct studio *studio, bool film, size_t frame, struct vr_report *report,
                      struct brick_error *err)
{
    const struct tool_request *request = studio->request;
    char path[4096];
    bool final = true;
    int code;
    if (studio->renderer) {
        code = vr_render_begin(studio->renderer, &studio->scene, &request->quality, err);
        if (!code)
            code =
                vr_render_continue(studio->renderer, &request->budget, &studio->image, &final, report, err);
        studio->final &= final;
    } else if (studio->tracer) {
        code = trace_surfaces(request, studio->tracer, &studio->scene, &studio->image, report, err);
    } else {
        struct vr_exact_params params = vr_exact_defaults;
        params.host_cache_bytes = request->renderer.host_cache_bytes;
        params.threads = request->renderer.threads;
        params.field = (enum vr_field)request->field;
        code = vr_render_exact(studio->volume, &studio->scene, &params, &studio->image, report, err);
    }
    for (size_t i = 0; i < request->outputs.count && !code; i++)
        if (!(code = frame_path(request->outputs.item[i], film, frame, path, sizeof path, err)))
            code = fmt_image_write(path, &studio->image, &request->image, err);
    if (!code && film && !request->quiet)
        fprintf(stderr, "frame %zu: %.3f s, %llu passes, %llu bricks loaded, %llu read, %s\n", frame,
                report->seconds_frame, (unsigned long long)report->passes,
                (unsigned long long)report->bricks_loaded, (unsigned long long)report->bricks_read,
                tool_size_text(report->bytes_read).text);
    return code;
}

int tool_render_frames(const struct tool_request *request, const struct brick_volume *volume,
                       const struct tool_cameras *cameras, struct vr_report *reports, bool *final,
                       struct brick_error *err)
{
    struct studio studio = {.request = request, .volume = volume, .scene = request->scene, .final = true};
    struct brick_transfer *transfer = NULL;
    bool film = request->path || request->has_turntable;

    studio.scene.mode = (enum brick_mode)request->mode;
    int code = load_meshes(&studio, err);
    /* An isosurface without --tf keeps its plain colour. */
    if (!code && (studio.scene.mode != BRICK_MODE_ISO || request->tf))
        code = tool_transfer_load(&transfer, request->tf, volume, err);
    if (transfer) {
        brick_transfer_scale(transfer, request->opacity);
        brick_transfer_set_emission(transfer, (enum brick_emission)request->emission);
    }
    studio.scene.transfer = transfer;
    if (!code)
        code = brick_image_init(&studio.image, studio.scene.width, studio.scene.height, err);
    if (!code && request->method < VR_METHODS) {
        struct vr_renderer_params params = request->renderer;
        if (!request->has_cache && !(request->budget.seconds > 0.0) &&
            vr_prefers_cpu(&studio.scene, &request->quality, &params))
            params.context = VR_CONTEXT_CPU;
        code = vr_renderer_create(&studio.renderer, volume, &params, err);
    }
    const struct vr_isotracer_params cpu = {.host_cache_bytes = request->renderer.host_cache_bytes,
                                            .threads = request->renderer.threads};
    if (!code && request->method == METHOD_ISOTRACE)
        code = vr_isotracer_create(&studio.tracer, volume, &cpu, err);
    for (size_t i = 0; i < cameras->count && !code; i++) {
        studio.scene.camera = cameras->item[i];
        code = make_frame(&studio, film, i, &reports[i], err);
    }
    *final = studio.final;
    vr_renderer_destroy(&studio.renderer);
    vr_isotracer_destroy(&studio.tracer);
    brick_image_finish(&studio.image);
    for (size_t m = 0; m < request->mesh.count; m++)
        brick_mesh_finish(&studio.meshes[m]);
    brick_transfer_destroy(&transfer);
    return code;
}
