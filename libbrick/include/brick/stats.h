/* Statistics of a volume's level 0, in stored values. NaN and Inf are counted and otherwise left out.
 *
 * The histogram has one bin for every value of a type of 8 or 16 bits. For f32 a bin is the upper 16 bits of
 * the value's sortable key (key = bits ^ (sign ? 0xffffffff : 0x80000000)): 2^-7 relative width, known before
 * the range is. Only bins from the first to the last that is not zero are kept. */
#ifndef BRICK_STATS_H
#define BRICK_STATS_H

#include <stdint.h>

#include <brick/type.h>

#ifdef __cplusplus
extern "C" {
#endif

struct brick_stats {
    uint64_t count;            /* finite voxels */
    uint64_t nonfinite;        /* NaN and Inf */
    double min, max;           /* +inf, -inf when count is 0 */
    double mean, variance;     /* population variance; 0 when count is 0 */
    uint32_t first_bin, bins;  /* bins may be 0 */
    const uint64_t *histogram; /* bins counts, owned by the volume or builder */
};

/* Lowest stored value in a bin of the histogram; bin + 1 gives the bin's end. */
double brick_stats_bin_start(enum brick_type type, uint32_t bin);
/* Stored value below which a share q in [0,1] of the finite voxels lies (linear inside f32 bins). */
double brick_stats_percentile(const struct brick_stats *stats, enum brick_type type, double q);

#ifdef __cplusplus
}
#endif
#endif
