/* The trilinear field along a straight segment inside one cell: a cubic in the segment's parameter s in
 * [0,1]. */
#ifndef RENDERER_EXACT_CUBIC_H
#define RENDERER_EXACT_CUBIC_H

/* f(s) = c[0] + c[1] s + c[2] s^2 + c[3] s^3 */
struct vr_cubic {
    double c[4];
};

/* corners: values at the cell's corners, x fastest. enter, leave: ends of the segment in cell coordinates,
 * [0,1] but for rounding. Equal corners give an exactly constant cubic. */
struct vr_cubic vr_cubic_in_cell(const double corners[8], const double enter[3], const double leave[3]);
double vr_cubic_eval(const struct vr_cubic *f, double s);
/* The part from a to b, with its own parameter in [0,1]. */
struct vr_cubic vr_cubic_part(const struct vr_cubic *f, double a, double b);
/* Where the derivative changes sign, strictly inside (0,1), ascending. Returns how many, 0 to 2. */
int vr_cubic_extrema(const struct vr_cubic *f, double s[2]);
/* The s in [a,b] where f is v; f is monotone there and v lies between f(a) and f(b). To rounding of s and f.
 */
double vr_cubic_solve(const struct vr_cubic *f, double v, double a, double b);

#endif
