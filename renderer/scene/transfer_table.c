/* From knots in physical values to pieces in stored float32 ones.
 *
 * A piece starts at the smallest float that is not below its knot, so a float falls into the piece in which
 * its exact value lies; colours and extinction are evaluated there, not at the knot, so moving the start
 * costs nothing. A piece that no float lies in is left out. */
#include "transfer_table.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>

#define MAX_BINS  4096
#define MIN_BINS  64
#define MAX_KNOTS 131071 /* pieces that 17 halvings search */

/* Floats in their order as integers, and back. */
static float float_at(uint32_t key)
{
    uint32_t bits = key & 0x80000000u ? key ^ 0x80000000u : ~key;
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

static double physical(const struct brick_grid *grid, float f)
{
    return fabs(grid->slope) * (double)f + grid->intercept;
}

float vr_stored_threshold(const struct brick_grid *grid, double value)
{
    uint32_t low = 0x00800000u, high = 0xff800000u; /* keys of -FLT_MAX and +inf */
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (physical(grid, float_at(middle)) >= value)
            high = middle;
        else
            low = middle + 1;
    }
    return float_at(low) + 0.0f; /* -0 + 0 = 0 */
}

static float clamp_float(double v)
{
    return (float)fmin(fmax(v, -FLT_MAX), FLT_MAX);
}

/* One segment of the function from `start` on, between knots a and b; a == b: constant. */
static struct vr_piece piece(const struct brick_grid *grid, const struct brick_transfer_knot *a,
                             const struct brick_transfer_knot *b, float start)
{
    struct vr_piece p = {.start = start, .origin = start, .end = FLT_MAX};
    const double ca[4] = {a->r, a->g, a->b, a->sigma}, cb[4] = {b->r, b->g, b->b, b->sigma};
    double width = b->value - a->value, s = a == b ? 0.0 : (physical(grid, start) - a->value) / width;
    float *base[4] = {&p.rgb[0], &p.rgb[1], &p.rgb[2], &p.sigma};
    float *slope[4] = {&p.rgb_slope[0], &p.rgb_slope[1], &p.rgb_slope[2], &p.sigma_slope};
    bool flat = true;
    for (int i = 0; i < 4; i++) {
        *base[i] = clamp_float(ca[i] + s * (cb[i] - ca[i]));
        *slope[i] = a == b ? 0.0f : clamp_float((cb[i] - ca[i]) / width * fabs(grid->slope));
        flat = flat && *slope[i] == 0.0f;
    }
    /* Where nothing changes the distance from the origin must not overflow. */
    if (flat)
        p.origin = 0.0f;
    return p;
}

static float bin_of(const struct vr_transfer_table *t, float v)
{
    float offset = v - t->bin_origin, bin = offset * t->bin_scale;
    return fminf(fmaxf(bin, 0.0f), (float)(t->bin_count - 1));
}

/* A bin's first candidate is the last piece that starts in an earlier bin: it starts below every value of
 * this one, as float subtraction and multiplication keep order. Its last is the last that starts in it. */
static void fill_bins(struct vr_transfer_table *t)
{
    static const uint32_t steps[] = {1, 3, 17}; /* few, since shaders are compiled for them */
    uint32_t next = 1, most = 1, n = 0;         /* next: the first piece not yet passed */
    for (uint32_t b = 0; b < t->bin_count; b++) {
        t->bins[b].first = next - 1;
        while (next < t->count && (uint32_t)bin_of(t, t->pieces[next].start) <= b)
            next++;
        t->bins[b].last = next - 1;
        if (next - t->bins[b].first > most)
            most = next - t->bins[b].first;
    }
    while ((UINT64_C(1) << steps[n]) < most)
        n++;
    t->search_steps = steps[n];
}

/* A piece with a value that is not transparent counts whole. */
static void find_visible(struct vr_transfer_table *t)
{
    t->visible[0] = INFINITY;
    t->visible[1] = -INFINITY;
    for (uint32_t i = 0; i < t->count; i++) {
        if (t->pieces[i].sigma == 0.0f && t->pieces[i].sigma_slope == 0.0f)
            continue;
        if (t->visible[0] > t->visible[1])
            t->visible[0] = i ? t->pieces[i].start : -INFINITY;
        t->visible[1] = i + 1 < t->count ? t->pieces[i].end : INFINITY;
    }
}

int vr_transfer_table_init(struct vr_transfer_table *table, const struct brick_transfer *transfer,
                           const struct brick_grid *grid, struct brick_error *err)
{
    size_t n = transfer->count;
    const struct brick_transfer_knot *k = transfer->knots;
    float *threshold = NULL;
    *table = (struct vr_transfer_table){0};
    if (n == 0 || n > MAX_KNOTS)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "a transfer function of %zu knots", n);
    table->bin_count = MIN_BINS;
    while (table->bin_count < MAX_BINS && table->bin_count < 16 * n)
        table->bin_count *= 2;
    threshold = malloc(n * sizeof *threshold);
    table->pieces = malloc((n + 1) * sizeof *table->pieces);
    table->bins = malloc(table->bin_count * sizeof *table->bins);
    if (!threshold || !table->pieces || !table->bins) {
        free(threshold);
        vr_transfer_table_finish(table);
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a transfer function of %zu knots", n);
    }
    for (size_t i = 0; i < n; i++)
        threshold[i] = vr_stored_threshold(grid, k[i].value);

    table->pieces[table->count++] = piece(grid, &k[0], &k[0], threshold[0]);
    for (size_t i = 0; i < n; i++) {
        float end = i + 1 < n ? threshold[i + 1] : INFINITY;
        if (!(threshold[i] < end))
            continue;
        table->pieces[table->count++] = piece(grid, &k[i], i + 1 < n ? &k[i + 1] : &k[i], threshold[i]);
    }
    for (uint32_t i = 0; i + 1 < table->count; i++)
        table->pieces[i].end = table->pieces[i + 1].start;
    table->bin_origin = clamp_float(threshold[0]);
    table->bin_scale =
        (float)((double)table->bin_count / ((double)clamp_float(threshold[n - 1]) - table->bin_origin));
    if (!isfinite(table->bin_scale) || !(table->bin_scale > 0.0f))
        table->bin_scale = 1.0f;
    fill_bins(table);
    find_visible(table);
    free(threshold);
    return BRICK_OK;
}

void vr_transfer_table_finish(struct vr_transfer_table *table)
{
    free(table->pieces);
    free(table->bins);
    *table = (struct vr_transfer_table){0};
}
