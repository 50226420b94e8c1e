/* Segments of a ray inside one cell: cut into pieces that emission.c integrates. */
#ifndef RENDERER_EXACT_RAY_H
#define RENDERER_EXACT_RAY_H

#include <brick/transfer.h>

#include "emission.h"

/* Go on along a segment of length_mm over which the field is f(s), s in [0,1]. light: over the same s, its
 * facing may change sign; NULL: unlit. tolerance: as in vr_ray_add_piece. f is finite. ray->length_mm is set.
 */
void vr_ray_add(struct vr_ray_integral *ray, const struct brick_transfer *transfer, const struct vr_cubic *f,
                const struct vr_light *light, double length_mm, double tolerance);
/* The same with extinction a mm and colour themselves given along the segment. */
void vr_ray_add_classified(struct vr_ray_integral *ray, const struct brick_transfer *transfer,
                           const struct vr_cubic *sigma, const struct vr_cubic rgb[3],
                           const struct vr_light *light, double length_mm, double tolerance);

#endif
