/* The brick that a thread holds pinned in the host cache. */
#ifndef RENDERER_ISOTRACE_PINS_H
#define RENDERER_ISOTRACE_PINS_H

#include <brick/cache.h>

#include "walk.h"

struct vr_iso_pin {
    const struct brick_grid *grid;
    struct brick_cache *cache;
    bool held;
    uint64_t id;
    struct vr_iso_block block;
    const struct vr_iso_block *tiled; /* instead of the cache: a block for each brick of the level, or NULL */
    uint64_t tiled_first;             /* number of the first of them */
};

/* The brick, valid until the next call. */
int vr_iso_pin_get(struct vr_iso_pin *pin, uint64_t id, const struct vr_iso_block **block,
                   struct brick_error *err);
void vr_iso_pin_release(struct vr_iso_pin *pin);

/* The block of a brick whose payload is at data. */
void vr_iso_block_of_brick(const struct brick_grid *grid, uint64_t id, const void *data,
                           struct vr_iso_block *block);

#endif
