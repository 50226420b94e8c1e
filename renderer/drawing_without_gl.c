/* What takes drawing.c's place in a build without OpenGL. */
#include "drawing.h"

#include <stddef.h>

int vr_drawing_create(struct vr_drawing **drawing, const struct brick_volume *volume,
                      const struct vr_renderer_params *params, struct brick_error *err)
{
    (void)volume, (void)params;
    *drawing = NULL;
    return brick_fail(
        err, BRICK_ERR_UNSUPPORTED,
        "this build has no OpenGL: install libegl-dev and libgl-dev and build again with -Dgl=enabled");
}

void vr_drawing_destroy(struct vr_drawing **drawing)
{
    *drawing = NULL;
}

bool vr_drawing_has_gpu(void)
{
    return false;
}

int vr_drawing_begin(struct vr_drawing *drawing, const struct vr_scene *scene,
                     const struct vr_quality *quality, struct brick_error *err)
{
    (void)drawing, (void)scene, (void)quality;
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this build has no OpenGL");
}

int vr_drawing_continue(struct vr_drawing *drawing, const struct vr_budget *budget, struct brick_image *image,
                        bool *final, struct vr_report *report, struct brick_error *err)
{
    (void)drawing, (void)budget, (void)image, (void) final, (void)report;
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this build has no OpenGL");
}
