/* The walk along a ray, cell by cell.
 *
 * Invariants: the cell is a triple of integers that changes by one on one axis a step; the t at which the ray
 * meets a plane is always computed from that plane's integer, never accumulated; each piece starts where the
 * last one ended. So the pieces cover the span once, whatever rounding does, and a ray through an edge or a
 * corner only meets pieces of no length. A ray that lies in a face stays in the cell of floor(p). Field
 * coordinates may overshoot a cell by rounding, where the cell's polynomial carries on continuously. */
#include "march.h"

#include <math.h>

struct walk {
    double origin[3], direction[3]; /* in the level's index coordinates */
    int64_t cell[3];
    int64_t step[3];
    double t_next[3]; /* where the ray leaves the cell on this axis */
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
        w->t_next[i] = next_plane(w, i);
    }
}

int vr_march(struct vr_cells *cells, const struct brick_transfer *transfer, const struct brick_ray *ray,
             double t_enter_mm, double t_leave_mm, double tolerance, struct vr_ray_integral *integral,
             struct brick_error *err)
{
    /* What lies behind this depth adds less than a hundredth of the tolerance to any channel. */
    double enough = -log(tolerance / 100.0);
    struct walk w;
    double t = t_enter_mm;
    start_walk(&w, cells, ray, t);
    while (t < t_leave_mm && integral->depth < enough) {
        int axis = w.t_next[1] < w.t_next[0] ? 1 : 0;
        if (w.t_next[2] < w.t_next[axis])
            axis = 2;
        double end = fmin(w.t_next[axis], t_leave_mm);
        if (end > t) {
            double corners[8], enter[3], leave[3];
            int loaded = cells->load(cells, w.cell, corners, err);
            if (loaded < 0)
                return loaded;
            if (loaded) {
                for (int i = 0; i < 3; i++) {
                    enter[i] = (w.origin[i] - (double)w.cell[i]) + t * w.direction[i];
                    leave[i] = (w.origin[i] - (double)w.cell[i]) + end * w.direction[i];
                }
                struct vr_cubic f = vr_cubic_in_cell(corners, enter, leave);
                vr_ray_add(integral, transfer, &f, end - t, 0.9 * tolerance);
            }
            t = end;
        }
        w.cell[axis] += w.step[axis];
        if (w.cell[axis] < -1 || w.cell[axis] >= (int64_t)cells->dims[axis])
            break;
        w.t_next[axis] = next_plane(&w, axis);
    }
    return BRICK_OK;
}
