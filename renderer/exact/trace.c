/* What each mode makes of the cells on a ray.
 *
 * Iso. A value is above when it is not less than the isovalue; the hit is the first t where the side changes.
 * The side found at a cell's end is carried into the next cell, so that a surface that rounding puts on the
 * face between two cells is hit there and not by neither. A cell with a corner that is not finite has no
 * side, and behind it the ray starts anew. */
#include "trace.h"

#include <math.h>

#include "field.h"

enum side { SIDE_NONE, SIDE_BELOW, SIDE_ABOVE };

struct trace {
    const struct vr_look *look;
    struct vr_traced *out;
    double view[3]; /* world, unit */
    double enough;  /* dvr: depth behind which nothing matters */
    double largest; /* mip; -inf so far: nothing */
    enum side side; /* iso: of the last point */
};

static struct vr_light light_of_step(const struct trace *t, struct vr_cells *cells,
                                     const struct vr_step *step)
{
    const struct vr_look *look = t->look;
    struct vr_light light = {.ambient = look->ambient,
                             .diffuse = look->diffuse,
                             .specular = look->specular,
                             .shininess = look->shininess};
    double corners[3][8];
    cells->gradient(cells, step->cell, corners);
    for (int a = 0; a < 3; a++) {
        struct vr_cubic g = vr_cubic_in_cell(corners[a], step->enter, step->leave);
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 4; k++) {
                double part = look->normal[i][a] * g.c[k];
                light.normal[i].c[k] += part;
                light.facing.c[k] += part * t->view[i];
            }
    }
    return light;
}

static void add_classified(struct trace *t, const struct vr_step *step, const struct vr_light *light)
{
    double sigma[8], rgb[3][8], most = 0.0;
    struct vr_cubic colour[3];
    for (int i = 0; i < 8; i++) {
        double voxel[3];
        brick_transfer_eval(t->look->transfer, step->corners.value[i], voxel, &sigma[i]);
        most = fmax(most, sigma[i]);
        for (int c = 0; c < 3; c++) {
            rgb[c][i] = voxel[c];
            if (t->look->transfer->emission == BRICK_EMISSION_INDEPENDENT)
                most = fmax(most, voxel[c]);
        }
    }
    if (most == 0.0)
        return;
    struct vr_cubic extinction = vr_cubic_in_cell(sigma, step->enter, step->leave);
    for (int c = 0; c < 3; c++)
        colour[c] = vr_cubic_in_cell(rgb[c], step->enter, step->leave);
    vr_ray_add_classified(&t->out->light, t->look->transfer, &extinction, colour, light,
                          step->t1_mm - step->t0_mm, t->look->tolerance);
}

static int visit_dvr(void *context, struct vr_cells *cells, const struct vr_step *step,
                     struct brick_error *err)
{
    struct trace *t = context;
    struct vr_segment segments[VR_MAX_SEGMENTS];
    struct vr_light light, part;
    bool lit = t->look->mode == BRICK_MODE_SHADED;
    (void)err;
    if (!step->present)
        return 0;
    if (lit)
        light = light_of_step(t, cells, step);
    if (t->look->field == VR_FIELD_PRECLASSIFIED) {
        add_classified(t, step, lit ? &light : NULL);
        return t->out->light.depth >= t->enough;
    }
    int n = vr_field_segments(t->look->field, cells, step, segments);
    for (int i = 0; i < n; i++) {
        const struct vr_segment *s = &segments[i];
        if (lit)
            part = n > 1 ? vr_light_part(&light, s->a, s->b) : light;
        vr_ray_add(&t->out->light, t->look->transfer, &s->f, lit ? &part : NULL,
                   (step->t1_mm - step->t0_mm) * (s->b - s->a), t->look->tolerance);
    }
    return t->out->light.depth >= t->enough;
}

static int visit_mip(void *context, struct vr_cells *cells, const struct vr_step *step,
                     struct brick_error *err)
{
    struct trace *t = context;
    struct vr_segment segments[VR_MAX_SEGMENTS];
    (void)err;
    if (!step->present || step->corners.hi <= t->largest)
        return 0;
    int n = vr_field_segments(t->look->field, cells, step, segments);
    t->out->light.evaluations++;
    for (int i = 0; i < n; i++) {
        double turns[2], largest = fmax(segments[i].from, segments[i].to);
        int turn_count = vr_cubic_extrema(&segments[i].f, turns);
        for (int k = 0; k < turn_count; k++)
            largest = fmax(largest, fmin(vr_cubic_eval(&segments[i].f, turns[k]), step->corners.hi));
        t->largest = fmax(t->largest, largest);
    }
    return 0;
}

/* s of the step's [0,1]. */
static int hit(struct trace *t, struct vr_cells *cells, const struct vr_step *step, double s)
{
    struct vr_light light = light_of_step(t, cells, step);
    vr_light_shade(&light, s, t->look->surface, t->out->light.rgb);
    t->out->light.depth = INFINITY;
    t->out->hit_mm = step->t0_mm + s * (step->t1_mm - step->t0_mm);
    return 1;
}

static int visit_iso(void *context, struct vr_cells *cells, const struct vr_step *step,
                     struct brick_error *err)
{
    struct trace *t = context;
    struct vr_segment segments[VR_MAX_SEGMENTS];
    struct vr_step less = *step; /* the isovalue: a voxel that has it is exactly 0 */
    (void)err;
    if (!step->present) {
        t->side = SIDE_NONE;
        return 0;
    }
    vr_corners_subtract(&less.corners, t->look->isovalue);
    if (less.corners.lo >= 0.0 || less.corners.hi < 0.0) {
        enum side side = less.corners.lo >= 0.0 ? SIDE_ABOVE : SIDE_BELOW;
        if (t->side != SIDE_NONE && t->side != side)
            return hit(t, cells, step, 0.0);
        t->side = side;
        return 0;
    }
    int n = vr_field_segments(t->look->field, cells, &less, segments);
    t->out->light.evaluations++;
    for (int i = 0; i < n; i++) {
        const struct vr_segment *s = &segments[i];
        bool above = s->from >= 0.0, above_end = s->to >= 0.0;
        double at;
        if (t->side != SIDE_NONE && t->side != (above ? SIDE_ABOVE : SIDE_BELOW))
            return hit(t, cells, step, s->a);
        if (vr_cubic_first_crossing(&s->f, above, above_end, &at))
            return hit(t, cells, step, s->a + at * (s->b - s->a));
        t->side = above_end ? SIDE_ABOVE : SIDE_BELOW;
    }
    return 0;
}

static void classify_largest(struct trace *t)
{
    double rgb[3], sigma;
    if (t->largest == -INFINITY)
        return;
    brick_transfer_eval(t->look->transfer, t->largest, rgb, &sigma);
    t->out->light.depth = sigma * t->look->transfer->unit_mm;
    for (int c = 0; c < 3; c++)
        t->out->light.rgb[c] = rgb[c] * -expm1(-t->out->light.depth);
}

int vr_trace(const struct vr_look *look, struct vr_cells *cells, const struct brick_ray *ray,
             double t_enter_mm, double t_leave_mm, struct vr_traced *traced, struct brick_error *err)
{
    static vr_visit *const visits[] = {visit_dvr, visit_dvr, visit_iso, visit_mip};
    struct trace t = {.look = look, .out = traced, .largest = -INFINITY};
    /* What lies behind this depth adds less than a hundredth of the tolerance to any channel. */
    double brightest = look->mode == BRICK_MODE_SHADED ? look->ambient + look->diffuse + look->specular : 1.0;
    if (look->transfer && look->transfer->emission == BRICK_EMISSION_INDEPENDENT)
        brightest *= (t_leave_mm - t_enter_mm) / look->transfer->unit_mm;
    t.enough = -log(look->tolerance / 100.0 / fmax(brightest, 1.0));
    *traced = (struct vr_traced){.hit_mm = INFINITY, .light.length_mm = t_leave_mm - t_enter_mm};
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            t.view[i] += look->linear[i][a] * ray->direction[a];
    int result = vr_march(cells, ray, t_enter_mm, t_leave_mm, visits[look->mode], &t, err);
    if (!result && look->mode == BRICK_MODE_MIP)
        classify_largest(&t);
    return result;
}
