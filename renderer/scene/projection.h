/* From a point to its pixel: brick_view's rays the other way round. */
#ifndef RENDERER_SCENE_PROJECTION_H
#define RENDERER_SCENE_PROJECTION_H

#include <brick/camera.h>

#include "vector.h"

/* inverse times (point - origin) is (u w, v w, w) in a perspective, with w how far ahead of the eye the point
 * is in units of dir, and (u, v, w) in a parallel projection. */
struct vr_projection {
    double origin[3], inverse[3][3];
    bool parallel;
};

void vr_projection_init(struct vr_projection *projection, const struct brick_view *view);
/* Rows of the inverse of the matrix with these columns. */
void vr_invert_columns(const double a[3], const double b[3], const double c[3], double inverse[3][3]);

#endif
