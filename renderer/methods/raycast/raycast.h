/* Single-pass raycasting (Krueger and Westermann 2003; Scharsach 2005), one program per set of features. */
#ifndef RENDERER_METHODS_RAYCAST_RAYCAST_H
#define RENDERER_METHODS_RAYCAST_RAYCAST_H

#include "residency.h"

/* Programs compiled so far, and the transfer function's buffers. A raycaster of zeros is empty. */
struct vr_raycast {
    struct {
        GLuint name;
        uint32_t search_steps; /* of transfer tables */
    } programs[4][2];          /* mode, skip */
    struct vr_buffer pieces, bins;
};

/* The context is bound in all of these. */
void vr_raycast_finish(struct vr_raycast *raycast, struct vr_context *context);

/* Draw a scene whose bricks are resident into image, which has its size. Counts passes, and samples fetched.
 */
int vr_raycast_draw(struct vr_raycast *raycast, struct vr_context *context, const struct brick_volume *volume,
                    const struct vr_residency *residency, const struct vr_scene *scene,
                    const struct vr_quality *quality, struct brick_image *image, struct vr_report *report,
                    struct brick_error *err);

#endif
