/* What methods that march rays in passes share: the picture in parts no larger than a target, and passes over
 * a part until all its rays have ended, between which the bricks come that rays wait for
 * (shaders/march.glsl). */
#ifndef RENDERER_METHODS_MARCH_H
#define RENDERER_METHODS_MARCH_H

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
    uint64_t look_ns;          /* that the last one took */
    int part;                  /* of the picture, in work */
    bool resume;               /* it has seen a pass */
    int ahead;                 /* bricks that a waiting ray may ask for beyond the one it needs */
};

/* Draw the frame with a program of the source, which contains march.glsl and whatever that needs; defines are
 * lines of the method's own beside what march.glsl needs. Counts passes and samples in report. When the
 * frame's budget is used up, the picture is as far as it goes by what is in the GPU cache: rays are marched
 * on by the same source with STAND_IN defined, in a copy of their state. */
int vr_march_draw(struct vr_march *march, struct vr_frame *frame, const struct vr_program_source *source,
                  const char *defines, struct brick_image *image, struct vr_report *report,
                  struct brick_error *err);
void vr_march_finish(struct vr_march *march, struct vr_context *context);

#endif
