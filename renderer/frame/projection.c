/* The inverse of the matrix whose columns are how a point moves with u, v and ahead. */
#include "projection.h"

static void cross(const double a[3], const double b[3], double r[3])
{
    for (int i = 0; i < 3; i++)
        r[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

double vr_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void vr_projection_init(struct vr_projection *p, const struct brick_view *view)
{
    const double *u = view->dir_u, *v = view->dir_v;
    double determinant;
    p->parallel = vr_dot(u, u) == 0.0;
    if (p->parallel)
        u = view->origin_u, v = view->origin_v;
    cross(v, view->dir, p->inverse[0]);
    cross(view->dir, u, p->inverse[1]);
    cross(u, v, p->inverse[2]);
    determinant = vr_dot(u, p->inverse[0]);
    for (int i = 0; i < 3; i++) {
        p->origin[i] = view->origin[i];
        for (int j = 0; j < 3; j++)
            p->inverse[i][j] /= determinant;
    }
}
