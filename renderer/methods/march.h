/* What methods that march rays in passes share: the picture in parts no larger than a target, and passes over
 * a part until all its rays have ended, between which the bricks come that rays wait for
 * (shaders/march.glsl). */
#ifndef RENDERER_METHODS_MARCH_H
#define RENDERER_METHODS_MARCH_H

#include "bounds.h"
#include "frame.h"
#include "target.h"

/* Kept from picture to picture. One of zeros is empty. */
struct vr_march {
    struct vr_feedback feedback; /* what rays ask for */
    struct vr_bounds bounds;     /* where they begin and end */
};

/* The shader parts that a marching program begins with, of shaders.h. */
#define VR_MARCH_PARTS                                                                                       \
    {"exponential.glsl", vr_shader_exponential}, {"fixed.glsl", vr_shader_fixed},                            \
        {"ray.glsl", vr_shader_ray}, {"field.glsl", vr_shader_field}, {"transfer.glsl", vr_shader_transfer}, \
        {"shading.glsl", vr_shader_shading}, {"feedback.glsl", vr_shader_feedback},                          \
        {"cubic.glsl", vr_shader_cubic}, {"state.glsl", vr_shader_state},                                    \
    {                                                                                                        \
        "march.glsl", vr_shader_march                                                                        \
    }

/* A round is one or more passes, each over all unfinished rays. */
struct vr_march_pass {
    const struct vr_program_source *source; /* begins with VR_MARCH_PARTS */
    const char *defines;                    /* lines of #define beside what march.glsl needs */
    enum vr_target_depth depth;
};
#define VR_MARCH_MAX_PASSES 2

/* Draw the frame in rounds of passes[0..count). Counts passes and samples in report. */
int vr_march_draw(struct vr_march *march, const struct vr_frame *frame, const struct vr_march_pass *passes,
                  size_t count, struct brick_image *image, struct vr_report *report, struct brick_error *err);
void vr_march_finish(struct vr_march *march, struct vr_context *context);

#endif
