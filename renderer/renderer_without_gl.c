/* What takes renderer.c's place in a build without OpenGL. */
#include <renderer/renderer.h>

#include <stddef.h>

int vr_renderer_create(struct vr_renderer **renderer, const struct brick_volume *volume,
                       const struct vr_renderer_params *params, struct brick_error *err)
{
    (void)volume, (void)params;
    *renderer = NULL;
    return brick_fail(
        err, BRICK_ERR_UNSUPPORTED,
        "this build has no OpenGL: install libegl-dev and libgl-dev and build again with -Dgl=enabled");
}

void vr_renderer_destroy(struct vr_renderer **renderer)
{
    *renderer = NULL;
}

int vr_render(struct vr_renderer *renderer, const struct vr_scene *scene, const struct vr_quality *quality,
              struct brick_image *image, struct vr_report *report, struct brick_error *err)
{
    (void)renderer, (void)scene, (void)quality, (void)image, (void)report;
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this build has no OpenGL");
}

int vr_render_begin(struct vr_renderer *renderer, const struct vr_scene *scene,
                    const struct vr_quality *quality, struct brick_error *err)
{
    (void)renderer, (void)scene, (void)quality;
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this build has no OpenGL");
}

int vr_render_continue(struct vr_renderer *renderer, const struct vr_budget *budget,
                       struct brick_image *image, bool *final, struct vr_report *report,
                       struct brick_error *err)
{
    (void)renderer, (void)budget, (void)image, (void) final, (void)report;
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this build has no OpenGL");
}
