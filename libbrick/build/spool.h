/* One level's slices in a scratch file, for levels that do not fit into memory: a ring, like a window's. */
#ifndef BRICK_BUILD_SPOOL_H
#define BRICK_BUILD_SPOOL_H

#include <brick/io.h>
#include <brick/threads.h>

#include "tile.h"
#include "window.h"

struct spool {
    struct brick_io io;
    const struct brick_level *level;
    uint64_t capacity; /* slices */
    size_t width;      /* bytes of a voxel */
};

/* The file is made beside path. */
int spool_init(struct spool *spool, const char *path, const struct brick_level *level, uint64_t capacity,
               size_t width, struct brick_error *err);
void spool_finish(struct spool *spool);
/* Where a voxel of slice z is in the file; array: 0 voxels, 1 min, 2 max. A slice of one is contiguous. */
uint64_t spool_at(const struct spool *spool, uint64_t array, uint64_t x, uint64_t y, uint64_t z);
/* Copy a box of voxels, min and max from or to a window that holds it, slices shared out among the pool. */
int spool_write(const struct spool *spool, struct brick_pool *pool, const struct window *window,
                const struct box *box, struct brick_error *err);
int spool_read(const struct spool *spool, struct brick_pool *pool, const struct window *window,
               const struct box *box, struct brick_error *err);

#endif
