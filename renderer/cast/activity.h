/* Where something shows: in which bricks of a level, by the index, and in which macrocells of those that have
 * been in memory. Threads share it. Three bytes a brick, and a bit a macrocell. */
#ifndef RENDERER_CAST_ACTIVITY_H
#define RENDERER_CAST_ACTIVITY_H

#include <stdatomic.h>

#include "classified.h"

struct vr_cast_activity {
    const struct brick_volume *volume;
    struct brick_active_query query;
    struct vr_classified classified; /* what is known is of this, */
    uint64_t number;                 /* of its number; 0: of nothing */
    bool skip;
    uint64_t bricks, active; /* of the level */
    uint8_t *state;          /* enum brick_state */
    uint8_t *away; /* in bricks, along the axis it is farthest on, to the nearest active one; 255: or more */
    atomic_uchar *known;
    uint32_t *bits;                /* `words` a brick, x fastest, `across` macrocells on each axis */
    uint32_t words, across, shift; /* shift: log2 of a macrocell's edge */
};

/* For a picture. What is known stays while level, mode, transfer function and skip do. */
int vr_cast_activity_begin(struct vr_cast_activity *activity, const struct brick_volume *volume,
                           const struct brick_active_query *query, bool skip, struct brick_error *err);
void vr_cast_activity_finish(struct vr_cast_activity *activity);

/* The bits of an active brick of the level, NULL if all are set, whose ranges of macrocells are at `ranges`;
 * scratch: words for them if another thread is at it. */
const uint32_t *vr_cast_activity_bits(struct vr_cast_activity *activity, uint64_t brick, const void *ranges,
                                      uint32_t *scratch);

#endif
