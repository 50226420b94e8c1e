/* The stream of slices through all levels: level 0's slices come in, rows of bricks of every level go out. */
#ifndef BRICK_BUILD_PYRAMID_H
#define BRICK_BUILD_PYRAMID_H

#include <brick/threads.h>

#include "window.h"

/* Emit the bricks of row bz of a level, whose slices are all in the window (or beyond the volume's end). */
typedef int pyramid_emit(void *context, uint32_t level, uint64_t bz, const struct window *window,
                         struct brick_error *err);

struct pyramid {
    const struct brick_grid *grid;
    struct brick_pool *pool;
    bool nearest;
    pyramid_emit *emit;
    void *context;
    struct window window[BRICK_MAX_LEVELS];
};

/* Bytes of all windows; UINT64_MAX on overflow. */
uint64_t pyramid_bytes(const struct brick_grid *grid);
int pyramid_init(struct pyramid *pyramid, const struct brick_grid *grid, struct brick_pool *pool,
                 bool nearest, pyramid_emit *emit, void *context, struct brick_error *err);
void pyramid_finish(struct pyramid *pyramid);

/* Room for the next slices of level 0: at most *count, contiguous, fewer where the ring wraps or a row
 * completes. */
void *pyramid_room(struct pyramid *pyramid, uint64_t *count);
/* `count` slices have been written there: emit what is complete, and feed the coarser levels. */
int pyramid_push(struct pyramid *pyramid, uint64_t count, struct brick_error *err);

#endif
