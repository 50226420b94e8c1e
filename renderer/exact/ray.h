/* Emission and absorption along one ray, front to back, in double precision. */
#ifndef RENDERER_EXACT_RAY_H
#define RENDERER_EXACT_RAY_H

#include <stdint.h>

#include <brick/transfer.h>

#include "cubic.h"

struct vr_ray_integral {
    double depth;         /* optical depth so far: transmittance is exp(-depth) */
    double rgb[3];        /* emission so far, premultiplied */
    uint64_t evaluations; /* of the emission's integrand */
};

/* Go on along a segment of length_mm over which the field is f(s), s in [0,1]. tolerance: the emission's
 * error over the whole ray, absolute, per channel, however many segments it has. f is finite. */
void vr_ray_add(struct vr_ray_integral *ray, const struct brick_transfer *transfer, const struct vr_cubic *f,
                double length_mm, double tolerance);

#endif
