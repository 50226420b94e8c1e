/* The ray integral, without a step size.
 *
 * A segment is cut where the cubic field f turns and where it crosses a knot of the transfer function. On
 * each piece extinction sigma and colour are linear in f, hence cubics, and the optical depth is a quartic,
 * integrated exactly. With c(s) = c(0) + k (f(s) - f(0)) the emission of a piece is
 *
 *     T (c(0) (1 - exp(-D)) + k I),   I = integral of (f - f(0)) sigma exp(-depth),
 *
 * one scalar integral for all channels, zero for a constant colour. I is done by adaptive Gauss-Kronrod
 * quadrature (7 and 15 points). The rules' difference, far above the error of the better one, is held below
 * tolerance times the drop in transmittance over the interval; the drops along a ray sum to at most one, so
 * the errors sum to at most the tolerance. Intervals are halved to a depth of at most MAX_DEPTH before they
 * are sampled, so that no rule can step over the layer where the light is absorbed. */
#include "ray.h"

#include <math.h>

#define MAX_DEPTH    2.0
#define MAX_HALVINGS 64
#define NEGLIGIBLE   1e-25 /* error of one interval that is never worth another halving */
#define OPAQUE_DEPTH 60.0  /* exp(-60) < 1e-26: nothing shows through */

/* Gauss-Kronrod abscissae in [0,1) from the middle outwards; every other one is a Gauss point. */
static const double node[8] = {0.0,
                               0.207784955007898467600689403773245,
                               0.405845151377397166906606412076961,
                               0.586087235467691130294144691658,
                               0.741531185599394439863864773280788,
                               0.864864423359769072789712788640926,
                               0.949107912342758524526189684047851,
                               0.991455371120812639206854697526329};
static const double kronrod[8] = {0.209482141084727828012999174891714, 0.204432940075298892414161999234649,
                                  0.190350578064785409913256402421014, 0.169004726639267902826583426598550,
                                  0.140653259715525918745189590510238, 0.104790010322250183839876322541518,
                                  0.063092092629978553290700663189204, 0.022935322010529224963732008058970};
static const double gauss[4] = {0.417959183673469387755102040816327, 0.381830050505118944950369775488975,
                                0.279705391489276667901467771423780, 0.129484966168869693270611432679082};

/* A piece: field, extinction and depth as polynomials of its own parameter x in [0,1]. */
struct piece {
    double rise[3];  /* f(x) - f(0) = x (rise[0] + rise[1] x + rise[2] x^2) */
    double sigma[4]; /* times the piece's length */
};

static double depth_at(const struct piece *p, double x)
{
    return x * (p->sigma[0] + x * (p->sigma[1] / 2.0 + x * (p->sigma[2] / 3.0 + x * (p->sigma[3] / 4.0))));
}

static double integrand(const struct piece *p, double x)
{
    double rise = x * (p->rise[0] + x * (p->rise[1] + x * p->rise[2]));
    double sigma = p->sigma[0] + x * (p->sigma[1] + x * (p->sigma[2] + x * p->sigma[3]));
    return rise * sigma * exp(-depth_at(p, x));
}

/* Over [a,b]; *error is the difference of the two rules. */
static double gauss_kronrod(const struct piece *p, double a, double b, double *error)
{
    double middle = 0.5 * (a + b), half = 0.5 * (b - a);
    double y = integrand(p, middle);
    double fine = kronrod[0] * y, coarse = gauss[0] * y;
    for (int i = 1; i < 8; i++) {
        y = integrand(p, middle - half * node[i]) + integrand(p, middle + half * node[i]);
        fine += kronrod[i] * y;
        if (i % 2 == 0)
            coarse += gauss[i / 2] * y;
    }
    *error = fabs(half * (fine - coarse));
    return half * fine;
}

/* I of the piece. weight: what it is multiplied by at most, times 1 / tolerance. */
static double integrate(const struct piece *p, double weight, uint64_t *evaluations)
{
    double ends[MAX_HALVINGS + 1]; /* of the intervals still to do, nearest last */
    int left = 1;
    double a = 0.0, total = 0.0;
    ends[0] = 1.0;
    while (left > 0) {
        double b = ends[left - 1], start = depth_at(p, a), depth = depth_at(p, b) - start;
        if (start > OPAQUE_DEPTH)
            break;
        bool can_halve = left <= MAX_HALVINGS && b - a > 0x1p-60;
        if (!(depth > MAX_DEPTH && can_halve)) {
            double error, value = gauss_kronrod(p, a, b, &error);
            double drop = exp(-start) * fabs(expm1(-depth));
            *evaluations += 15;
            if (error * weight <= drop || error <= NEGLIGIBLE || !can_halve) {
                total += value;
                a = b;
                left--;
                continue;
            }
        }
        ends[left++] = 0.5 * (a + b);
    }
    return total;
}

/* The part of f between a and b, where it stays between knots segment - 1 and segment. */
static void add_piece(struct vr_ray_integral *ray, const struct brick_transfer *transfer,
                      const struct vr_cubic *f, double a, double b, size_t segment, double length_mm,
                      double tolerance)
{
    const struct brick_transfer_knot *k0 = &transfer->knots[segment ? segment - 1 : 0];
    const struct brick_transfer_knot *k1 = segment && segment < transfer->count ? k0 + 1 : k0;
    if (!(b > a) || (k0->sigma == 0.0 && k1->sigma == 0.0))
        return;
    struct vr_cubic part = vr_cubic_part(f, a, b);
    double h = length_mm * (b - a), per_value = k0 == k1 ? 0.0 : 1.0 / (k1->value - k0->value);
    double from_knot = k0 == k1 ? 0.0 : part.c[0] - k0->value;
    double sigma_slope = (k1->sigma - k0->sigma) * per_value;
    struct piece p = {{part.c[1], part.c[2], part.c[3]},
                      {h * fmax(k0->sigma + from_knot * sigma_slope, 0.0)}};
    for (int i = 1; i < 4; i++)
        p.sigma[i] = h * sigma_slope * part.c[i];

    const double colour[2][3] = {{k0->r, k0->g, k0->b}, {k1->r, k1->g, k1->b}};
    double slope[3], steepest = 0.0;
    for (int c = 0; c < 3; c++) {
        slope[c] = (colour[1][c] - colour[0][c]) * per_value;
        steepest = fmax(steepest, fabs(slope[c]));
    }
    double depth = fmax(depth_at(&p, 1.0), 0.0); /* below zero by rounding only */
    double transmittance = exp(-ray->depth), drop = -expm1(-depth);
    double varying = steepest > 0.0 ? integrate(&p, steepest / tolerance, &ray->evaluations) : 0.0;
    for (int c = 0; c < 3; c++)
        ray->rgb[c] += transmittance * ((colour[0][c] + from_knot * slope[c]) * drop + slope[c] * varying);
    ray->depth += depth;
}

/* Knots with values below v, or at most v. */
static size_t count_knots(const struct brick_transfer *transfer, double v, bool or_equal)
{
    size_t lo = 0, hi = transfer->count;
    while (lo < hi) {
        size_t mid = lo + (hi - lo) / 2;
        double value = transfer->knots[mid].value;
        if (value < v || (or_equal && value == v))
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo;
}

/* f is monotone between a and b: cross the knots between its end values one after the other. */
static void add_monotone(struct vr_ray_integral *ray, const struct brick_transfer *transfer,
                         const struct vr_cubic *f, double a, double b, double length_mm, double tolerance)
{
    const struct brick_transfer_knot *knots = transfer->knots;
    double from = vr_cubic_eval(f, a), to = vr_cubic_eval(f, b);
    bool rising = from <= to; /* a constant takes the right side of a jump */
    size_t segment = count_knots(transfer, from, rising);
    for (;;) {
        size_t knot = rising ? segment : segment - 1; /* the next one to cross; wraps below the first */
        if (knot >= transfer->count || (rising ? knots[knot].value >= to : knots[knot].value <= to))
            break;
        double at = vr_cubic_solve(f, knots[knot].value, a, b);
        add_piece(ray, transfer, f, a, at, segment, length_mm, tolerance);
        a = at;
        segment = count_knots(transfer, knots[knot].value, rising);
    }
    add_piece(ray, transfer, f, a, b, segment, length_mm, tolerance);
}

void vr_ray_add(struct vr_ray_integral *ray, const struct brick_transfer *transfer, const struct vr_cubic *f,
                double length_mm, double tolerance)
{
    double cuts[4] = {0.0};
    int n = vr_cubic_extrema(f, cuts + 1);
    cuts[n + 1] = 1.0;
    for (int i = 0; i <= n; i++)
        add_monotone(ray, transfer, f, cuts[i], cuts[i + 1], length_mm, tolerance);
}
