/* Inner loops that run over every voxel, one table for each instruction set the compiler can vectorise them
 * for. All tables compute the same bits; the plain one is the twin that tests hold the others to. */
#ifndef BRICK_BUILD_KERNELS_H
#define BRICK_BUILD_KERNELS_H

#include <stddef.h>

#include <brick/type.h>

/* Entries without a type in their name are indexed by stored type; pointers are to arrays of it. */
struct kernels {
    const char *name;
    /* lo[i], hi[i] = smallest and largest of a[i + r * stride], b[i + r * stride] over `rows` >= 1 rows; NaN
     * and Inf left out, the type's (largest, smallest) or (+Inf, -Inf) where nothing is left. i < n. */
    void (*fold[BRICK_TYPE_STORED_COUNT])(void *lo, void *hi, const void *a, const void *b, size_t stride,
                                          size_t rows, size_t n);
    /* out[i] = mean of voxels 2i and 2i+1 of four rows, i < n: see downsample.c. */
    void (*mean_pairs[BRICK_TYPE_STORED_COUNT])(void *out, const void *const rows[4], size_t n);
    /* lo[i], hi[i] over elements 2i and 2i+1 of four rows each, as in fold. */
    void (*range_pairs[BRICK_TYPE_STORED_COUNT])(void *lo, void *hi, const void *const a[4],
                                                 const void *const b[4], size_t n);
    /* Voxel i's finite value, or its squared distance from mean, is added to sum[i % 8]. */
    void (*sum_f32)(double sum[8], const float *row, size_t n);
    void (*squares_f32)(double sum[8], const float *row, size_t n, double mean);
};

enum { KERNELS_MAX = 3 };
/* Table i of those this processor can run, best first, the plain one last; NULL beyond it. */
const struct kernels *kernels_table(unsigned i);
const struct kernels *kernels_best(void);
const struct kernels *kernels_plain(void);

#endif
