/* What slices are blended into: a part of the picture in the chosen precision, the spans of its rays, and a
 * depth that stops fragments of pixels through which hardly anything gets any more. */
#ifndef RENDERER_METHODS_SLICES_PICTURE_H
#define RENDERER_METHODS_SLICES_PICTURE_H

#include "canvas.h"
#include "frame.h"
#include "stack.h"

/* Texture units of slices' programs. */
enum { VR_UNIT_SPANS = VR_UNIT_METHOD, VR_UNIT_PICTURE, VR_UNIT_SHEETS };

/* Edge of a tile in pixels: opaque tiles hide boxes. */
#define VR_PICTURE_TILE 16

struct vr_picture {
    struct vr_canvas colour, spans;
    GLuint depth, depth_framebuffer, vertex_array;
    int tiles[2];
    float *rgba;
    uint32_t *unfinished; /* tiles with a pixel that is not opaque yet, of all above and to the left, so that
                             those of a rectangle are four of these; (tiles[0] + 1) * (tiles[1] + 1) */
};

/* The context is bound in all of these. */
int vr_picture_init(struct vr_picture *picture, struct vr_context *context, GLenum format, int width,
                    int height, struct brick_error *err);
void vr_picture_finish(struct vr_picture *picture, struct vr_context *context);

/* Begin a part whose corner is pixel x, y of the whole: nothing is drawn, spans are found. clear: what the
 * picture is filled with. */
int vr_picture_begin(struct vr_picture *picture, const struct vr_frame *frame, const struct vr_stack *stack,
                     int x, int y, float clear, struct brick_error *err);
/* Uniforms of shaders/slices_stack.glsl. */
void vr_picture_set_stack(const struct vr_frame *frame, const struct vr_stack *stack,
                          const struct vr_uniforms *u, int x, int y);
/* From now on keep fragments out of pixels where no more than `termination` gets through. */
int vr_picture_stop(struct vr_picture *picture, const struct vr_frame *frame, double termination,
                    struct brick_error *err);
/* Has some pixel of the rectangle not been stopped? In pixels, inside the picture. */
bool vr_picture_open(const struct vr_picture *picture, const double low[2], const double high[2]);
/* Make of values their classified colours: mode mip. */
int vr_picture_classify(struct vr_picture *picture, const struct vr_frame *frame, struct brick_error *err);

#endif
