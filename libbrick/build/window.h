/* The slices of one level that bricks and the next level still need: a ring of edge + 2 border slices. */
#ifndef BRICK_BUILD_WINDOW_H
#define BRICK_BUILD_WINDOW_H

#include <brick/grid.h>

struct window {
    const struct brick_level *level;
    size_t slice_bytes;
    uint64_t capacity; /* slices */
    uint64_t filled;   /* slices [0, filled) have arrived; the last `capacity` of them are here */
    uint64_t next_row; /* row of bricks (z) that is emitted next */
    /* Voxels, and the range of level 0 below each voxel. At level 0 all three are the same memory. */
    unsigned char *voxels, *min, *max;
};

static inline size_t window_slot(const struct window *w, uint64_t z)
{
    return (size_t)(z % w->capacity) * w->slice_bytes;
}

#endif
