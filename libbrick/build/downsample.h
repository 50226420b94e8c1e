/* From one level's slices to the next level's slice. */
#ifndef BRICK_BUILD_DOWNSAMPLE_H
#define BRICK_BUILD_DOWNSAMPLE_H

#include "kernels.h"
#include "window.h"

/* Compute voxels [x, x + n) of row y of slice z of `coarse` (voxels, min, max) from `fine`, which holds the
 * voxels below them. halved: which axes. nearest: take voxel 2i instead of the mean. */
void downsample_row(const struct kernels *kernels, const struct window *fine, const struct window *coarse,
                    const bool halved[3], enum brick_type type, bool nearest, uint64_t x, uint64_t n,
                    uint64_t y, uint64_t z);

#endif
