/* Statistics of level 0, gathered brick by brick, independent of the order in which threads saw the bricks:
 * integer counts add up in any order, and moments of f32 are merged in brick order. */
#ifndef BRICK_BUILD_TALLY_H
#define BRICK_BUILD_TALLY_H

#include <brick/grid.h>
#include <brick/stats.h>

#include "kernels.h"

/* Count, mean and sum of squared deviations of a brick's finite voxels. */
struct tally_moments {
    uint64_t count;
    double mean, m2;
};

#define TALLY_BINS 65536u

struct tally {
    uint64_t *bins; /* TALLY_BINS */
    uint32_t *fast; /* 4 x TALLY_BINS, not yet in bins: see tally.c */
    uint64_t pending;
};

/* Bytes of one tally. */
size_t tally_bytes(void);

int tally_init(struct tally *tally, struct brick_error *err);
void tally_finish(struct tally *tally);

/* Count a brick's core. `voxels` is the padded brick, `macrocells` its ranges, which must be right. Returns
 * the number of voxels that are not finite. */
uint32_t tally_brick(struct tally *tally, const struct kernels *kernels, const struct brick_grid *grid,
                     const struct brick_place *place, const void *voxels, const void *macrocells,
                     struct tally_moments *moments);
/* a = a and b together (Chan, Golub, LeVeque 1979: stable for any mean). */
void tally_merge_moments(struct tally_moments *a, const struct tally_moments *b);
/* Move the counts of n histograms to the first one's bins. */
void tally_gather(struct tally *tally, unsigned n);
/* The same, and derive the statistics. min, max: of level 0 in stored values.
 * stats->histogram points into tally[0]. */
void tally_result(struct tally *tally, unsigned n, enum brick_type type, uint64_t voxels, double min,
                  double max, const struct tally_moments *moments, struct brick_stats *stats);

#endif
