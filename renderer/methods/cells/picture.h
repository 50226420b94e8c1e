/* A picture of projected cells, and what is different in its two kinds: how a cell that shows something is
 * drawn. What is found of it is the same: where rays enter and leave its tetrahedra, which shaders/
 * cells_integrate.glsl makes colours of. */
#ifndef RENDERER_CELLS_PICTURE_H
#define RENDERER_CELLS_PICTURE_H

#include "lattice.h"
#include "lot.h"
#include "scene.h"

#define VR_CELLS_MAX_PLANES (VR_MAX_CLIP_PLANES + 4) /* the box's upper faces, the eye's plane */
#define VR_CELLS_SIDES      5

enum { VR_CELLS_UNIT_LIST = VR_UNIT_METHOD, VR_CELLS_UNIT_BASIS, VR_CELLS_UNIT_SHOWN, VR_CELLS_UNIT_TABLE };

/* Kept from picture to picture. */
struct vr_cells_state {
    struct vr_cell_lot lot;
    struct vr_buffer basis, shown, psi, exponentials;
};

/* One picture. Planes are in the level's index space and keep . (p, 1) >= 0. */
struct vr_cells_picture {
    struct vr_cells_state *cells;
    const struct vr_frame *frame;
    const struct vr_cells_projection *projection;
    struct vr_lattice lattice;
    double plane[VR_CELLS_MAX_PLANES][4]; /* what cuts cells */
    int planes;
    struct vr_cell_draw draw;
    int left, top, width, height;   /* the part being drawn */
    double side[VR_CELLS_SIDES][4]; /* what shows in it */
    struct brick_image *image;
    struct vr_report *report;
};

struct vr_cells_projection {
    struct vr_program_source source; /* with CUTS defined: planes that cut, where there are any */
    int segments;                    /* pieces of a ray that a fragment adds up, at most */
    /* The lot's shape, and uniforms and arrays that depend on the lattice only. */
    int (*begin)(struct vr_cells_picture *picture, struct brick_error *err);
    /* Uniforms that depend on the part. */
    void (*set_part)(const struct vr_cells_picture *picture);
};

extern const struct vr_cells_projection vr_cells_fans;  /* parallel */
extern const struct vr_cells_projection vr_cells_boxes; /* perspective */

#endif
