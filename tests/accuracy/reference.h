/* A slow second opinion on the ray integral, in long double, that shares nothing with renderer/exact: the ray
 * is cut into many short intervals, those over which the transfer function changes piece are halved to
 * 2^-38 of their length, and each is done by three-point Gauss rules, depth and emission alike. It sees a
 * field as a function of t. Lit, the intervals over which the surface turns its other side to the eye are
 * halved as well. */
#ifndef TESTS_ACCURACY_REFERENCE_H
#define TESTS_ACCURACY_REFERENCE_H

#include <math.h>
#include <stddef.h>

#include <brick/transfer.h>

struct reference {
    long double (*field)(void *context, long double t);
    void *context;
    const struct brick_transfer *transfer;
    long double depth, rgb[3];
    /* May be NULL: extinction and colour in place of field and transfer function. */
    long double (*classify)(void *context, long double t, long double rgb[3]);
    /* May be NULL: shades rgb, and returns a number that has the sign of the gradient along the view. */
    long double (*shade)(void *context, long double t, long double rgb[3]);
    long double glow; /* above 0: colour is emitted so many times a unit of t, whatever the extinction */
};

static const long double reference_node[3] = {-0.774596669241483377035853079956L, 0.0L,
                                              0.774596669241483377035853079956L};
static const long double reference_weight[3] = {5.0L / 18.0L, 8.0L / 18.0L, 5.0L / 18.0L};

static size_t reference_segment(const struct brick_transfer *t, long double value)
{
    size_t n = 0, end = t->count;
    while (n < end) {
        size_t middle = (n + end) / 2;
        if ((long double)t->knots[middle].value <= value)
            n = middle + 1;
        else
            end = middle;
    }
    return n;
}

static long double reference_classify(const struct reference *r, long double t, long double rgb[3])
{
    if (r->classify)
        return r->classify(r->context, t, rgb);
    long double value = r->field(r->context, t);
    size_t n = reference_segment(r->transfer, value);
    const struct brick_transfer_knot *a = &r->transfer->knots[n ? n - 1 : 0];
    const struct brick_transfer_knot *b = n && n < r->transfer->count ? a + 1 : a;
    long double s = a == b ? 0.0L : (value - a->value) / ((long double)b->value - a->value);
    rgb[0] = a->r + s * (b->r - (long double)a->r);
    rgb[1] = a->g + s * (b->g - (long double)a->g);
    rgb[2] = a->b + s * (b->b - (long double)a->b);
    return a->sigma + s * (b->sigma - (long double)a->sigma);
}

/* What must not change over an interval that is done in one go. */
static size_t reference_piece(const struct reference *r, long double t)
{
    long double rgb[3] = {0.0L};
    size_t n = r->classify ? 0 : 2 * reference_segment(r->transfer, r->field(r->context, t));
    return n + (r->shade && r->shade(r->context, t, rgb) < 0.0L);
}

static long double reference_depth(const struct reference *r, long double a, long double b)
{
    long double sum = 0.0L, rgb[3];
    for (int i = 0; i < 3; i++)
        sum += reference_weight[i] *
               reference_classify(r, 0.5L * (a + b) + 0.5L * (b - a) * reference_node[i], rgb);
    return (b - a) * sum;
}

static void reference_short(struct reference *r, long double a, long double b)
{
    for (int i = 0; i < 3; i++) {
        long double t = 0.5L * (a + b) + 0.5L * (b - a) * reference_node[i], rgb[3];
        long double sigma = reference_classify(r, t, rgb);
        if (r->shade)
            r->shade(r->context, t, rgb);
        long double seen = (b - a) * reference_weight[i] * (r->glow > 0.0L ? r->glow : sigma) *
                           expl(-r->depth - reference_depth(r, a, t));
        for (int c = 0; c < 3; c++)
            r->rgb[c] += rgb[c] * seen;
    }
    r->depth += reference_depth(r, a, b);
}

static void reference_split(struct reference *r, long double a, size_t at_a, long double b, size_t at_b,
                            int level)
{
    long double middle = 0.5L * (a + b);
    if (at_a == at_b || level == 38 || !(middle > a && middle < b)) {
        reference_short(r, a, b);
        return;
    }
    size_t at_middle = reference_piece(r, middle);
    reference_split(r, a, at_a, middle, at_middle, level + 1);
    reference_split(r, middle, at_middle, b, at_b, level + 1);
}

/* Go on from a to b, where the field is smooth, in n intervals. */
static inline void reference_add(struct reference *r, long double a, long double b, int n)
{
    size_t before = reference_piece(r, a);
    long double from = a;
    for (int i = 1; i <= n; i++) {
        long double to = i == n ? b : a + (b - a) * i / n;
        size_t after = reference_piece(r, to);
        reference_split(r, from, before, to, after, 0);
        from = to;
        before = after;
    }
}

/* Random numbers: the same on every machine. */
static inline double reference_random(unsigned long long *state)
{
    *state = *state * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(*state >> 11) * 0x1p-53;
}

#endif
