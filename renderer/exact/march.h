/* From cell to cell along a ray. */
#ifndef RENDERER_EXACT_MARCH_H
#define RENDERER_EXACT_MARCH_H

#include <stdbool.h>
#include <stdint.h>

#include <brick/camera.h>
#include <brick/error.h>

/* The 8 corners of a cell, physical values, x fastest. */
struct vr_corners {
    double value[8];
    double lo, hi; /* their range */
};

void vr_corners_subtract(struct vr_corners *corners, double value);

/* Where cells come from; the first member of whatever implements it. One thread at a time. */
struct vr_cells {
    uint64_t dims[3]; /* voxels of the level; cells run from -1 to dims - 1, the volume's edge repeated */
    double scale[3], offset[3]; /* index0 = scale * index + offset */
    /* Returns 1; or 0 when the cell is known to be transparent or has a corner that is not finite; or a
     * negative enum brick_result. A cell that is known to lie on one side of the isovalue may come with all
     * corners at one value of that side. */
    int (*load)(struct vr_cells *cells, const int64_t cell[3], struct vr_corners *corners,
                struct brick_error *err);
    /* Central differences at +-1 voxel in the level's index space, at the corners of the cell loaded last:
     * interpolated, they are the trilinear field's everywhere in the cell, for a shift by a voxel meets the
     * same faces. A component with a neighbour that is not finite is 0 in the whole cell. */
    void (*gradient)(struct vr_cells *cells, const int64_t cell[3], double gradient[3][8]);
};

/* A ray's way through one cell. */
struct vr_step {
    int64_t cell[3];
    bool present;              /* load returned 1 */
    double t0_mm, t1_mm;       /* t0 < t1 */
    double enter[3], leave[3]; /* in cell coordinates, in [0,1]; exactly 0 or 1 where the ray meets a face */
    struct vr_corners corners; /* when present */
};

/* Returns 0 to go on, 1 to stop, or a negative enum brick_result. */
typedef int vr_visit(void *context, struct vr_cells *cells, const struct vr_step *step,
                     struct brick_error *err);

/* Visit the cells from t_enter_mm to t_leave_mm (inside brick_ray_span), nearest first. */
int vr_march(struct vr_cells *cells, const struct brick_ray *ray, double t_enter_mm, double t_leave_mm,
             vr_visit *visit, void *context, struct brick_error *err);

#endif
