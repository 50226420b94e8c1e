/* Cubics along a ray: turning points, roots and sides. */
#include "cubic.h"

#include <float.h>
#include <math.h>

struct vr_cubic vr_cubic_part(const struct vr_cubic *f, double a, double b)
{
    double w = b - a;
    return (struct vr_cubic){{vr_cubic_eval(f, a), w * (f->c[1] + a * (2.0 * f->c[2] + a * 3.0 * f->c[3])),
                              w * w * (f->c[2] + 3.0 * a * f->c[3]), w * w * w * f->c[3]}};
}

/* A number as the unevaluated sum of two doubles, |lo| at most half a unit in hi's last place. */
struct twofold {
    double hi, lo;
};

static struct twofold two_sum(double a, double b)
{
    double sum = a + b, part = sum - a;
    return (struct twofold){sum, (a - (sum - part)) + (b - part)};
}

static struct twofold two_product(double a, double b)
{
    double product = a * b;
    return (struct twofold){product, fma(a, b, -product)};
}

static struct twofold twofold_add(struct twofold a, struct twofold b)
{
    struct twofold sum = two_sum(a.hi, b.hi);
    return two_sum(sum.hi, sum.lo + (a.lo + b.lo));
}

static struct twofold twofold_multiply(struct twofold a, struct twofold b)
{
    struct twofold product = two_product(a.hi, b.hi);
    return two_sum(product.hi, product.lo + (a.hi * b.lo + a.lo * b.hi));
}

/* c[0] + c[1] s + ... + c[n] s^n */
static struct twofold twofold_eval(const struct twofold *c, int n, struct twofold s)
{
    struct twofold y = c[n];
    for (int i = n - 1; i >= 0; i--)
        y = twofold_add(twofold_multiply(y, s), c[i]);
    return y;
}

int vr_cubic_extrema(const struct vr_cubic *f, double s[2])
{
    /* f' = p + 2 q s + r s^2; the roots as p/z and z/r lose no digits to cancellation, nor does the
     * discriminant q^2 - p r. */
    double p = f->c[1], q = f->c[2], r = 3.0 * f->c[3];
    /* f' lies between its Bernstein coefficients. All on one side, by more than they are rounded: no root. */
    double b1 = p + q, b2 = b1 + q + r, margin = 1e-14 * (fabs(p) + fabs(q) + fabs(r));
    if ((p > margin && b1 > margin && b2 > margin) || (p < -margin && b1 < -margin && b2 < -margin))
        return 0;
    struct twofold pr = twofold_multiply(two_product(-3.0, p), (struct twofold){f->c[3], 0.0});
    double discriminant = twofold_add(two_product(q, q), pr).hi;
    int n = 0;
    if (!(discriminant > 0.0))
        return 0;
    double z = -(q + copysign(sqrt(discriminant), q));
    double roots[2] = {p / z, z / r};
    if (roots[0] > roots[1]) {
        double swap = roots[0];
        roots[0] = roots[1];
        roots[1] = swap;
    }
    for (int i = 0; i < 2; i++)
        if (roots[i] > 0.0 && roots[i] < 1.0) /* false for the infinite root of a lower degree */
            s[n++] = roots[i];
    return n;
}

/* Halley's method, kept inside a bracket that every step narrows; where it fails to halve the residual (a
 * double root at the bracket's end) the bracket is halved instead. A step of h leaves an error of |k| h^3,
 * k = (f''/2f')^2 - f'''/6f': once that is below rounding there is no next one. */
double vr_cubic_solve(const struct vr_cubic *f, double v, double a, double b)
{
    const struct vr_cubic g = {{f->c[0] - v, f->c[1], f->c[2], f->c[3]}};
    double at_a = vr_cubic_eval(&g, a), at_b = vr_cubic_eval(&g, b);
    if (at_a == 0.0 || (at_a > 0.0) == (at_b > 0.0)) /* same sign: v is an end's value but for rounding */
        return fabs(at_a) <= fabs(at_b) ? a : b;
    double sign = at_a < 0.0 ? 1.0 : -1.0;
    double s = a + (b - a) * (at_a / (at_a - at_b)), last = INFINITY;
    for (int i = 0; i < 200; i++) {
        double y = vr_cubic_eval(&g, s);
        if (y == 0.0)
            break;
        if (sign * y < 0.0)
            a = s;
        else
            b = s;
        double slope = g.c[1] + s * (2.0 * g.c[2] + s * 3.0 * g.c[3]), bend = g.c[2] + 3.0 * g.c[3] * s;
        double step = y * slope / (slope * slope - y * bend), next = s - step;
        bool good = next > a && next < b && !(fabs(y) > 0.5 * last);
        if (!good)
            next = a + 0.5 * (b - a);
        last = fabs(y);
        if (fabs(next - s) <= DBL_EPSILON * s || b - a <= DBL_EPSILON * b ||
            (good && fabs(step * step * step) * (bend * bend + fabs(slope * g.c[3])) <=
                         0.25 * DBL_EPSILON * s * slope * slope))
            return next;
        s = next;
    }
    return s;
}

int vr_cubic_sign_changes(const struct vr_cubic *f, double s[3])
{
    double cuts[4] = {0.0};
    int turns = vr_cubic_extrema(f, cuts + 1), n = 0;
    cuts[turns + 1] = 1.0;
    for (int i = 0; i <= turns; i++) {
        double from = vr_cubic_eval(f, cuts[i]), to = vr_cubic_eval(f, cuts[i + 1]);
        if ((from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0))
            s[n++] = vr_cubic_solve(f, 0.0, cuts[i], cuts[i + 1]);
        else if (to == 0.0 && i < turns)
            s[n++] = cuts[i + 1];
    }
    return n;
}

static bool is_above(const struct vr_cubic *f, struct twofold s)
{
    double sum = fabs(f->c[0]) + fabs(f->c[1]) + fabs(f->c[2]) + fabs(f->c[3]);
    const struct twofold c[4] = {{f->c[0], 0.0}, {f->c[1], 0.0}, {f->c[2], 0.0}, {f->c[3], 0.0}};
    return twofold_eval(c, 3, s).hi >= -0x1p-98 * sum;
}

/* A turning point found in double, corrected by a step of Newton's method towards f' = 0. */
static struct twofold turning_point(const struct vr_cubic *f, double s)
{
    const struct twofold c[3] = {{f->c[1], 0.0}, {2.0 * f->c[2], 0.0}, two_product(3.0, f->c[3])};
    double slope = twofold_eval(c, 2, (struct twofold){s, 0.0}).hi;
    double correction = slope / (2.0 * f->c[2] + 6.0 * f->c[3] * s);
    return fabs(correction) < 0x1p-40 ? two_sum(s, -correction) : (struct twofold){s, 0.0};
}

bool vr_cubic_first_crossing(const struct vr_cubic *f, bool above_start, bool above_end, double *s)
{
    double cuts[4] = {0.0};
    int turns = vr_cubic_extrema(f, cuts + 1);
    cuts[turns + 1] = 1.0;
    for (int i = 1; i <= turns + 1; i++) {
        double a = cuts[i - 1], b = cuts[i];
        if ((i > turns ? above_end : is_above(f, turning_point(f, b))) == above_start)
            continue;
        while (b - a > 0x1p-60) {
            double middle = a + 0.5 * (b - a);
            if (!(middle > a && middle < b))
                break;
            if (is_above(f, (struct twofold){middle, 0.0}) == above_start)
                a = middle;
            else
                b = middle;
        }
        *s = b;
        return true;
    }
    return false;
}
