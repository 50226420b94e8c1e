/* The emission integral over a piece, without a step size.
 *
 * Extinction is a cubic, so the optical depth D is a quartic, integrated exactly. Of the colour w(x), light
 * included, the part w0 that does not vary leaves w0 (1 - exp(-D)); the rest, the integral of
 * (w - w0) sigma exp(-depth), is done by adaptive Gauss-Kronrod quadrature (7 and 15 points). The rules'
 * difference, far above the error of the better one, is held below tolerance times the drop in transmittance
 * over the interval; the drops along a ray sum to at most one, so the errors sum to at most the tolerance.
 *
 * Colour that is emitted independently of extinction has no such part: all of the integral of w exp(-depth)
 * is done by quadrature, and the tolerance is shared out by length.
 *
 * No rule may step over what it cannot see. Intervals are halved to a depth of at most MAX_DEPTH before they
 * are sampled, for the layer where the light is absorbed; and until the normal varies by no more than half of
 * its length, for the place where it turns round: on such an interval the facing ratio is analytic with room
 * to spare. Around a normal of zero that never holds; there halving ends when what is left is NEGLIGIBLE.
 *
 * Near such a zero the facing ratio carries the rounding of the polynomials that it is the quotient of. No
 * halving makes the rules differ by less than that, so that much is allowed beside the tolerance. */
#include "emission.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

#define MAX_DEPTH    2.0
#define MAX_HALVINGS 64
#define TINY_ERROR   1e-25 /* error of one interval that is never worth another halving */
#define NEGLIGIBLE   1e-6  /* part of the tolerance that an interval around a zero normal may be wrong by */
#define ROUNDINGS    32.0  /* of a normal's terms in a facing ratio, anywhere in a steady interval; twice */
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

struct vr_light vr_light_part(const struct vr_light *light, double a, double b)
{
    struct vr_light part = *light;
    for (int i = 0; i < 3; i++)
        part.normal[i] = vr_cubic_part(&light->normal[i], a, b);
    part.facing = vr_cubic_part(&light->facing, a, b);
    return part;
}

/* The cosine between normal and view, 0 where there is no normal. */
static double facing_ratio(const struct vr_light *light, double s)
{
    double n[3], largest = 0.0;
    for (int i = 0; i < 3; i++) {
        n[i] = vr_cubic_eval(&light->normal[i], s);
        largest = fmax(largest, fabs(n[i]));
    }
    if (!(largest > 0.0))
        return 0.0;
    double x = n[0] / largest, y = n[1] / largest, z = n[2] / largest;
    return fmin(fabs(vr_cubic_eval(&light->facing, s)) / largest / sqrt(x * x + y * y + z * z), 1.0);
}

void vr_light_shade(const struct vr_light *light, double s, const double rgb[3], double shaded[3])
{
    double facing = facing_ratio(light, s);
    double highlight = facing > 0.0 ? light->specular * pow(facing, light->shininess) : 0.0;
    for (int c = 0; c < 3; c++)
        shaded[c] = rgb[c] * (light->ambient + light->diffuse * facing) + highlight;
}

static bool is_constant(const struct vr_cubic *f)
{
    return f->c[1] == 0.0 && f->c[2] == 0.0 && f->c[3] == 0.0;
}

static bool is_zero(const struct vr_cubic *f)
{
    return f->c[0] == 0.0 && is_constant(f);
}

/* A piece made ready: its depth, and the part of its colour that does not vary. */
struct integrand {
    const struct vr_piece *piece;
    bool lit; /* and there is a normal */
    double ambient, still[3];
};

static double depth_at(const struct vr_piece *p, double x)
{
    const double *c = p->sigma.c;
    return x * (c[0] + x * (c[1] / 2.0 + x * (c[2] / 3.0 + x * (c[3] / 4.0))));
}

static void evaluate(const struct integrand *f, double x, double y[3])
{
    const struct vr_cubic *colour = f->piece->rgb;
    double sigma = f->piece->glow > 0.0 ? f->piece->glow : vr_cubic_eval(&f->piece->sigma, x);
    double weight = sigma * exp(-depth_at(f->piece, x));
    if (f->lit) {
        double rgb[3] = {vr_cubic_eval(&colour[0], x), vr_cubic_eval(&colour[1], x),
                         vr_cubic_eval(&colour[2], x)};
        vr_light_shade(f->piece->light, x, rgb, y);
        for (int c = 0; c < 3; c++)
            y[c] = (y[c] - f->still[c]) * weight;
    } else {
        for (int c = 0; c < 3; c++) {
            const double *k = colour[c].c;
            double varying = f->ambient * x * (k[1] + x * (k[2] + x * k[3]));
            y[c] = (f->piece->glow > 0.0 ? varying + f->ambient * k[0] : varying) * weight;
        }
    }
}

/* Over [a,b]. Returns the largest channel's difference of the two rules. */
static double gauss_kronrod(const struct integrand *f, double a, double b, double value[3])
{
    double middle = 0.5 * (a + b), half = 0.5 * (b - a), y[3], z[3], coarse[3], error = 0.0;
    evaluate(f, middle, y);
    for (int c = 0; c < 3; c++) {
        value[c] = kronrod[0] * y[c];
        coarse[c] = gauss[0] * y[c];
    }
    for (int i = 1; i < 8; i++) {
        evaluate(f, middle - half * node[i], y);
        evaluate(f, middle + half * node[i], z);
        for (int c = 0; c < 3; c++) {
            value[c] += kronrod[i] * (y[c] + z[c]);
            if (i % 2 == 0)
                coarse[c] += gauss[i / 2] * (y[c] + z[c]);
        }
    }
    for (int c = 0; c < 3; c++) {
        error = fmax(error, fabs(half * (value[c] - coarse[c])));
        value[c] *= half;
    }
    return error;
}

/* Does the normal keep within half its length of what it is in the middle of [a,b]? noise: how much of the
 * shaded colour may be rounding there. */
static bool normal_is_steady(const struct vr_light *light, double a, double b, double *noise)
{
    double middle = 0.5 * (a + b), h = 0.5 * (b - a), length = 0.0, change = 0.0, terms = 0.0;
    for (int i = 0; i < 3; i++) {
        const double *c = light->normal[i].c;
        double most = h * (fabs(c[1] + middle * (2.0 * c[2] + middle * 3.0 * c[3])) +
                           h * (fabs(c[2] + 3.0 * middle * c[3]) + h * fabs(c[3])));
        length = hypot(length, vr_cubic_eval(&light->normal[i], middle));
        change = hypot(change, most);
        terms += fabs(c[0]) + fabs(c[1]) + fabs(c[2]) + fabs(c[3]);
    }
    *noise = ROUNDINGS * DBL_EPSILON * (light->diffuse + light->specular * light->shininess) * terms / length;
    return change <= 0.5 * length;
}

/* The varying part's integral over the piece. share: the piece's of the ray's length. */
static void integrate(const struct integrand *f, double share, double tolerance, uint64_t *evaluations,
                      double total[3])
{
    double ends[MAX_HALVINGS + 1]; /* of the intervals still to do, nearest last */
    int left = 1;
    double a = 0.0;
    ends[0] = 1.0;
    while (left > 0) {
        double b = ends[left - 1], start = depth_at(f->piece, a), depth = depth_at(f->piece, b) - start;
        if (start > OPAQUE_DEPTH)
            break;
        double drop = exp(-start) * fabs(expm1(-depth));
        if (f->piece->glow > 0.0)
            drop = share * (b - a);
        bool can_halve = left <= MAX_HALVINGS && b - a > 0x1p-60;
        double noise = 0.0;
        bool fit = depth <= MAX_DEPTH && (!f->lit || drop <= NEGLIGIBLE * tolerance ||
                                          normal_is_steady(f->piece->light, a, b, &noise));
        if (fit || !can_halve) {
            double value[3], error = gauss_kronrod(f, a, b, value);
            *evaluations += 15;
            if (error <= drop * (tolerance + noise) || error <= TINY_ERROR || !can_halve ||
                (f->lit && drop <= NEGLIGIBLE * tolerance)) {
                for (int c = 0; c < 3; c++)
                    total[c] += value[c];
                a = b;
                left--;
                continue;
            }
        }
        ends[left++] = 0.5 * (a + b);
    }
}

void vr_ray_add_piece(struct vr_ray_integral *ray, const struct vr_piece *piece, double tolerance)
{
    const struct vr_light *light = piece->light;
    struct integrand f = {.piece = piece, .ambient = light ? light->ambient : 1.0};
    double depth = fmax(depth_at(piece, 1.0), 0.0); /* below zero by rounding only */
    double transmittance = exp(-ray->depth), drop = -expm1(-depth), varying[3] = {0.0};
    bool varies = false;
    for (int i = 0; i < 3; i++) {
        f.lit = f.lit || (light && !is_zero(&light->normal[i]));
        f.still[i] = piece->glow > 0.0 ? 0.0 : f.ambient * piece->rgb[i].c[0];
        varies = varies || !is_constant(&piece->rgb[i]);
    }
    if (f.lit || varies || piece->glow > 0.0)
        integrate(&f, piece->length_mm / ray->length_mm, tolerance, &ray->evaluations, varying);
    for (int c = 0; c < 3; c++)
        ray->rgb[c] += transmittance * (f.still[c] * drop + varying[c]);
    ray->depth += depth;
}
