/* Cells of a .brick file, read through the host brick cache. */
#ifndef RENDERER_EXACT_CELLS_H
#define RENDERER_EXACT_CELLS_H

#include <brick/active.h>
#include <brick/cache.h>
#include <brick/transfer.h>
#include <brick/volume.h>

#include "march.h"

/* One thread's view. Holds at most one brick pinned. */
struct vr_brick_cells {
    struct vr_cells cells;
    const struct brick_grid *grid;
    struct brick_cache *cache;
    const struct brick_volume *volume;
    const struct brick_transfer *transfer; /* what a cell must show some of; NULL: all are wanted */
    const uint8_t *states;                 /* enum brick_state of the level's bricks */
    bool sides; /* a brick that is not active stands for its side of the isovalue */
    uint32_t level;
    int64_t first[3], end[3]; /* cells that the current brick owns; empty before the first */
    struct brick_place place;
    uint64_t id;
    const void *data; /* NULL: nothing pinned, the current brick is not active */
    double side;      /* a value on its side; NaN: it has none */
};

/* For query's mode, from the states that brick_active_set gave. */
void vr_brick_cells_init(struct vr_brick_cells *cells, const struct brick_volume *volume,
                         struct brick_cache *cache, const struct brick_active_query *query,
                         const uint8_t *states);
/* Unpins. */
void vr_brick_cells_finish(struct vr_brick_cells *cells);

#endif
