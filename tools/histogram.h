/* The value distribution of level 0 in physical values, for people: few equal parts instead of a file's bins.
 */
#ifndef TOOLS_HISTOGRAM_H
#define TOOLS_HISTOGRAM_H

#include <brick/volume.h>

#define HISTOGRAM_PARTS_MAX 256

struct histogram {
    uint32_t parts;                    /* 0: no voxel is finite */
    double low, width;                 /* part i: from low + i * width, physical */
    double count[HISTOGRAM_PARTS_MAX]; /* finite voxels; fractions where a bin of f32 lies in two parts */
};

/* At most parts_max parts over the volume's range. With integers each part but the last holds equally many of
 * the values, so that no comb appears that the data do not have. */
void histogram_init(struct histogram *histogram, const struct brick_volume *volume, uint32_t parts_max);

/* share[i]: of the finite voxels at or above value[i]; n ascending physical values. Right for integers, for
 * f32 to half a bin's width. */
void histogram_shares_above(const struct brick_volume *volume, const double *value, double *share,
                            uint32_t n);

#endif
