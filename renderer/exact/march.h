/* From cell to cell along a ray. */
#ifndef RENDERER_EXACT_MARCH_H
#define RENDERER_EXACT_MARCH_H

#include <stdint.h>

#include <brick/camera.h>
#include <brick/error.h>
#include <brick/transfer.h>

#include "ray.h"

/* Where cells come from; the first member of whatever implements it. One thread at a time. */
struct vr_cells {
    uint64_t dims[3]; /* voxels of the level; cells run from -1 to dims - 1, the volume's edge repeated */
    double scale[3], offset[3]; /* index0 = scale * index + offset */
    /* Physical values at the 8 corners of a cell, x fastest. Returns 1, or 0 when the cell is known to be
     * transparent (corners untouched), or a negative enum brick_result. */
    int (*load)(struct vr_cells *cells, const int64_t cell[3], double corners[8], struct brick_error *err);
};

/* Integrate from t_enter_mm to t_leave_mm (brick_ray_span). tolerance: absolute, per channel. ray starts from
 * zero. */
int vr_march(struct vr_cells *cells, const struct brick_transfer *transfer, const struct brick_ray *ray,
             double t_enter_mm, double t_leave_mm, double tolerance, struct vr_ray_integral *integral,
             struct brick_error *err);

#endif
