/* Offscreen pictures for methods that go over every pixel, in one pass or several: RGBA float32 in colour
 * attachment 0, two unsigned numbers a pixel in attachment 1. Each pass reads what the pass before wrote. */
#ifndef RENDERER_GPU_TARGET_H
#define RENDERER_GPU_TARGET_H

#include <stdbool.h>

#include "context.h"

struct vr_target {
    int width, height;
    int count; /* pictures: 1, or 2 that take turns */
    int drawn; /* the one drawn last */
    GLuint framebuffer[2], colour[2], numbers[2], vertex_array;
};

/* The context is bound in all of these. A target of zeros is safe to finish. several_passes: passes will read
 * the pass before. */
int vr_target_init(struct vr_target *target, struct vr_context *context, int width, int height,
                   bool several_passes, struct brick_error *err);
void vr_target_finish(struct vr_target *target, struct vr_context *context);

/* Make what was drawn last the textures of two units: colours, and numbers. */
void vr_target_use(const struct vr_target *target, struct vr_context *context, GLuint colour_unit,
                   GLuint numbers_unit);

/* Run the current program once for every pixel of [0,width) x [0,height), in tiles: one long draw would trip
 * the watchdog of a desktop's GPU. */
void vr_target_draw(struct vr_target *target, struct vr_context *context, int width, int height);

/* Copy [0,width) x [0,height) of the last pass to rgba (stride in pixels), and the numbers to numbers, 2 a
 * pixel without padding. */
void vr_target_read(const struct vr_target *target, struct vr_context *context, int width, int height,
                    float *rgba, int stride, uint32_t *numbers);

#endif
