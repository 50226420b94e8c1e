/* The hits inside a cell: the cubic of section 2.1 and appendix A, solved between verified brackets.
 *
 * Invariants: the side of the field where a ray passes a face is a function of the face's four corners and
 * the ray, and never outside the range of those corners. The two cells of a face therefore agree on it, and
 * so does a cell that was skipped because all its corners are on one side. From a point below to a point
 * above some cell of the way has its two ends on different sides, and a hit is reported there: no ray slips
 * between cells. (Where the paper takes the closed form's roots that are inside the cell, a root that
 * rounding puts outside of both cells is lost.) */
#include "walk.h"

#include <math.h>
#include <stdlib.h>

#include "cubic.h"

static double clamp(double v, double lo, double hi)
{
    v = v > lo ? v : lo;
    return v < hi ? v : hi;
}

/* At p on the face of the cell that is across `axis`, the far one or the near one: as vr_cubic_in_cell has it
 * for a ray that enters there. */
static double on_face(const double corners[8], int axis, bool far, const double p[3])
{
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    const double *c = corners + ((int)far << axis), *d = c + (1 << v);
    return vr_cubic_lerp(vr_cubic_lerp(c[0], c[1 << u], p[u]), vr_cubic_lerp(d[0], d[1 << u], p[u]), p[v]);
}

struct change {
    double s;
    uint32_t surface;
};

/* Is the cubic on one side all the way? Its Bernstein coefficients bound it. */
static bool one_sided(const struct vr_cubic *f, double v, bool above)
{
    double b1 = f->c[0] + 1.0 / 3.0 * f->c[1], b2 = f->c[0] + 1.0 / 3.0 * (2.0 * f->c[1] + f->c[2]);
    return (b1 >= v) == above && (b2 >= v) == above;
}

/* Where the side changes, ascending, at most three times. Extrema of the cubic are found once for all
 * surfaces. */
static int changes_of(const struct vr_cubic *f, double v, bool side0, bool side1, int *extrema,
                      double stops[4], double s[3])
{
    int n = 0;
    if (side0 == side1 && one_sided(f, v, side0))
        return 0;
    if (*extrema < 0) {
        *extrema = vr_cubic_extrema(f, stops + 1);
        stops[0] = 0.0;
    }
    stops[*extrema + 1] = 1.0;
    bool side = side0;
    for (int i = 1; i <= *extrema + 1; i++) {
        bool next = i > *extrema ? side1 : vr_cubic_eval(f, stops[i]) >= v;
        if (next != side)
            s[n++] = vr_cubic_solve(f, v, stops[i - 1], stops[i]);
        side = next;
    }
    return n;
}

static int add_hit(struct vr_iso_walk *walk, const struct vr_iso_hit *hit, struct brick_error *err)
{
    if (walk->hit_count == walk->hit_room) {
        size_t room = walk->hit_room ? 2 * walk->hit_room : 64;
        struct vr_iso_hit *hits = realloc(walk->hits, room * sizeof *hits);
        if (!hits)
            return brick_fail(err, BRICK_ERR_MEMORY, "isotrace: no memory for the hits of a ray");
        walk->hits = hits;
        walk->hit_room = room;
    }
    walk->hits[walk->hit_count++] = *hit;
    return BRICK_OK;
}

int vr_iso_cell(struct vr_iso_walk *walk, const struct vr_iso_block *block, const int32_t at[3],
                const double corners[8], double t0, int axis0, double t1, int axis1, struct brick_error *err)
{
    const struct vr_iso_frame *frame = walk->frame;
    const struct vr_iso_ray *r = &walk->ray;
    struct change change[3 * VR_ISO_MAX_SURFACES];
    double enter[3], leave[3], stops[4];
    int changes = 0, extrema = -1;
    walk->activity->cells++;
    vr_iso_now(walk->activity, VR_ISO_INTERSECTION);
    for (int i = 0; i < 3; i++) {
        double base = r->origin[i] - (double)(block->lo[i] + at[i]);
        enter[i] = i == axis0 ? (double)!r->up[i] : clamp(base + t0 * r->direction[i], 0.0, 1.0);
        leave[i] = i == axis1 ? (double)r->up[i] : clamp(base + t1 * r->direction[i], 0.0, 1.0);
    }
    struct vr_cubic f = vr_cubic_in_cell(corners, enter, leave);
    double at_enter = f.c[0]; /* on_face, where there is a face */
    double at_leave = axis1 < 0 ? vr_cubic_eval(&f, 1.0) : on_face(corners, axis1, r->up[axis1], leave);
    for (uint32_t k = 0; k < frame->surfaces; k++) {
        double v = frame->surface[k].isovalue, s[3];
        int n = changes_of(&f, v, at_enter >= v, at_leave >= v, &extrema, stops, s);
        for (int i = 0; i < n; i++) { /* sorted in; equal ones in the order of surfaces */
            int j = changes++;
            for (; j > 0 && change[j - 1].s > s[i]; j--)
                change[j] = change[j - 1];
            change[j] = (struct change){s[i], k};
        }
    }
    int code = 0;
    vr_iso_now(walk->activity, VR_ISO_SHADING);
    for (int i = 0; i < changes && !code; i++) {
        struct vr_iso_hit hit = {
            .t = t0 + change[i].s * (t1 - t0), .surface = change[i].surface, .light = 1.0};
        double fraction[3];
        if (walk->want_gradient) {
            for (int a = 0; a < 3; a++)
                fraction[a] = enter[a] + change[i].s * (leave[a] - enter[a]);
            frame->kernel->gradient(block, at, fraction, hit.gradient);
        }
        code = add_hit(walk, &hit, err);
        walk->transmittance *= 1.0 - frame->surface[hit.surface].opacity;
        if (!code && walk->transmittance <= frame->termination)
            code = 1;
    }
    vr_iso_now(walk->activity, VR_ISO_TRAVERSAL);
    return code;
}
