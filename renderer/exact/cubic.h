/* The trilinear field along a straight segment inside one cell: a cubic in the segment's parameter s in
 * [0,1]. */
#ifndef RENDERER_EXACT_CUBIC_H
#define RENDERER_EXACT_CUBIC_H

#include <stdbool.h>

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
/* Where f changes sign (or turns at 0) inside (0,1), ascending. Returns how many, 0 to 3. */
int vr_cubic_sign_changes(const struct vr_cubic *f, double s[3]);

/* The first s in (0,1] at which f lies on the other side of 0 than at 0; above is f >= 0. The sides at the
 * ends are the caller's, who knows those values better than the cubic does: where they differ there always is
 * a crossing. f at turning points is found in twice the precision of double, and is 0 when it is below 2^-98
 * of the coefficients' sum: a surface that is only touched is decided right whenever the coefficients are.
 * The s is the upper end of a bracket of 2^-60 whose ends lie on different sides. */
bool vr_cubic_first_crossing(const struct vr_cubic *f, bool above_start, bool above_end, double *s);

#endif
