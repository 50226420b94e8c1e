/* What methods that march rays in passes share: the picture in parts no larger than a target, and passes over
 * a part until all its rays have ended, between which the bricks come that rays wait for
 * (shaders/march.glsl). */
#ifndef RENDERER_METHODS_MARCH_H
#define RENDERER_METHODS_MARCH_H

#include "bounds.h"
#include "frame.h"
#include "target.h"

/* Rays between passes, and what they ask for. */
struct vr_march_rays {
    struct vr_target target;
    struct vr_feedback feedback;
};

/* Kept from picture to picture, and from call to call of one. One of zeros is empty. */
struct vr_march {
    struct vr_march_rays rays;
    struct vr_march_rays look; /* the same rays marched on past missing bricks, for a look before the end */
    struct vr_bounds bounds;   /* where rays begin and end */
    uint64_t look_ns;          /* that the last one took */
    int part;                  /* of the picture, in work */
    bool resume;               /* it has seen a pass */
    int ahead;                 /* bricks that a waiting ray may ask for beyond the one it needs */
};

/* The shader parts that a marching program begins with, of shaders.h. */
#define VR_MARCH_PARTS                                                                                       \
    {"exponential.glsl", vr_shader_exponential}, {"fixed.glsl", vr_shader_fixed},                            \
        {"ray.glsl", vr_shader_ray}, {"field.glsl", vr_shader_field}, {"transfer.glsl", vr_shader_transfer}, \
        {"preintegrated.glsl", vr_shader_preintegrated}, {"shading.glsl", vr_shader_shading},                \
        {"feedback.glsl", vr_shader_feedback}, {"segments.glsl", vr_shader_segments},                        \
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
/* Takes a ray as far as a pass may: the raycaster's. */
extern const struct vr_march_pass vr_march_far;

/* Draw the frame in rounds of passes[0..count). Counts passes and samples in report. When the frame's budget
 * is used up, the picture is as far as it goes by what is in the GPU cache: rays are marched on by
 * vr_march_far with STAND_IN defined, in a copy of their state. */
int vr_march_draw(struct vr_march *march, struct vr_frame *frame, const struct vr_march_pass *passes,
                  size_t count, struct brick_image *image, struct vr_report *report, struct brick_error *err);
void vr_march_finish(struct vr_march *march, struct vr_context *context);

#endif
