/* Where rays may begin and end: the bounding geometry rasterised, first front faces and last back faces
 * (Scharsach 2005, sections 3 and 7). What comes out is conservative: outside of it a ray meets no sample of
 * an active block. */
#ifndef RENDERER_METHODS_BOUNDS_H
#define RENDERER_METHODS_BOUNDS_H

#include "blocks.h"

/* Kept from picture to picture. One of zeros is empty. */
struct vr_bounds {
    struct vr_blocks blocks;
    struct vr_buffer buffer; /* of their rows */
    int width, height;       /* of the textures */
    GLuint texture[2], framebuffer[2], vertex_array;
    double margin[3];     /* by which blocks are larger, voxels of level 0 */
    double scale;         /* depth a unit of how far ahead, a power of two */
    double nearest_ahead; /* nothing drawn is nearer */
    bool inside;          /* the eye is in an active block: rays begin where it is */
};

/* Before a picture's first pass: the border of what is active, and room for parts of width x height pixels.
 */
int vr_bounds_begin(struct vr_bounds *bounds, const struct vr_frame *frame, int width, int height,
                    struct brick_error *err);
/* Draw the part of the picture whose corner is pixel x, y; leaves another program in use. */
int vr_bounds_draw(const struct vr_bounds *bounds, const struct vr_frame *frame, int x, int y,
                   struct brick_error *err);
/* What shaders/ray.glsl needs of the part drawn last. */
void vr_bounds_use(const struct vr_bounds *bounds, const struct vr_frame *frame, const struct vr_uniforms *u);
void vr_bounds_finish(struct vr_bounds *bounds, struct vr_context *context);

#endif
