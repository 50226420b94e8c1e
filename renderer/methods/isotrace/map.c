/* Bits of parts. Invariant: a brick's bits are written before its state says so; two threads that look at
 * the same brick write the same bits. What is known only ever spares work: no picture depends on it. */
#include "map.h"

#include <stdlib.h>

#include <brick/checked.h>

void vr_iso_map_finish(struct vr_iso_map *map)
{
    free(map->state);
    free(map->bits);
    *map = (struct vr_iso_map){0};
}

static bool is_for(const struct vr_iso_map *map, const struct vr_iso_frame *frame)
{
    if (!map->ready || map->level != frame->level || map->skip != frame->skip ||
        map->surfaces != frame->surfaces)
        return false;
    for (uint32_t k = 0; k < frame->surfaces; k++)
        if (map->isovalue[k] != frame->surface[k].isovalue)
            return false;
    return true;
}

static int take_memory(struct vr_iso_map *map, const struct vr_iso_frame *frame, struct brick_error *err)
{
    const struct brick_level *level = frame->level;
    const uint64_t across = frame->grid->edge / VR_ISO_PART, words = (across * across * across + 63) / 64;
    uint64_t bytes;
    if (map->level == level)
        return BRICK_OK;
    vr_iso_map_finish(map);
    if (brick_mul3_u64(level->bricks[0], level->bricks[1], level->bricks[2], &map->bricks) &&
        brick_mul3_u64(map->bricks, words, sizeof *map->bits, &bytes) && bytes <= SIZE_MAX) {
        map->words = (size_t)words;
        while (1u << map->edge_shift < frame->grid->edge)
            map->edge_shift++;
        map->state = calloc((size_t)map->bricks, sizeof *map->state);
        map->bits = calloc((size_t)(map->bricks * words), sizeof *map->bits);
    }
    if (!map->state || !map->bits) {
        vr_iso_map_finish(map);
        return brick_fail(err, BRICK_ERR_MEMORY, "isotrace: no memory for the states of the level's bricks");
    }
    map->level = level;
    return BRICK_OK;
}

int vr_iso_map_make(struct vr_iso_map *map, const struct brick_volume *volume,
                    const struct vr_iso_frame *frame, struct brick_error *err)
{
    if (is_for(map, frame))
        return BRICK_OK;
    int code = take_memory(map, frame, err);
    if (code)
        return code;
    map->active = 0;
    for (uint64_t b = 0; b < map->bricks; b++) {
        const struct brick_entry *e = brick_volume_entry(volume, frame->level->first_brick + b);
        bool active = !frame->skip;
        for (uint32_t k = 0; k < frame->surfaces; k++)
            active |= e->min < frame->surface[k].split && e->max >= frame->surface[k].split;
        atomic_init(&map->state[b], active ? VR_ISO_ACTIVE : VR_ISO_EMPTY);
        map->active += active;
    }
    map->skip = frame->skip;
    map->surfaces = frame->surfaces;
    for (uint32_t k = 0; k < frame->surfaces; k++)
        map->isovalue[k] = frame->surface[k].isovalue;
    map->ready = true;
    return BRICK_OK;
}

const atomic_uint_least64_t *vr_iso_map_look(const struct vr_iso_map *map, const struct vr_iso_frame *frame,
                                             uint64_t brick, const struct vr_iso_block *block)
{
    atomic_uint_least64_t *bits = map->bits + brick * map->words;
    uint64_t all = 0;
    if (vr_iso_map_state(map, brick) != VR_ISO_ACTIVE)
        return bits;
    for (size_t w = 0; w < map->words; w++) {
        uint64_t word = frame->kernel->parts(frame, block, w);
        atomic_store_explicit(&bits[w], word, memory_order_relaxed);
        all |= word;
    }
    atomic_store_explicit(&map->state[brick], all ? VR_ISO_KNOWN : VR_ISO_EMPTY, memory_order_release);
    return bits;
}
