/* The inverse of the matrix whose columns are how a point moves with u, v and ahead. */
#include "projection.h"

#include <string.h>

void vr_invert_columns(const double a[3], const double b[3], const double c[3], double inverse[3][3])
{
    vr_cross(b, c, inverse[0]);
    vr_cross(c, a, inverse[1]);
    vr_cross(a, b, inverse[2]);
    double determinant = vr_dot(a, inverse[0]);
    for (int i = 0; i < 9; i++)
        inverse[i / 3][i % 3] /= determinant;
}

void vr_projection_init(struct vr_projection *p, const struct brick_view *view)
{
    p->parallel = vr_dot(view->dir_u, view->dir_u) == 0.0;
    memcpy(p->origin, view->origin, sizeof p->origin);
    if (p->parallel)
        vr_invert_columns(view->origin_u, view->origin_v, view->dir, p->inverse);
    else
        vr_invert_columns(view->dir_u, view->dir_v, view->dir, p->inverse);
}
