/* Parallel: index0 = origin + column right + row down + depth direction, solved for the three. Perspective:
 * index0 = origin + depth (column right + row down + direction), solved for depth and its products. */
#include "lattice.h"

#include <math.h>
#include <string.h>

#include "projection.h"

void vr_lattice_init(struct vr_lattice *p, const struct brick_view *view, const struct brick_level *level)
{
    double mm[3], inverse[3][3], length;
    p->perspective = vr_dot(view->origin_u, view->origin_u) == 0.0;
    for (int i = 0; i < 3; i++)
        mm[i] = vr_dot(view->linear[i], view->dir);
    length = p->perspective ? 1.0 : sqrt(vr_dot(mm, mm));
    for (int i = 0; i < 3; i++) {
        p->right[i] = (p->perspective ? view->dir_u : view->origin_u)[i] / level->scale[i];
        p->down[i] = (p->perspective ? view->dir_v : view->origin_v)[i] / level->scale[i];
        p->direction[i] = view->dir[i] / length / level->scale[i];
        p->origin[i] = (view->origin[i] - level->offset[i]) / level->scale[i];
    }
    vr_invert_columns(p->right, p->down, p->direction, inverse);
    double *const rows[3] = {p->column, p->row, p->depth};
    for (int r = 0; r < 3; r++) {
        memcpy(rows[r], inverse[r], sizeof inverse[r]);
        rows[r][3] = -vr_dot(rows[r], p->origin);
    }
}
