/* Polygons on their way to the GPU: one draw for many, of many slices and boxes, in the order in which they
 * were added, which is the order in which they are blended. */
#ifndef RENDERER_METHODS_SLICES_SHEETS_H
#define RENDERER_METHODS_SLICES_SHEETS_H

#include "buffer.h"

/* Kept from picture to picture; sheets of zeros are empty. */
struct vr_sheets {
    struct vr_buffer vertex_buffer, box_buffer;
    GLuint vertex_array;
    uint32_t (*vertex)[4], (*box)[4]; /* shaders/slices.vert.glsl */
    size_t vertices, vertex_room, boxes, box_room;
};

/* The context is bound in all but the first two of these. */

/* A box of voxels, and what is added to one for its texel in the atlas. rim: 0, or the brick's sides that
 * have one, a bit each, and shifted by 6 the bit of the side whose rim this is (shaders/slices_slab.glsl).
 * *number: of the box, until the next draw. */
int vr_sheets_box(struct vr_sheets *sheets, const int low[3], const int high[3], const int offset[3],
                  uint32_t rim, uint32_t *number, struct brick_error *err);
/* A box' part of a plane: a convex polygon of n >= 3 vertices, in the framebuffer's pixels. */
int vr_sheets_add(struct vr_sheets *sheets, uint32_t box, int plane, double (*polygon)[2], int n,
                  struct brick_error *err);
/* Draw with the program in use, which takes its lists from units `unit` and the next, and forget. */
int vr_sheets_draw(struct vr_sheets *sheets, struct vr_context *context, GLuint unit,
                   struct brick_error *err);
void vr_sheets_finish(struct vr_sheets *sheets, struct vr_context *context);

#endif
