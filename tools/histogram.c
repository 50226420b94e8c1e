/* Why: a file's histogram has one bin a value (or 2^-7 of a value, f32); a chart wants a few equal parts.
 * Invariants: the counts add up to the finite voxels; physical values ascend whatever the slope's sign. */
#include "histogram.h"

#include <math.h>

/* Bins of integers are single values, the first and the last of them the smallest and largest there are. */
static void count_integers(struct histogram *histogram, const struct brick_volume *volume, uint32_t parts_max)
{
    const struct brick_stats *stats = brick_volume_stats(volume);
    double slope = brick_volume_grid(volume)->slope;
    uint32_t each = (stats->bins + parts_max - 1) / parts_max;
    histogram->parts = (stats->bins + each - 1) / each;
    histogram->width = fabs(slope) * each;
    for (uint32_t i = 0; i < stats->bins; i++)
        histogram->count[(slope < 0 ? stats->bins - 1 - i : i) / each] += (double)stats->histogram[i];
}

/* Physical ends of a bin of the statistics, cut to the range. */
static void bin_span(const struct brick_volume *volume, uint32_t i, double *a, double *b)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_stats *stats = brick_volume_stats(volume);
    double from = brick_stats_bin_start(grid->type, stats->first_bin + i);
    double to = brick_type_is_integer(grid->type)
                    ? from
                    : brick_stats_bin_start(grid->type, stats->first_bin + i + 1);
    from = grid->slope * fmin(fmax(from, stats->min), stats->max) + grid->intercept;
    to = grid->slope * fmin(fmax(to, stats->min), stats->max) + grid->intercept;
    *a = fmin(from, to);
    *b = fmax(from, to);
}

static uint32_t part_of(const struct histogram *histogram, double value)
{
    double place = (value - histogram->low) / histogram->width;
    return place >= histogram->parts ? histogram->parts - 1 : place > 0 ? (uint32_t)place : 0;
}

static void count_reals(struct histogram *histogram, const struct brick_volume *volume, uint32_t parts_max,
                        const double range[2])
{
    const struct brick_stats *stats = brick_volume_stats(volume);
    histogram->parts = range[1] > range[0] ? parts_max : 1;
    histogram->width = (range[1] - range[0]) / histogram->parts;
    for (uint32_t i = 0; i < stats->bins; i++) {
        double a, b, n = (double)stats->histogram[i], left = n;
        bin_span(volume, i, &a, &b);
        uint32_t first = histogram->parts > 1 ? part_of(histogram, a) : 0;
        uint32_t last = histogram->parts > 1 ? part_of(histogram, b) : 0;
        for (uint32_t p = first; p < last; p++) {
            double end = histogram->low + (p + 1) * histogram->width;
            double start = fmax(a, end - histogram->width);
            double part = fmin(left, n * fmax(0, end - start) / (b - a));
            histogram->count[p] += part;
            left -= part;
        }
        histogram->count[last] += left;
    }
}

void histogram_init(struct histogram *histogram, const struct brick_volume *volume, uint32_t parts_max)
{
    double range[2];
    *histogram = (struct histogram){0};
    if (!brick_volume_stats(volume)->count)
        return;
    brick_volume_value_range(volume, range);
    histogram->low = range[0];
    if (brick_type_is_integer(brick_volume_grid(volume)->type))
        count_integers(histogram, volume, parts_max);
    else
        count_reals(histogram, volume, parts_max, range);
}

void histogram_shares_above(const struct brick_volume *volume, const double *value, double *share, uint32_t n)
{
    const struct brick_stats *stats = brick_volume_stats(volume);
    for (uint32_t i = 0; i < n; i++)
        share[i] = 0;
    for (uint32_t i = 0; i < stats->bins; i++) {
        double a, b;
        bin_span(volume, i, &a, &b);
        double middle = a + (b - a) / 2;
        uint32_t lo = 0, hi = n; /* the last value at or below the middle is lo - 1 in the end */
        while (lo < hi) {
            uint32_t half = (lo + hi) / 2;
            if (value[half] <= middle)
                lo = half + 1;
            else
                hi = half;
        }
        if (lo)
            share[lo - 1] += (double)stats->histogram[i];
    }
    for (uint32_t i = n; i-- > 1;)
        share[i - 1] += share[i];
    for (uint32_t i = 0; i < n && stats->count; i++)
        share[i] /= (double)stats->count;
}
