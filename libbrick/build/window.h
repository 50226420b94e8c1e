/* A box of one level's voxels in memory: what bricks and the next level are made from. In x and y it is the
 * box [lo, lo + size); along z a ring of `capacity` slices. */
#ifndef BRICK_BUILD_WINDOW_H
#define BRICK_BUILD_WINDOW_H

#include <brick/grid.h>

struct window {
    const struct brick_level *level;
    uint64_t lo[2], size[2];
    uint64_t capacity; /* slices: slice z is in slot z % capacity */
    size_t width;      /* bytes of a voxel */
    /* Voxels, and the range of level 0 below each voxel. At level 0 all three are the same memory. */
    unsigned char *voxels, *min, *max;
};

static inline size_t window_slice_bytes(const struct window *w)
{
    return (size_t)(w->size[0] * w->size[1]) * w->width;
}

/* Where voxel (x, y, z) is in each of the arrays. */
static inline size_t window_at(const struct window *w, uint64_t x, uint64_t y, uint64_t z)
{
    return (size_t)(z % w->capacity) * window_slice_bytes(w) +
           (size_t)((y - w->lo[1]) * w->size[0] + x - w->lo[0]) * w->width;
}

#endif
