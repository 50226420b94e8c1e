/* index0 = origin + column right + row down + depth direction, solved for the three by Cramer's rule. */
#include "projection.h"

#include <math.h>

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void vr_projection_init(struct vr_projection *p, const struct brick_view *view,
                        const struct brick_level *level)
{
    double mm[3], length, volume;
    for (int i = 0; i < 3; i++)
        mm[i] = dot(view->linear[i], view->dir);
    length = sqrt(dot(mm, mm));
    for (int i = 0; i < 3; i++) {
        p->right[i] = view->origin_u[i] / level->scale[i];
        p->down[i] = view->origin_v[i] / level->scale[i];
        p->direction[i] = view->dir[i] / length / level->scale[i];
        p->origin[i] = (view->origin[i] - level->offset[i]) / level->scale[i];
    }
    cross(p->down, p->direction, p->column);
    cross(p->direction, p->right, p->row);
    cross(p->right, p->down, p->depth);
    volume = dot(p->right, p->column);
    double *const rows[3] = {p->column, p->row, p->depth};
    for (int r = 0; r < 3; r++) {
        for (int i = 0; i < 3; i++)
            rows[r][i] /= volume;
        rows[r][3] = -dot(rows[r], p->origin);
    }
}
