/* Ranges of a brick and of its macrocells, over every cell: over every value that interpolation can give. */
#ifndef BRICK_BUILD_RANGES_H
#define BRICK_BUILD_RANGES_H

#include <brick/volume.h>

#include "kernels.h"

/* Bytes of scratch for one brick. */
size_t ranges_scratch_bytes(const struct brick_grid *grid);
/* lo, hi: ranges of the voxels, element (x,y,z) of the core (and one beyond it) at (z sy + y) sx + x; at
 * level 0 both are the voxels. sx, sy at most edge + 2 border. Fills macrocells (min,max pairs), entry->min
 * and max. */
void ranges_of_brick(const struct kernels *kernels, const struct brick_grid *grid,
                     const struct brick_place *place, const void *lo, const void *hi, size_t sx, size_t sy,
                     void *macrocells, void *scratch, struct brick_entry *entry);

#endif
