/* What a pass tells the host (shaders/feedback.glsl): which bricks its rays wait for, which come next on
 * their way, and which tiles of the picture have unfinished rays. The rays' list of wanted bricks of
 * Scharsach 2005 and of every paged raycaster since, as two bits a brick. */
#ifndef RENDERER_RESIDENCY_FEEDBACK_H
#define RENDERER_RESIDENCY_FEEDBACK_H

#include "buffer.h"

struct vr_feedback {
    struct vr_buffer buffer;
    uint32_t *words; /* what the last pass left: a flag a tile, then 16 bricks a word */
    uint32_t tiles;
    uint64_t bricks;
};

/* Bits of a brick. */
enum { VR_FEEDBACK_NEEDED = 1, VR_FEEDBACK_AHEAD = 2 };

/* The context is bound in all of these. A feedback of zeros is empty. */

/* Room for a level of so many bricks. */
int vr_feedback_resize(struct vr_feedback *feedback, struct vr_context *context, uint32_t tiles,
                       uint64_t bricks, struct brick_error *err);
void vr_feedback_finish(struct vr_feedback *feedback, struct vr_context *context);
/* Before a pass: nothing wanted. */
void vr_feedback_clear(struct vr_feedback *feedback, struct vr_context *context);
/* After a pass: fill words. */
void vr_feedback_read(struct vr_feedback *feedback, struct vr_context *context);

#endif
