/* The level's lattice seen along parallel rays: affine, so one cell's projection is every cell's (Maximo et
 * al. 2008, section 4.1). */
#ifndef RENDERER_CELLS_PROJECTION_H
#define RENDERER_CELLS_PROJECTION_H

#include <brick/camera.h>
#include <brick/grid.h>

/* For a point p in the level's index space. */
struct vr_projection {
    double column[4], row[4];            /* . (p, 1): where the picture has it, in pixels */
    double depth[4];                     /* . (p, 1): mm along its ray */
    double direction[3];                 /* voxels a mm of a ray */
    double origin[3], right[3], down[3]; /* the ray of (column, row) = (c, r) is at origin + c right + r down
                                            + depth direction */
};

/* view: of a parallel projection. */
void vr_projection_init(struct vr_projection *projection, const struct brick_view *view,
                        const struct brick_level *level);

#endif
