/* Two fields between the same voxels.
 *
 * Trilinear: a cubic along the ray. Tetrahedra: each cell is split into five, one in the middle whose
 * vertices are the four voxels with an even sum of indices, and four around it, each at an odd voxel (Maximo
 * et al. 2008, section 4.1, and the alternation that makes neighbours' face diagonals coincide); inside each
 * the field is linear. Beyond the outermost samples both are constant: for tetrahedra the position is moved
 * to the edge first.
 *
 * End values are what sides are decided on, so they are exact where exactness has a meaning: at a voxel,
 * where corners are equal, and in never leaving the corners' range. */
#include "field.h"

#include <math.h>
#include <string.h>

static double lerp(double a, double b, double x)
{
    if (x == 1.0)
        return b;
    double y = a + x * (b - a);
    return fmin(fmax(y, fmin(a, b)), fmax(a, b));
}

double vr_field_trilinear(const double v[8], const double at[3])
{
    double low = lerp(lerp(v[0], v[1], at[0]), lerp(v[2], v[3], at[0]), at[1]);
    double high = lerp(lerp(v[4], v[5], at[0]), lerp(v[6], v[7], at[0]), at[1]);
    return lerp(low, high, at[2]);
}

/* Four times a volume: how far a point lies inside the tetrahedron at one of the four vertices that the
 * middle one lacks (1, 2, 4 and 7 of a cell whose first corner is even); below 0 outside. */
static double depth_in_outer(int which, const double p[3])
{
    if (which == 3)
        return p[0] + p[1] + p[2] - 2.0;
    return 2.0 * p[which] - (p[0] + p[1] + p[2]);
}

/* The value at p of the tetrahedron, 0 to 3 an outer one, 4 the middle one. p and v of an even cell. */
static double tetrahedron_value(int which, const double v[8], const double p[3])
{
    double weight[4], value[4], sum = 0.0;
    if (which == 4) {
        for (int i = 0; i < 3; i++) { /* vertices 6, 5 and 3: the ones across from axis i */
            weight[i] = 0.5 * (p[0] + p[1] + p[2]) - p[i];
            value[i] = v[7 ^ 1 << i];
        }
        weight[3] = 1.0 - 0.5 * (p[0] + p[1] + p[2]);
        value[3] = v[0];
    } else {
        int outer = which == 3 ? 7 : 1 << which;
        weight[3] = 1.0;
        value[3] = v[outer];
        for (int i = 0; i < 3; i++) {
            weight[i] = outer >> i & 1 ? 1.0 - p[i] : p[i];
            weight[3] -= weight[i];
            value[i] = v[outer ^ 1 << i];
        }
    }
    double lo = value[0], hi = value[0];
    for (int i = 0; i < 4; i++) {
        lo = fmin(lo, value[i]);
        hi = fmax(hi, value[i]);
        sum += weight[i] * value[i];
    }
    return fmin(fmax(sum, lo), hi);
}

static void between(const double a[3], const double b[3], double s, double at[3])
{
    for (int i = 0; i < 3; i++)
        at[i] = s == 1.0 ? b[i] : a[i] + s * (b[i] - a[i]);
}

static int tetrahedra(const struct vr_cells *cells, const struct vr_step *step,
                      struct vr_segment segments[VR_MAX_SEGMENTS])
{
    double enter[3], leave[3], v[8], cuts[6] = {0.0};
    int count = 1, n = 0;
    int odd = (int)((step->cell[0] + step->cell[1] + step->cell[2]) & 1);
    for (int i = 0; i < 3; i++) {
        enter[i] = step->enter[i];
        leave[i] = step->leave[i];
        if (step->cell[i] < 0)
            enter[i] = leave[i] = 1.0;
        else if (step->cell[i] + 1 >= (int64_t)cells->dims[i])
            enter[i] = leave[i] = 0.0;
    }
    if (odd) { /* an odd cell is an even one seen in a mirror */
        enter[0] = 1.0 - enter[0];
        leave[0] = 1.0 - leave[0];
    }
    for (int i = 0; i < 8; i++)
        v[i] = step->corners.value[i ^ odd];

    for (int i = 0; i < 4; i++) {
        double h0 = depth_in_outer(i, enter), h1 = depth_in_outer(i, leave);
        if ((h0 < 0.0 && h1 > 0.0) || (h0 > 0.0 && h1 < 0.0)) {
            int at = count++;
            for (; cuts[at - 1] > h0 / (h0 - h1); at--)
                cuts[at] = cuts[at - 1];
            cuts[at] = h0 / (h0 - h1);
        }
    }
    cuts[count] = 1.0;
    for (int i = 0; i < count; i++) {
        struct vr_segment *s = &segments[n];
        double at[3];
        int which = 4;
        if (!(cuts[i + 1] > cuts[i]))
            continue;
        between(enter, leave, 0.5 * (cuts[i] + cuts[i + 1]), at);
        for (int k = 0; k < 4; k++)
            if (depth_in_outer(k, at) > 0.0)
                which = k;
        s->a = cuts[i];
        s->b = cuts[i + 1];
        between(enter, leave, s->a, at);
        s->from = tetrahedron_value(which, v, at);
        between(enter, leave, s->b, at);
        s->to = tetrahedron_value(which, v, at);
        s->f = (struct vr_cubic){{s->from, s->to - s->from, 0.0, 0.0}};
        n++;
    }
    return n;
}

int vr_field_segments(enum vr_field field, const struct vr_cells *cells, const struct vr_step *step,
                      struct vr_segment segments[VR_MAX_SEGMENTS])
{
    if (field == VR_FIELD_TETRAHEDRA)
        return tetrahedra(cells, step, segments);
    segments[0].a = 0.0;
    segments[0].b = 1.0;
    segments[0].f = vr_cubic_in_cell(step->corners.value, step->enter, step->leave);
    segments[0].from = vr_field_trilinear(step->corners.value, step->enter);
    segments[0].to = vr_field_trilinear(step->corners.value, step->leave);
    return 1;
}
