/* A picture that methods blend polygons into: a colour texture of a chosen precision behind a framebuffer. */
#ifndef RENDERER_GPU_CANVAS_H
#define RENDERER_GPU_CANVAS_H

#include "context.h"

struct vr_canvas {
    int width, height;
    GLuint colour, framebuffer;
};

/* The context is bound in all of these. A canvas of zeros is safe to finish. */

/* format: GL_RGBA8, GL_RGBA16F, GL_RGBA32F, ... BRICK_ERR_UNSUPPORTED where the driver cannot draw to it. */
int vr_canvas_init(struct vr_canvas *canvas, struct vr_context *context, GLenum format, int width, int height,
                   struct brick_error *err);
void vr_canvas_finish(struct vr_canvas *canvas, struct vr_context *context);

/* Draw to it from now on: framebuffer and viewport. Clear: to zeros. */
void vr_canvas_use(const struct vr_canvas *canvas, struct vr_context *context);
void vr_canvas_clear(const struct vr_canvas *canvas, struct vr_context *context);

/* Copy [0,width) x [0,height) as floats to rgba, stride in pixels; row 0 is the framebuffer's. */
void vr_canvas_read(const struct vr_canvas *canvas, struct vr_context *context, int width, int height,
                    float *rgba, int stride);

#endif
