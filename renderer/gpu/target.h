/* What methods that work in passes over a picture's pixels keep between them: four words and two numbers a
 * pixel, which shaders read and write in place as images. A pass draws listed tiles only, so that a pass over
 * few unfinished rays is cheap. */
#ifndef RENDERER_GPU_TARGET_H
#define RENDERER_GPU_TARGET_H

#include <stdbool.h>

#include "context.h"

/* Edge of a tile in pixels. */
#define VR_TARGET_TILE 32

/* What a pass does with the depth buffer: nothing; replaces each pixel's value by what its shader writes, 0
 * or 1; runs only where that is 0. */
enum vr_target_depth { VR_TARGET_DEPTH_OFF, VR_TARGET_DEPTH_WRITE, VR_TARGET_DEPTH_TEST };

struct vr_target {
    int width, height;
    GLuint words, numbers; /* GL_RGBA32UI, GL_RG32UI */
    GLuint depth;          /* 0: has none */
    GLuint draw_framebuffer, read_framebuffer, vertex_array;
};

/* The context is bound in all of these. A target of zeros is safe to finish. */
int vr_target_init(struct vr_target *target, struct vr_context *context, int width, int height, bool depth,
                   struct brick_error *err);
void vr_target_finish(struct vr_target *target, struct vr_context *context);

/* Words and numbers of [0,width) x [0,height) from another of at least that size. */
void vr_target_copy(const struct vr_target *target, struct vr_context *context, const struct vr_target *from,
                    int width, int height);

/* Words and numbers to 0. */
void vr_target_clear(const struct vr_target *target, struct vr_context *context);

/* Make words and numbers the images of two units. */
void vr_target_use(const struct vr_target *target, struct vr_context *context, GLuint words_unit,
                   GLuint numbers_unit);

/* Run the current program once for every pixel of [0,width) x [0,height) that lies in a tile whose flag is
 * not 0 and passes the depth test, if that is on. flags: tiles_across a row. In pieces: one long draw would
 * trip the watchdog of a desktop's GPU. */
void vr_target_draw(const struct vr_target *target, struct vr_context *context, int width, int height,
                    const uint32_t *flags, int tiles_across, enum vr_target_depth depth);

/* Copy [0,width) x [0,height) of the words as floats to rgba (stride in pixels), and of the numbers to
 * numbers, 2 a pixel without padding. */
void vr_target_read(const struct vr_target *target, struct vr_context *context, int width, int height,
                    float *rgba, int stride, uint32_t *numbers);

#endif
