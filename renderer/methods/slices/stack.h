/* Where the slices are: planes of one depth each, evenly spaced over the length of the volume's diagonal
 * around its centre (Wilson, Van Gelder and Wilhelms 1994, section 2.2), and how points of the volume are
 * seen in the picture. */
#ifndef RENDERER_METHODS_SLICES_STACK_H
#define RENDERER_METHODS_SLICES_STACK_H

#include "frame.h"
#include "outline.h"

/* Depth: in mm along the view's axis, 0 at the eye or the plane from which parallel rays start. Slice k lies
 * between first_mm + k * spacing_mm and one spacing more; its plane is in the middle. */
struct vr_stack {
    bool perspective;
    bool slabs; /* pre-integrated: samples lie on the slices' faces */
    double first_mm, spacing_mm;
    int count;
    double low[3], high[3];             /* level 0's box in the level's index space */
    double eye[3], dir[3];              /* in that space: perspective; where the middle of the view leads */
    double seen[3][4];                  /* index -> depth and place in the picture (struct vr_corner) */
    double mm[3];                       /* index units a mm across each axis' faces */
    double pixel_mm;                    /* a pixel's edge; in perspective at a depth of 1 mm */
    double reach_mm;                    /* the longest way of a ray through a slice */
    double near_mm;                     /* perspective: what is nearer is seen only from within a box */
    double clip[VR_MAX_CLIP_PLANES][4]; /* the scene's, in the level's index space: keep . (p, 1) >= 0 */
    int clip_count;
};

/* planes: how many there are; 0: one a step of the frame; VR_PLANES_PAPER: as many as make one a voxel when
 * the volume is seen along an axis (section 2.2.4), and pre-integrated as many more as it takes.
 * BRICK_ERR_ARGUMENT when that are too many to count, or too few for pre-integrated classification: both ends
 * of a slab must lie in cells that touch, at the most (shaders/segments.glsl). */
int vr_stack_init(struct vr_stack *stack, const struct vr_frame *frame, uint32_t planes,
                  struct brick_error *err);

/* A box in the level's index space, and what slices must know of it to draw a part of a part of it. */
struct vr_stack_box {
    struct vr_corner corners[8]; /* of the box a little enlarged: beyond what rasterisation rounds */
    int first, last;             /* slices that it may have a part in; last < first: none */
    bool whole; /* all samples lie in the middle of slices: no ray's span begins or ends in a slice here */
    bool around_eye;
};

/* Clip planes hide boxes, too. */
void vr_stack_place(const struct vr_stack *stack, const double low[3], const double high[3],
                    struct vr_stack_box *box);
/* The polygon that covers at least the pixels whose sample of slice k is in the box (outline.h). */
int vr_stack_outline(const struct vr_stack *stack, const struct vr_stack_box *box, int k,
                     const struct vr_window *window, double polygon[VR_OUTLINE_MAX][2]);

#endif
