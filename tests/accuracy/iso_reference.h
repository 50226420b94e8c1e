/* Where a ray first meets an isosurface, in long double, without any of renderer's code: in each interval
 * between the planes of voxels the field is a cubic in t; it is interpolated from four of its values, its
 * extrema part the interval, and the first part with ends on different sides is bisected. */
#ifndef TESTS_ACCURACY_ISO_REFERENCE_H
#define TESTS_ACCURACY_ISO_REFERENCE_H

#include <math.h>
#include <stdbool.h>

#include "reference_volume.h"

struct iso_reference {
    bool hit;
    long double t;
    /* Smallest distance of the field from the isovalue where a double decision might go wrong: at extrema
     * that do not reach over, before the hit. */
    long double nearest;
};

/* The field; a voxel that is not finite has no say beyond the faces of its cells. */
static inline long double iso_reference_field(struct reference_volume *v, long double t)
{
    long double p[3], weight[8], sum = 0.0L;
    int64_t voxel[8];
    reference_position(v, t, p);
    reference_corners(v, p, weight, voxel);
    for (int i = 0; i < 8; i++)
        if (weight[i] != 0.0L)
            sum += weight[i] * v->voxels[voxel[i]];
    return sum;
}

/* Values this near to the isovalue are the isovalue: a plateau at it sums to it but for rounding. */
static inline bool iso_reference_above(long double f, double v, long double scale)
{
    return f - v >= -1e-17L * scale;
}

/* t of the extrema of the cubic through four values, ascending. */
static inline int iso_reference_extrema(struct reference_volume *v, long double a, long double b,
                                        long double t[2])
{
    long double y[4], low = a, high = b, w = 0.75L * (b - a);
    a += 0.125L * (b - a); /* away from the ends, which the next cells share */
    for (int i = 0; i < 4; i++)
        y[i] = iso_reference_field(v, a + w * (long double)i / 3.0L);
    long double d1 = y[1] - y[0], d2 = y[2] - 2 * y[1] + y[0], d3 = y[3] - 3 * y[2] + 3 * y[1] - y[0];
    /* f(x) = y0 + d1 x + d2 x(x-1)/2 + d3 x(x-1)(x-2)/6, x = 3 s */
    long double p = d1 - d2 / 2 + d3 / 3, q = d2 - d3, r = d3 / 2; /* f' = p + q x + r x^2 */
    long double disc = q * q - 4 * p * r, x[2];
    int n = 0, count = 0;
    if (r == 0.0L) {
        if (q == 0.0L)
            return 0;
        x[count++] = -p / q;
    } else if (disc > 0.0L) {
        long double z = -0.5L * (q + copysignl(sqrtl(disc), q));
        x[0] = z / r;
        x[1] = z != 0.0L ? p / z : x[0];
        count = 2;
        if (x[0] > x[1]) {
            long double swap = x[0];
            x[0] = x[1];
            x[1] = swap;
        }
    }
    for (int i = 0; i < count; i++)
        if (a + w * x[i] / 3.0L > low && a + w * x[i] / 3.0L < high)
            t[n++] = a + w * x[i] / 3.0L;
    return n;
}

static inline struct iso_reference iso_reference_ray(struct reference_volume *v, const struct brick_ray *ray,
                                                     double isovalue, double enter, double leave,
                                                     long double scale)
{
    struct iso_reference r = {.nearest = INFINITY};
    long double cuts[REFERENCE_MAX_PLANES + 1];
    size_t count = reference_cuts(v, ray, enter, leave, cuts);
    v->ray = ray;
    cuts[count] = leave;
    for (size_t i = 0; i < count && !r.hit; i++) {
        long double stops[4] = {cuts[i]};
        if (!isfinite((double)iso_reference_field(v, 0.5L * (cuts[i] + cuts[i + 1]))))
            continue; /* a cell without a side; rays in faces are not for volumes with such cells */
        int n = iso_reference_extrema(v, cuts[i], cuts[i + 1], stops + 1);
        stops[++n] = cuts[i + 1];
        for (int k = 0; k < n && !r.hit; k++) {
            long double a = stops[k], b = stops[k + 1];
            long double hair = fminl(0.5L * (b - a), 1e-16L * (fabsl(a) + 1.0L));
            long double fa = iso_reference_field(v, a), fb = iso_reference_field(v, b);
            if (!isfinite(
                    (double)
                        fa)) /* at a plane a neighbour that is not finite may have the say: a hair inside */
                fa = iso_reference_field(v, a + hair);
            if (!isfinite((double)fb))
                fb = iso_reference_field(v, b - hair);
            bool side = iso_reference_above(fa, isovalue, scale);
            if (side == iso_reference_above(fb, isovalue, scale)) {
                r.nearest = fminl(r.nearest, fabsl(fb - isovalue));
                continue;
            }
            for (int step = 0; step < 80; step++) {
                long double middle = 0.5L * (a + b);
                if (iso_reference_above(iso_reference_field(v, middle), isovalue, scale) == side)
                    a = middle;
                else
                    b = middle;
            }
            r.hit = true;
            r.t = b;
        }
    }
    return r;
}

#endif
