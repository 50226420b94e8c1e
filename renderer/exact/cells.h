/* Cells of a .brick file, read through the host brick cache. */
#ifndef RENDERER_EXACT_CELLS_H
#define RENDERER_EXACT_CELLS_H

#include <brick/cache.h>
#include <brick/transfer.h>
#include <brick/volume.h>

#include "march.h"

/* One thread's view. Holds at most one brick pinned. */
struct vr_brick_cells {
    struct vr_cells cells;
    const struct brick_grid *grid;
    struct brick_cache *cache;
    const struct brick_transfer *transfer;
    const uint8_t *states; /* enum brick_state of the level's bricks */
    uint32_t level;
    int64_t first[3], end[3]; /* cells that the current brick owns; empty before the first */
    struct brick_place place;
    uint64_t id;
    const void *data; /* NULL: nothing pinned, the current brick is transparent */
};

void vr_brick_cells_init(struct vr_brick_cells *cells, const struct brick_volume *volume,
                         struct brick_cache *cache, const struct brick_transfer *transfer,
                         const uint8_t *states, uint32_t level);
/* Unpins. */
void vr_brick_cells_finish(struct vr_brick_cells *cells);

#endif
