/* Raycasting of bricks (Krueger and Westermann 2003; Scharsach 2005), one program per set of features. */
#ifndef RENDERER_METHODS_RAYCAST_RAYCAST_H
#define RENDERER_METHODS_RAYCAST_RAYCAST_H

#include "residency.h"

/* Programs compiled so far, the transfer function's buffers, and what rays ask for. A raycaster of zeros is
 * empty. */
struct vr_raycast {
    struct {
        GLuint name;
        uint32_t search_steps; /* of transfer tables */
    } programs[4][2];          /* mode, skip */
    struct vr_buffer pieces, bins;
    struct vr_feedback feedback;
};

/* The context is bound in all of these. */
void vr_raycast_finish(struct vr_raycast *raycast, struct vr_context *context);

/* Draw a scene, for which vr_residency_begin has been called, into image, which has its size: passes over
 * rays that have not ended, and between them bricks that these wait for. Counts passes, and samples fetched.
 */
int vr_raycast_draw(struct vr_raycast *raycast, struct vr_context *context, const struct brick_volume *volume,
                    struct vr_residency *residency, const struct vr_scene *scene,
                    const struct vr_quality *quality, struct brick_image *image, struct vr_report *report,
                    struct brick_error *err);

#endif
