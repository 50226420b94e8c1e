/* Bricks that an interrupted conversion has left. Those of level 0 that no checkpoint covers are decoded
 * again rather than encoded: for the statistics and, from a lossless codec, as the voxels from which coarser
 * levels are made. */
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
    uint64_t decoded; /* bricks that were taken */
};

/* Look at all of them: what came after the first damaged one is not kept any more. */
int kept_check(struct kept *kept, struct brick_error *err);
/* How many of a tile's bricks, from its first on. */
uint64_t kept_in_tile(const struct kept *kept, const struct tile *tile);
/* Take a tile's first bricks into the statistics, as tickets of the drain from `ticket` on, and put their
 * cores into a window unless that is NULL. */
int kept_take(struct kept *kept, const struct tile *tile, uint64_t bricks, const struct window *window,
              uint64_t ticket, struct brick_error *err);

#endif
