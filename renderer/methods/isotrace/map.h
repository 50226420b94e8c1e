/* Where a surface may pass: in which bricks of a level, by the index, and in which of their parts, known of
 * every brick that has been in memory. Kept from frame to frame for as long as level and surfaces stay. One
 * bit a part and one byte a brick; threads share it. */
#ifndef RENDERER_ISOTRACE_MAP_H
#define RENDERER_ISOTRACE_MAP_H

#include <stdatomic.h>

#include "walk.h"

enum vr_iso_state {
    VR_ISO_EMPTY,  /* no surface passes */
    VR_ISO_ACTIVE, /* one may */
    VR_ISO_KNOWN   /* one may, where the bits say */
};

struct vr_iso_map {
    uint64_t bricks, active; /* of the level; by the index alone, so the same whatever has been in memory */
    uint32_t edge_shift;     /* log2 of a brick's edge */
    size_t words;            /* of 64 bits a brick */
    atomic_uchar *state;     /* enum vr_iso_state, one a brick */
    atomic_uint_least64_t *bits; /* x fastest, as many on each axis as a whole brick has parts */
    bool ready;
    const struct brick_level *level; /* what it was made for: */
    bool skip;
    uint32_t surfaces;
    double isovalue[VR_ISO_MAX_SURFACES];
};

/* Make it for the frame's level and surfaces, unless it is that already. */
int vr_iso_map_make(struct vr_iso_map *map, const struct brick_volume *volume,
                    const struct vr_iso_frame *frame, struct brick_error *err);
void vr_iso_map_finish(struct vr_iso_map *map);

static inline enum vr_iso_state vr_iso_map_state(const struct vr_iso_map *map, uint64_t brick)
{
    return (enum vr_iso_state)atomic_load_explicit(&map->state[brick], memory_order_acquire);
}

static inline const atomic_uint_least64_t *vr_iso_map_bits(const struct vr_iso_map *map, uint64_t brick)
{
    return map->bits + brick * map->words;
}

/* The bits of an active brick that is in memory, found now if they are not known. */
const atomic_uint_least64_t *vr_iso_map_look(const struct vr_iso_map *map, const struct vr_iso_frame *frame,
                                             uint64_t brick, const struct vr_iso_block *block);

#endif
