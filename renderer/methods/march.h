/* What methods that march rays in passes share: the picture in parts no larger than a target, and passes over
 * a part until all its rays have ended, between which the bricks come that rays wait for
 * (shaders/march.glsl). */
#ifndef RENDERER_METHODS_MARCH_H
#define RENDERER_METHODS_MARCH_H

#include "frame.h"

/* Kept from picture to picture: what rays ask for. One of zeros is empty. */
struct vr_march {
    struct vr_feedback feedback;
};

/* Draw the frame with a program of the source, which contains march.glsl and whatever that needs; defines are
 * lines of the method's own beside what march.glsl needs. Counts passes and samples in report. */
int vr_march_draw(struct vr_march *march, const struct vr_frame *frame,
                  const struct vr_program_source *source, const char *defines, struct brick_image *image,
                  struct vr_report *report, struct brick_error *err);
void vr_march_finish(struct vr_march *march, struct vr_context *context);

#endif
