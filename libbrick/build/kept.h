/* Bricks of level 0 that an interrupted conversion has left in PATH.part. They are decoded again rather than
 * encoded: for the statistics and, from a lossless codec, as the voxels from which coarser levels are made.
 */
#ifndef BRICK_BUILD_KEPT_H
#define BRICK_BUILD_KEPT_H

#include <brick/threads.h>

#include "drain.h"
#include "tile.h"
#include "window.h"

struct kept {
    const struct brick_grid *grid;
    struct brick_writer *writer;
    struct brick_pool *pool;
    struct drain *drain;
    struct encoder *encoders; /* one a thread, as the next two */
    struct tally *tallies;
    struct costs *costs;
    uint64_t bricks; /* [0, bricks) are kept */
};

/* How many of a tile's bricks are kept, from its first on, once each is known to be there: those from a
 * damaged one on are not any more. */
int kept_check(struct kept *kept, const struct tile *tile, uint64_t *bricks, struct brick_error *err);
/* Take a tile's first bricks into the statistics, as tickets of the drain from `ticket` on, and put their
 * cores into a window unless that is NULL. */
int kept_take(struct kept *kept, const struct tile *tile, uint64_t bricks, const struct window *window,
              uint64_t ticket, struct brick_error *err);

#endif
