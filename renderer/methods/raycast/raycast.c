/* The raycaster: one pass a round, which takes a ray as far as bricks are there. */
#include "method.h"

#include "march.h"

static int draw(void *state, struct vr_frame *frame, struct brick_image *image, struct vr_report *report,
                struct brick_error *err)
{
    return vr_march_draw(state, frame, &vr_march_far, 1, image, report, err);
}

static void finish(void *state, struct vr_context *context)
{
    vr_march_finish(state, context);
}

const struct vr_method_row vr_raycast = {.state_bytes = sizeof(struct vr_march),
                                         .draw = draw,
                                         .finish = finish,
                                         .filters = true,
                                         .clips = true,
                                         .meshes = true};
