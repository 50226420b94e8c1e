/* Transfer functions: from control points in opacity to knots in extinction.
 *
 * Between control points A is linear in the value, so extinction tau = -ln(1 - A) is not. Each segment is cut
 * so that tau drawn as a chord stays within 1e-4 in A. With u = 1 - A, linear in the value, a chord in tau is
 * the weighted geometric mean of the ends u0 = a^2, u1 = b^2 where the truth is the arithmetic one, and
 *
 *     (1-s) a^2 + s b^2 - a^(2-2s) b^(2s)  <=  max(s, 1-s) (a - b)^2.
 *
 * Proof for s <= 1/2 (else swap the ends): the claim is 2(1-s) ab <= (1-2s) b^2 + a^(2-2s) b^(2s), and the
 * right side is, by the weighted inequality of means with weights 1-2s and 1, at least (2-2s) times (b^(2-4s)
 * a^(2-2s) b^(2s))^(1/(2-2s)) = ab. So pieces uniform in sqrt(u) of width below 0.01 stay below 1e-4; the
 * little room left covers the clamp of A at 1 - 2^-24.
 *
 * Invariants: values ascend; at most two knots share a value, and then the second holds at it. Extinction is
 * not negative, and nor is colour, so each is zero inside a piece only when it is at both ends. */
#include <brick/transfer.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include <brick/checked.h>

#define PIECE_WIDTH 0.00999 /* in sqrt(1 - A) */
#define MAX_OPACITY (1.0 - 0x1p-24)

static double clamp_opacity(double a)
{
    return a < MAX_OPACITY ? a : MAX_OPACITY;
}

static size_t piece_count(double a0, double a1)
{
    double width = fabs(sqrt(1.0 - clamp_opacity(a0)) - sqrt(1.0 - clamp_opacity(a1)));
    double n = ceil(width / PIECE_WIDTH);
    return n < 1.0 ? 1 : (size_t)n;
}

static int check_spec(const struct brick_transfer_spec *spec, double unit_mm, struct brick_error *err)
{
    if (!spec->points || spec->count == 0 || spec->count > BRICK_TRANSFER_MAX_POINTS)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "transfer function has %zu points; 1 to %d are allowed",
                          spec->count, BRICK_TRANSFER_MAX_POINTS);
    if (!(unit_mm > 0.0) || !isfinite(unit_mm))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "transfer function: unit %g is not a positive length",
                          spec->unit);
    for (size_t i = 0; i < spec->count; i++) {
        const struct brick_transfer_point *p = &spec->points[i];
        const double parts[4] = {p->r, p->g, p->b, p->a};
        if (!isfinite(p->value))
            return brick_fail(err, BRICK_ERR_ARGUMENT, "transfer function point %zu: value is not finite", i);
        for (int c = 0; c < 4; c++)
            if (!(parts[c] >= 0.0 && parts[c] <= 1.0))
                return brick_fail(err, BRICK_ERR_ARGUMENT,
                                  "transfer function point %zu: r, g, b and A must be in [0,1], not %g", i,
                                  parts[c]);
        if (i > 0 && p->value < p[-1].value)
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "transfer function point %zu: value %g is below the one before, %g", i,
                              p->value, p[-1].value);
        if (i > 1 && p->value == p[-2].value)
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "transfer function point %zu: third point at value %g; two make a jump", i,
                              p->value);
    }
    return BRICK_OK;
}

/* Values distinct in the spec may meet when mapped to a narrow range: the outer two of them stay as the jump.
 */
static void push_knot(struct brick_transfer *t, const struct brick_transfer_knot *knot)
{
    if (t->count >= 2 && t->knots[t->count - 2].value == knot->value)
        t->count--;
    t->knots[t->count++] = *knot;
}

static struct brick_transfer_knot knot_at(const struct brick_transfer_point *p, double value, double unit_mm)
{
    return (struct brick_transfer_knot){value, p->r, p->g, p->b, -log1p(-clamp_opacity(p->a)) / unit_mm};
}

/* The cuts strictly between two control points. */
static void push_cuts(struct brick_transfer *t, const struct brick_transfer_point *p0, double v0,
                      const struct brick_transfer_point *p1, double v1, double unit_mm)
{
    size_t n = piece_count(p0->a, p1->a);
    double u0 = 1.0 - clamp_opacity(p0->a), u1 = 1.0 - clamp_opacity(p1->a);
    double x0 = sqrt(u0), x1 = sqrt(u1);
    double last = v0;
    for (size_t i = 1; i < n; i++) {
        double x = x0 + (x1 - x0) * ((double)i / (double)n);
        double s = (u0 - x * x) / (u0 - u1);
        double v = v0 + s * (v1 - v0);
        if (!(v > last && v < v1)) /* a segment a few units in the last place wide */
            continue;
        last = v;
        struct brick_transfer_knot knot = {v, p0->r + s * (p1->r - p0->r), p0->g + s * (p1->g - p0->g),
                                           p0->b + s * (p1->b - p0->b), -2.0 * log(x) / unit_mm};
        push_knot(t, &knot);
    }
}

static void add_support(struct brick_transfer *t, double lo, double hi)
{
    struct brick_interval *last = t->support_count ? &t->support[t->support_count - 1] : NULL;
    if (last && last->hi >= lo)
        last->hi = hi;
    else
        t->support[t->support_count++] = (struct brick_interval){lo, hi};
}

static bool shows(const struct brick_transfer *t, const struct brick_transfer_knot *k)
{
    bool glows = k->r > 0.0 || k->g > 0.0 || k->b > 0.0;
    return k->sigma > 0.0 || (t->emission == BRICK_EMISSION_INDEPENDENT && glows);
}

static void find_support(struct brick_transfer *t)
{
    const struct brick_transfer_knot *k = t->knots;
    if (shows(t, &k[0]))
        add_support(t, -INFINITY, k[0].value);
    for (size_t i = 0; i + 1 < t->count; i++)
        if (k[i].value < k[i + 1].value && (shows(t, &k[i]) || shows(t, &k[i + 1])))
            add_support(t, k[i].value, k[i + 1].value);
    if (shows(t, &k[t->count - 1]))
        add_support(t, k[t->count - 1].value, INFINITY);
}

/* [lo, hi], joined to the interval before when no double lies between them. */
static void add_visible(struct brick_transfer *t, double lo, double hi)
{
    struct brick_interval *last = t->visible_count ? &t->visible[t->visible_count - 1] : NULL;
    if (last && nextafter(last->hi, INFINITY) >= lo)
        last->hi = hi;
    else
        t->visible[t->visible_count++] = (struct brick_interval){lo, hi};
}

/* A piece holds its left end and not its right one, which is the next piece's; inside it something shows
 * nowhere or everywhere. A piece between neighbouring doubles where nothing shows at its left end becomes an
 * interval with lo > hi, which still meets just the ranges that hold both. */
static void find_visible(struct brick_transfer *t)
{
    const struct brick_transfer_knot *k = t->knots;
    if (shows(t, &k[0]))
        add_visible(t, -INFINITY, nextafter(k[0].value, -INFINITY));
    for (size_t i = 0; i + 1 < t->count; i++)
        if (k[i].value < k[i + 1].value && (shows(t, &k[i]) || shows(t, &k[i + 1])))
            add_visible(t, shows(t, &k[i]) ? k[i].value : nextafter(k[i].value, INFINITY),
                        nextafter(k[i + 1].value, -INFINITY));
    if (shows(t, &k[t->count - 1]))
        add_visible(t, k[t->count - 1].value, INFINITY);
}

static bool same_knot(const struct brick_transfer_knot *a, const struct brick_transfer_knot *b)
{
    return a->r == b->r && a->g == b->g && a->b == b->b && a->sigma == b->sigma;
}

int brick_transfer_create(struct brick_transfer **out, const struct brick_transfer_spec *spec,
                          double min_edge_mm, const double range[2], struct brick_error *err)
{
    struct brick_transfer *t = NULL;
    double unit_mm = spec->unit * (spec->unit_of == BRICK_UNIT_VOXEL ? min_edge_mm : 1.0);
    double origin = 0.0, width = 1.0;
    size_t capacity = 0;
    uint64_t knot_bytes, support_bytes;
    int result = check_spec(spec, unit_mm, err);

    *out = NULL;
    if (result)
        return result;
    if (spec->range_values) {
        origin = range[0];
        width = range[1] - range[0];
        if (!isfinite(origin) || !isfinite(width))
            return brick_fail(err, BRICK_ERR_ARGUMENT, "transfer function: the volume's range is not finite");
        if (!(width > 0.0)) /* a constant volume sits at the lower end of a range that is as good as any */
            width = fmax(1.0, fabs(origin));
    }
    for (size_t i = 0; i < spec->count; i++)
        capacity += i == 0 ? 1 : piece_count(spec->points[i - 1].a, spec->points[i].a);
    t = calloc(1, sizeof *t);
    if (!t || !brick_mul_u64(capacity, sizeof *t->knots, &knot_bytes) ||
        !brick_mul_u64(capacity + 1, sizeof *t->support, &support_bytes) ||
        !(t->knots = malloc(knot_bytes)) || !(t->support = malloc(support_bytes)) ||
        !(t->visible = malloc(support_bytes))) {
        result =
            brick_fail(err, BRICK_ERR_MEMORY, "no memory for a transfer function of %zu knots", capacity);
        goto fail;
    }

    for (size_t i = 0; i < spec->count; i++) {
        const struct brick_transfer_point *p = &spec->points[i];
        double value = origin + width * p->value;
        if (i > 0)
            push_cuts(t, p - 1, origin + width * p[-1].value, p, value, unit_mm);
        struct brick_transfer_knot knot = knot_at(p, value, unit_mm);
        push_knot(t, &knot);
        if (!isfinite(knot.sigma) || !isfinite(knot.value - t->knots[0].value)) {
            result = brick_fail(err, BRICK_ERR_ARGUMENT,
                                "transfer function point %zu: value or extinction too large for a double", i);
            goto fail;
        }
    }
    t->unit_mm = unit_mm;
    t->continuous = true;
    for (size_t i = 0; i + 1 < t->count; i++)
        if (t->knots[i].value == t->knots[i + 1].value && !same_knot(&t->knots[i], &t->knots[i + 1]))
            t->continuous = false;
    brick_transfer_set_emission(t, BRICK_EMISSION_SCALED);
    *out = t;
    return BRICK_OK;
fail:
    brick_transfer_destroy(&t);
    return result;
}

void brick_transfer_set_emission(struct brick_transfer *transfer, enum brick_emission emission)
{
    transfer->emission = emission;
    transfer->support_count = transfer->visible_count = 0;
    find_support(transfer);
    find_visible(transfer);
}

void brick_transfer_destroy(struct brick_transfer **transfer)
{
    if (*transfer) {
        free((*transfer)->knots);
        free((*transfer)->support);
        free((*transfer)->visible);
        free(*transfer);
    }
    *transfer = NULL;
}

void brick_transfer_spec_finish(struct brick_transfer_spec *spec)
{
    free(spec->points);
    spec->points = NULL;
    spec->count = 0;
}

/* Number of knots at or below the value. */
static size_t knots_upto(const struct brick_transfer *t, double value)
{
    size_t lo = 0, hi = t->count;
    while (lo < hi) {
        size_t mid = lo + (hi - lo) / 2;
        if (t->knots[mid].value <= value)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo;
}

void brick_transfer_scale(struct brick_transfer *transfer, double factor)
{
    for (size_t i = 0; i < transfer->count; i++)
        transfer->knots[i].sigma *= factor;
}

void brick_transfer_eval(const struct brick_transfer *transfer, double value, double rgb[3], double *sigma)
{
    if (isnan(value)) {
        rgb[0] = rgb[1] = rgb[2] = *sigma = 0.0;
        return;
    }
    size_t n = knots_upto(transfer, value);
    const struct brick_transfer_knot *a = &transfer->knots[n ? n - 1 : 0];
    const struct brick_transfer_knot *b = n && n < transfer->count ? a + 1 : a;
    double s = a == b ? 0.0 : (value - a->value) / (b->value - a->value);
    rgb[0] = a->r + s * (b->r - a->r);
    rgb[1] = a->g + s * (b->g - a->g);
    rgb[2] = a->b + s * (b->b - a->b);
    *sigma = a->sigma + s * (b->sigma - a->sigma);
}

bool brick_transfer_visible(const struct brick_transfer *transfer, double lo, double hi)
{
    size_t first = 0, end = transfer->visible_count;
    while (first < end) {
        size_t mid = first + (end - first) / 2;
        if (transfer->visible[mid].hi < lo)
            first = mid + 1;
        else
            end = mid;
    }
    return lo <= hi && first < transfer->visible_count && transfer->visible[first].lo <= hi;
}
