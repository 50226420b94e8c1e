/* The trilinear field along a straight segment inside one cell: a cubic in the segment's parameter s in
 * [0,1]. */
#ifndef RENDERER_EXACT_CUBIC_H
#define RENDERER_EXACT_CUBIC_H

#include <stdbool.h>

/* f(s) = c[0] + c[1] s + c[2] s^2 + c[3] s^3 */
struct vr_cubic {
    double c[4];
};

/* From a at 0 to b at 1, both exactly, and in between never outside of them: rounding is monotone, and from
 * the nearer end, chosen without a branch (which it is nobody can predict), it is no more than half the way.
 */
static inline double vr_cubic_lerp(double a, double b, double x)
{
    const double end = x > 0.5 ? b : a, from = x > 0.5 ? x - 1.0 : x;
    return end + from * (b - a);
}

/* corners: values at the cell's corners, x fastest. enter, leave: ends of the segment in cell coordinates,
 * [0,1] but for rounding. Equal corners give an exactly constant cubic.
 *
 * Coefficients are formed relative to the entry point from differences of corner values, one axis at a time,
 * so that they carry errors of rounding of the cell's own values, whatever the cell's place in the volume. */
static inline struct vr_cubic vr_cubic_in_cell(const double corners[8], const double enter[3],
                                               const double leave[3])
{
    const double dx = leave[0] - enter[0], dy = leave[1] - enter[1], dz = leave[2] - enter[2];
    double a[2][4], b[3][2]; /* by power of s, then by what is left of the corners */
    struct vr_cubic f;
    for (int i = 0; i < 4; i++) {
        a[0][i] = vr_cubic_lerp(corners[2 * i], corners[2 * i + 1], enter[0]);
        a[1][i] = dx * (corners[2 * i + 1] - corners[2 * i]);
    }
    for (int i = 0; i < 2; i++) {
        const double *constant = a[0] + 2 * i, *linear = a[1] + 2 * i;
        b[0][i] = vr_cubic_lerp(constant[0], constant[1], enter[1]);
        b[1][i] = vr_cubic_lerp(linear[0], linear[1], enter[1]) + dy * (constant[1] - constant[0]);
        b[2][i] = dy * (linear[1] - linear[0]);
    }
    f.c[0] = vr_cubic_lerp(b[0][0], b[0][1], enter[2]);
    f.c[1] = vr_cubic_lerp(b[1][0], b[1][1], enter[2]) + dz * (b[0][1] - b[0][0]);
    f.c[2] = vr_cubic_lerp(b[2][0], b[2][1], enter[2]) + dz * (b[1][1] - b[1][0]);
    f.c[3] = dz * (b[2][1] - b[2][0]);
    return f;
}

static inline double vr_cubic_eval(const struct vr_cubic *f, double s)
{
    return f->c[0] + s * (f->c[1] + s * (f->c[2] + s * f->c[3]));
}

/* The part from a to b, with its own parameter in [0,1]. */
struct vr_cubic vr_cubic_part(const struct vr_cubic *f, double a, double b);
/* Where the derivative changes sign, strictly inside (0,1), ascending. Returns how many, 0 to 2. */
int vr_cubic_extrema(const struct vr_cubic *f, double s[2]);
/* The s in [a,b] where f is v; f is monotone there and v lies between f(a) and f(b). To rounding of s and f.
 */
double vr_cubic_solve(const struct vr_cubic *f, double v, double a, double b);
/* Where f changes sign (or turns at 0) inside (0,1), ascending. Returns how many, 0 to 3. */
int vr_cubic_sign_changes(const struct vr_cubic *f, double s[3]);

/* The first s in (0,1] at which f lies on the other side of 0 than at 0; above is f >= 0. The sides at the
 * ends are the caller's, who knows those values better than the cubic does: where they differ there always is
 * a crossing. f at turning points is found in twice the precision of double, and is 0 when it is below 2^-98
 * of the coefficients' sum: a surface that is only touched is decided right whenever the coefficients are.
 * The s is the upper end of a bracket of 2^-60 whose ends lie on different sides. */
bool vr_cubic_first_crossing(const struct vr_cubic *f, bool above_start, bool above_end, double *s);

#endif
