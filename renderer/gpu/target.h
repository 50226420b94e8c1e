/* An offscreen picture: RGBA float32 in colour attachment 0, an unsigned counter a pixel in attachment 1. */
#ifndef RENDERER_GPU_TARGET_H
#define RENDERER_GPU_TARGET_H

#include "context.h"

struct vr_target {
    int width, height;
    GLuint framebuffer, colour, counter, vertex_array;
};

/* The context is bound in all of these. A target of zeros is safe to finish. */
int vr_target_init(struct vr_target *target, struct vr_context *context, int width, int height,
                   struct brick_error *err);
void vr_target_finish(struct vr_target *target, struct vr_context *context);

/* Run the current program once for every pixel of [0,width) x [0,height), in tiles: one long draw would trip
 * the watchdog of a desktop's GPU. */
void vr_target_draw(const struct vr_target *target, struct vr_context *context, int width, int height);

/* Copy [0,width) x [0,height) to rgba (stride in pixels) and add up the counters. scratch: width * height
 * words. */
void vr_target_read(const struct vr_target *target, struct vr_context *context, int width, int height,
                    float *rgba, int stride, uint32_t *scratch, uint64_t *count);

#endif
