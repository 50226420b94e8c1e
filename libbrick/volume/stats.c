/* Reading the histogram: bins that were chosen before the range was known. */
#include <brick/stats.h>

#include <math.h>
#include <string.h>

double brick_stats_bin_start(enum brick_type type, uint32_t bin)
{
    switch (type) {
    case BRICK_I8:
        return (double)bin - 128.0;
    case BRICK_I16:
        return (double)bin - 32768.0;
    case BRICK_F32: {
        if (bin > 0xffff)
            return INFINITY;
        uint32_t key = bin << 16, bits = key & 0x80000000u ? key ^ 0x80000000u : ~key;
        float v;
        memcpy(&v, &bits, sizeof v);
        return (double)v;
    }
    default:
        return (double)bin;
    }
}

double brick_stats_percentile(const struct brick_stats *stats, enum brick_type type, double q)
{
    if (stats->count == 0)
        return 0.0;
    double want = q * (double)stats->count, below = 0.0;
    for (uint32_t i = 0; i < stats->bins; i++) {
        double n = (double)stats->histogram[i];
        if (n > 0.0 && below + n >= want) {
            double a = brick_stats_bin_start(type, stats->first_bin + i);
            if (brick_type_is_integer(type))
                return a;
            double b = brick_stats_bin_start(type, stats->first_bin + i + 1);
            a = fmax(a, stats->min);
            b = fmin(b, stats->max);
            return a + (b - a) * (want - below) / n;
        }
        below += n;
    }
    return stats->max;
}
