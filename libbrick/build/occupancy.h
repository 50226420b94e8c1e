/* The occupancy mask: which of 64 equal bins of a brick's range its cells touch. */
#ifndef BRICK_BUILD_OCCUPANCY_H
#define BRICK_BUILD_OCCUPANCY_H

#include <stddef.h>
#include <stdint.h>

#include <brick/type.h>

/* lo, hi: ranges of the (core+1)^3 voxels that the brick's cells use, element (x,y,z) at (z sy + y) sx + x.
 * min, max: of all of them (min > max: none is finite). bins: 3 (core+1)^3 bytes of scratch. */
uint64_t occupancy_mask(enum brick_type type, const void *lo, const void *hi, size_t sx, size_t sy,
                        const uint32_t core[3], float min, float max, unsigned char *bins);

#endif
