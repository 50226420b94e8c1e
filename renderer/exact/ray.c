/* The ray integral over a segment of a cell.
 *
 * A segment is cut where the field f turns, where it crosses a knot of the transfer function, and, lit, where
 * the surface's facing changes sign, at which the shading has a kink. On each piece extinction and colour are
 * linear in f, hence cubics. A field of pre-classified voxels has them from the start. */
#include "ray.h"

#include <math.h>
#include <stddef.h>

static struct vr_cubic scaled(const struct vr_cubic *f, double factor)
{
    return (struct vr_cubic){{f->c[0] * factor, f->c[1] * factor, f->c[2] * factor, f->c[3] * factor}};
}

/* A segment and what is constant along it. */
struct segment {
    struct vr_ray_integral *ray;
    const struct brick_transfer *transfer;
    const struct vr_cubic *f;
    const struct vr_light *light;
    double length_mm, tolerance;
};

/* The part of f between a and b, where it stays between knots n - 1 and n. */
static void add_piece(const struct segment *s, double a, double b, size_t n)
{
    const struct brick_transfer_knot *k0 = &s->transfer->knots[n ? n - 1 : 0];
    const struct brick_transfer_knot *k1 = n && n < s->transfer->count ? k0 + 1 : k0;
    bool glows = s->transfer->emission == BRICK_EMISSION_INDEPENDENT;
    if (!(b > a) || (!glows && k0->sigma == 0.0 && k1->sigma == 0.0))
        return;
    const double colour[2][3] = {{k0->r, k0->g, k0->b}, {k1->r, k1->g, k1->b}};
    struct vr_cubic part = vr_cubic_part(s->f, a, b);
    double per_value = k0 == k1 ? 0.0 : 1.0 / (k1->value - k0->value);
    double from_knot = k0 == k1 ? 0.0 : part.c[0] - k0->value;
    double sigma_slope = (k1->sigma - k0->sigma) * per_value, h = s->length_mm * (b - a);
    struct vr_light light;
    struct vr_piece piece = {.length_mm = h, .glow = glows ? h / s->transfer->unit_mm : 0.0};

    piece.sigma = scaled(&part, h * sigma_slope);
    piece.sigma.c[0] = h * fmax(k0->sigma + from_knot * sigma_slope, 0.0);
    for (int c = 0; c < 3; c++) {
        double slope = (colour[1][c] - colour[0][c]) * per_value;
        piece.rgb[c] = scaled(&part, slope);
        piece.rgb[c].c[0] = colour[0][c] + from_knot * slope;
    }
    if (s->light) {
        light = vr_light_part(s->light, a, b);
        piece.light = &light;
    }
    vr_ray_add_piece(s->ray, &piece, s->tolerance);
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
static void add_monotone(const struct segment *s, double a, double b)
{
    const struct brick_transfer_knot *knots = s->transfer->knots;
    double from = vr_cubic_eval(s->f, a), to = vr_cubic_eval(s->f, b);
    bool rising = from <= to; /* a constant takes the right side of a jump */
    size_t n = count_knots(s->transfer, from, rising);
    for (;;) {
        size_t knot = rising ? n : n - 1; /* the next one to cross; wraps below the first */
        if (knot >= s->transfer->count || (rising ? knots[knot].value >= to : knots[knot].value <= to))
            break;
        double at = vr_cubic_solve(s->f, knots[knot].value, a, b);
        add_piece(s, a, at, n);
        a = at;
        n = count_knots(s->transfer, knots[knot].value, rising);
    }
    add_piece(s, a, b, n);
}

/* Ascending by insertion: there are at most five. */
static void insert(double *cuts, int *count, double cut)
{
    int i = (*count)++;
    for (; i > 0 && cuts[i - 1] > cut; i--)
        cuts[i] = cuts[i - 1];
    cuts[i] = cut;
}

/* cuts gets 0, where the light's facing changes sign, and room for two more and 1. Returns how many. */
static int cut_at_kinks(const struct vr_light *light, double cuts[7])
{
    cuts[0] = 0.0;
    return 1 + (light ? vr_cubic_sign_changes(&light->facing, cuts + 1) : 0);
}

void vr_ray_add(struct vr_ray_integral *ray, const struct brick_transfer *transfer, const struct vr_cubic *f,
                const struct vr_light *light, double length_mm, double tolerance)
{
    const struct segment segment = {ray, transfer, f, light, length_mm, tolerance};
    double cuts[7], turns[2];
    int count = cut_at_kinks(light, cuts), n = vr_cubic_extrema(f, turns);
    for (int i = 0; i < n; i++)
        insert(cuts, &count, turns[i]);
    cuts[count] = 1.0;
    for (int i = 0; i < count; i++)
        add_monotone(&segment, cuts[i], cuts[i + 1]);
}

void vr_ray_add_classified(struct vr_ray_integral *ray, const struct brick_transfer *transfer,
                           const struct vr_cubic *sigma, const struct vr_cubic rgb[3],
                           const struct vr_light *light, double length_mm, double tolerance)
{
    double cuts[7];
    int count = cut_at_kinks(light, cuts);
    cuts[count] = 1.0;
    for (int i = 0; i < count; i++) {
        double a = cuts[i], b = cuts[i + 1];
        struct vr_cubic part = vr_cubic_part(sigma, a, b);
        struct vr_piece piece = {.sigma = scaled(&part, length_mm * (b - a)),
                                 .length_mm = length_mm * (b - a)};
        struct vr_light lit;
        if (transfer->emission == BRICK_EMISSION_INDEPENDENT)
            piece.glow = piece.length_mm / transfer->unit_mm;
        if (light) {
            lit = vr_light_part(light, a, b);
            piece.light = &lit;
        }
        for (int c = 0; c < 3; c++)
            piece.rgb[c] = vr_cubic_part(&rgb[c], a, b);
        vr_ray_add_piece(ray, &piece, tolerance);
    }
}
