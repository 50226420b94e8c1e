/* The walk along a ray, cell by cell.
 *
 * Invariants: the cell is a triple of integers that changes by one on one axis a step; the t at which the ray
 * meets a plane is always computed from that plane's integer, never accumulated; each piece starts where the
 * last one ended. So the pieces cover the span once, whatever rounding does, and a ray through an edge or a
 * corner only meets pieces of no length. A ray that lies in a face stays in the cell of floor(p).
 *
 * Where a piece begins or ends on a face its coordinate is exactly 0 or 1, and the other two are computed in
 * the same way from both sides: two cells that share a face see the same point of it, bit for bit. */
#include "march.h"

#include <math.h>

void vr_corners_subtract(struct vr_corners *corners, double value)
{
    corners->lo -= value;
    corners->hi -= value;
    for (int i = 0; i < 8; i++)
        corners->value[i] -= value;
}

struct walk {
    double origin[3], direction[3]; /* in the level's index coordinates */
    int64_t cell[3];
    int64_t step[3];
    double t_last[3], t_next[3]; /* where the ray entered the cell and leaves it on this axis */
};

static double next_plane(const struct walk *w, int axis)
{
    if (w->step[axis] == 0)
        return INFINITY;
    int64_t plane = w->cell[axis] + (w->step[axis] > 0);
    return ((double)plane - w->origin[axis]) / w->direction[axis];
}

static void start_walk(struct walk *w, const struct vr_cells *cells, const struct brick_ray *ray, double t)
{
    for (int i = 0; i < 3; i++) {
        w->origin[i] = (ray->origin[i] - cells->offset[i]) / cells->scale[i];
        w->direction[i] = ray->direction[i] / cells->scale[i];
        double at = floor(w->origin[i] + t * w->direction[i]);
        w->cell[i] = (int64_t)fmax(-1.0, fmin(at, (double)cells->dims[i] - 1.0));
        w->step[i] = (w->direction[i] > 0.0) - (w->direction[i] < 0.0);
        w->t_last[i] = -INFINITY;
        w->t_next[i] = next_plane(w, i);
    }
}

/* Where the ray is at t, in coordinates of its cell. */
static void locate(const struct walk *w, double t, double at[3])
{
    for (int i = 0; i < 3; i++) {
        double x = (w->origin[i] - (double)w->cell[i]) + t * w->direction[i];
        at[i] = fmin(fmax(x, 0.0), 1.0);
        if (t == w->t_last[i])
            at[i] = w->step[i] > 0 ? 0.0 : 1.0;
        if (t == w->t_next[i])
            at[i] = w->step[i] > 0 ? 1.0 : 0.0;
    }
}

static int visit_cell(struct vr_cells *cells, const struct walk *w, double t0, double t1, vr_visit *visit,
                      void *context, struct brick_error *err)
{
    struct vr_step step = {.t0_mm = t0, .t1_mm = t1};
    for (int i = 0; i < 3; i++)
        step.cell[i] = w->cell[i];
    int loaded = cells->load(cells, step.cell, &step.corners, err);
    if (loaded < 0)
        return loaded;
    step.present = loaded > 0;
    locate(w, t0, step.enter);
    locate(w, t1, step.leave);
    return visit(context, cells, &step, err);
}

int vr_march(struct vr_cells *cells, const struct brick_ray *ray, double t_enter_mm, double t_leave_mm,
             vr_visit *visit, void *context, struct brick_error *err)
{
    struct walk w;
    double t = t_enter_mm;
    start_walk(&w, cells, ray, t);
    while (t < t_leave_mm) {
        int axis = w.t_next[1] < w.t_next[0] ? 1 : 0;
        if (w.t_next[2] < w.t_next[axis])
            axis = 2;
        double end = fmin(w.t_next[axis], t_leave_mm);
        if (end > t) {
            int result = visit_cell(cells, &w, t, end, visit, context, err);
            if (result)
                return result < 0 ? result : BRICK_OK;
            t = end;
        }
        w.cell[axis] += w.step[axis];
        if (w.cell[axis] < -1 || w.cell[axis] >= (int64_t)cells->dims[axis])
            break;
        w.t_last[axis] = w.t_next[axis];
        w.t_next[axis] = next_plane(&w, axis);
    }
    return BRICK_OK;
}
