/* Cardano's closed form as Schwarze gives it (Cubic and quartic roots, Graphics Gems, 1990) and Parker et al.
 * 1998 use it (appendix A): the test's peer, with their two changes, the lower degrees apart and a zero of
 * 1e-30. It knows roots, not sides. */
#ifndef TESTS_ACCURACY_SCHWARZE_H
#define TESTS_ACCURACY_SCHWARZE_H

#include <math.h>
#include <stdbool.h>

static bool schwarze_zero(double x)
{
    return x > -1e-30 && x < 1e-30;
}

/* Real roots of c[0] + c[1] x + c[2] x^2 + c[3] x^3, in no order. */
static int schwarze_roots(const double c[4], double x[3])
{
    if (schwarze_zero(c[3])) {
        if (schwarze_zero(c[2])) {
            if (schwarze_zero(c[1]))
                return 0;
            x[0] = -c[0] / c[1];
            return 1;
        }
        double p = c[1] / (2.0 * c[2]), d = p * p - c[0] / c[2];
        if (!schwarze_zero(d) && d < 0.0)
            return 0;
        x[0] = sqrt(fmax(d, 0.0)) - p;
        x[1] = -sqrt(fmax(d, 0.0)) - p;
        return 2;
    }
    double a = c[2] / c[3], b = c[1] / c[3], e = c[0] / c[3];
    double p = (b - a * a / 3.0) / 3.0, q = (2.0 / 27.0 * a * a * a - a * b / 3.0 + e) / 2.0;
    double d = q * q + p * p * p;
    int n;
    if (schwarze_zero(d)) {
        double u = cbrt(-q);
        x[0] = 2.0 * u;
        x[1] = -u;
        n = schwarze_zero(q) ? 1 : 2;
    } else if (d < 0.0) {
        double phi = acos(-q / sqrt(-p * p * p)) / 3.0, t = 2.0 * sqrt(-p);
        x[0] = t * cos(phi);
        x[1] = -t * cos(phi + M_PI / 3.0);
        x[2] = -t * cos(phi - M_PI / 3.0);
        n = 3;
    } else {
        x[0] = cbrt(sqrt(d) - q) - cbrt(sqrt(d) + q);
        n = 1;
    }
    for (int i = 0; i < n; i++)
        x[i] -= a / 3.0;
    return n;
}

/* The smallest root in [0,1]. */
static bool schwarze_hit(const double c[4], double v, double *s)
{
    const double shifted[4] = {c[0] - v, c[1], c[2], c[3]};
    double roots[3];
    int n = schwarze_roots(shifted, roots);
    *s = INFINITY;
    for (int i = 0; i < n; i++)
        if (roots[i] >= 0.0 && roots[i] <= 1.0)
            *s = fmin(*s, roots[i]);
    return *s <= 1.0;
}

#endif
