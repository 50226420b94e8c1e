/* One pinned brick a thread. Invariant: it is let go before the next is asked for, so a cache of one brick a
 * thread is enough. */
#include "pins.h"

#include <string.h>

void vr_iso_pin_release(struct vr_iso_pin *pin)
{
    if (pin->held)
        brick_cache_unpin(pin->cache, pin->id);
    pin->held = false;
}

void vr_iso_block_of_brick(const struct brick_grid *grid, uint64_t id, const void *data,
                           struct vr_iso_block *block)
{
    struct brick_place place;
    brick_grid_place(grid, id, &place);
    const struct brick_level *level = &grid->level[place.level];
    memset(block, 0, sizeof *block);
    block->voxels = data;
    block->ranges = (const char *)data + brick_place_voxel_bytes(grid, &place);
    while (1u << block->macro_shift < grid->macrocell)
        block->macro_shift++;
    block->part_shift = VR_ISO_PART_SHIFT;
    while ((uint32_t)VR_ISO_PART << block->part_row < grid->edge)
        block->part_row++;
    for (int i = 0; i < 3; i++) {
        block->lo[i] = place.lo[i];
        block->first[i] = (int32_t)grid->border;
        block->end[i] = (int32_t)(grid->border + place.core[i]);
        block->edge_low[i] = place.at[i] == 0;
        block->edge_high[i] = place.at[i] + 1 == level->bricks[i];
        block->macros[i] = (int32_t)place.macrocells[i];
        block->parts[i] = (int32_t)(place.core[i] + VR_ISO_PART - 1) / VR_ISO_PART;
    }
    block->row = place.stored[0];
    block->slice = (size_t)place.stored[0] * place.stored[1];
}

int vr_iso_pin_get(struct vr_iso_pin *pin, uint64_t id, const struct vr_iso_block **block,
                   struct brick_error *err)
{
    if (pin->tiled) {
        *block = &pin->tiled[id - pin->tiled_first];
        return BRICK_OK;
    }
    if (!pin->held || pin->id != id) {
        const void *data;
        vr_iso_pin_release(pin);
        int code = brick_cache_pin(pin->cache, id, &data, err);
        if (code)
            return code;
        pin->held = true;
        pin->id = id;
        vr_iso_block_of_brick(pin->grid, id, data, &pin->block);
    }
    *block = &pin->block;
    return BRICK_OK;
}
