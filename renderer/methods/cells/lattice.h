/* The level's lattice seen from the camera. Along parallel rays that is affine, so one cell's projection is
 * every cell's (Maximo et al. 2008, section 4.1); in a perspective it is projective, and no two cells look
 * the same. */
#ifndef RENDERER_CELLS_LATTICE_H
#define RENDERER_CELLS_LATTICE_H

#include <stdbool.h>

#include <brick/camera.h>
#include <brick/grid.h>

/* For a point p in the level's index space. Parallel: it is at (column, row) = (column . (p, 1), row . (p,
 * 1)) of the picture, in pixels, depth . (p, 1) mm along its ray, and the ray of (column, row) = (c, r) is at
 * origin + c right + r down + t direction after t mm. Perspective: depth . (p, 1) is how far it is ahead of
 * the eye, column and row . (p, 1) are that many times its place, and the ray of (c, r) is at origin + t (c
 * right + r down + direction), origin being the eye and t that same depth. */
struct vr_lattice {
    bool perspective;
    double column[4], row[4], depth[4];
    double origin[3], right[3], down[3], direction[3];
};

void vr_lattice_init(struct vr_lattice *lattice, const struct brick_view *view,
                     const struct brick_level *level);

#endif
