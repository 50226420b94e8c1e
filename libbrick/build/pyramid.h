/* All levels at once: level 0's tiles come in, bricks of every level go out, and what a tile becomes in the
 * next level is kept, in memory or in a spool, until a row of bricks is complete there. */
#ifndef BRICK_BUILD_PYRAMID_H
#define BRICK_BUILD_PYRAMID_H

#include "costs.h"
#include "kernels.h"
#include "plan.h"
#include "spool.h"

/* Encode brick `id` from a window that holds it. Tickets count the bricks in the order in which the pyramid
 * comes to them. Called by the workers of the pool. */
typedef int pyramid_brick(void *context, const struct window *window, uint64_t id, uint64_t ticket,
                          unsigned worker, struct brick_error *err);

struct pyramid {
    const struct brick_grid *grid;
    const struct plan *plan;
    struct brick_pool *pool;
    const struct kernels *kernels;
    bool nearest;
    pyramid_brick *brick;
    void *context;
    struct costs *costs; /* one a worker */

    struct window window[BRICK_MAX_LEVELS]; /* levels held in memory; level 0's is the feed's */
    struct spool spool[BRICK_MAX_LEVELS];   /* levels that are not */
    struct window in, out;                  /* tiles from and to spools */
    uint64_t filled[BRICK_MAX_LEVELS];      /* slices [0, filled) have been made */
    uint64_t next_row[BRICK_MAX_LEVELS];    /* row of bricks that is encoded next */
    uint64_t first_new[BRICK_MAX_LEVELS];   /* of each level, the first brick that must be encoded */
    uint64_t tickets;
    struct brick_build_cost spool_cost;
};

/* The caller has filled the members from grid to costs. path: where spools go, beside it. */
int pyramid_init(struct pyramid *pyramid, const char *path, struct brick_error *err);
void pyramid_finish(struct pyramid *pyramid);
/* Go on as if rows [0, rows) of level 0 were done; what is in the stores is left to the caller. */
void pyramid_seek(struct pyramid *pyramid, uint64_t rows);
/* Of each level l > 0 the slices [lo[l], hi[l]) that its store must hold now, and that doing level 0's rows
 * from `from` on once more would not make. */
void pyramid_carry(const struct pyramid *pyramid, uint64_t from, uint64_t lo[], uint64_t hi[]);
/* Encode a tile of level 0 and make the next level's voxels of it. Tiles come row by row, in order. */
int pyramid_tile(struct pyramid *pyramid, const struct tile *tile, const struct window *window,
                 struct brick_error *err);
/* All tiles of a level's row (of level 0: the caller's) are done: encode what is complete now in coarser
 * levels. */
int pyramid_row_done(struct pyramid *pyramid, uint32_t level, uint64_t row, struct brick_error *err);

#endif
