/* One brick from a window: padded voxels, macrocell ranges, index entry, statistics, compressed payload. */
#ifndef BRICK_BUILD_ENCODE_H
#define BRICK_BUILD_ENCODE_H

#include <brick/build.h>

#include "costs.h"
#include "tally.h"
#include "window.h"

/* Scratch memory of one worker. */
struct encoder {
    const struct kernels *kernels;
    unsigned char *payload;      /* voxels and macrocell ranges before compression */
    unsigned char *lo, *hi;      /* (edge+1)^3 voxels of the level-0 ranges; levels above 0 only */
    unsigned char *folds;        /* for ranges.c */
    unsigned char *bins;         /* 3 (edge+1)^3, for the occupancy mask */
    double tolerance;            /* of a lossy codec, in stored values; the caller's to set */
    struct brick_scratch stored; /* a kept brick before decoding */
};

/* What comes out for one brick. `bytes` of `payload` are used; 0 for a constant brick. */
struct encoded {
    uint64_t id, ready;   /* the brick, and what drain.c keeps here */
    bool level0, written; /* written: the brick is in the file already */
    struct brick_entry entry;
    unsigned char *payload; /* brick_codec_bound of the largest payload */
    size_t bytes;
    struct tally_moments moments;
};

size_t encoder_bytes(const struct brick_grid *grid);
int encoder_init(struct encoder *encoder, const struct kernels *kernels, const struct brick_grid *grid,
                 struct brick_error *err);
void encoder_finish(struct encoder *encoder);

/* tally: the worker's histogram, used at level 0. Fills everything in `out` but what is drain.c's. */
int encode_brick(struct encoder *encoder, const struct brick_grid *grid, const struct window *window,
                 uint64_t id, enum brick_codec codec, int codec_level, struct tally *tally,
                 struct encoded *out, struct costs *costs, struct brick_error *err);

/* Ranges of a brick whose padded voxels are in memory: also what checking a file recomputes. lo and hi hold
 * the (core+1)^3 level-0 ranges, or are NULL at level 0. Fills macrocells (min,max pairs) and entry's min,
 * max, mask. */
void encode_ranges(const struct brick_grid *grid, const struct brick_place *place, const void *voxels,
                   const void *lo, const void *hi, void *macrocells, struct encoder *scratch,
                   struct brick_entry *entry);

#endif
