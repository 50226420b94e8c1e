/* Macrocells of the bricks in the atlas: ranges on the host, activity bits on the GPU, so that rays skip
 * inside bricks by the same rule by which whole bricks are skipped (Scharsach 2005, section 8: two sizes of
 * blocks). */
#ifndef RENDERER_RESIDENCY_MACROCELLS_H
#define RENDERER_RESIDENCY_MACROCELLS_H

#include <stdbool.h>

#include <brick/active.h>

#include "buffer.h"

struct vr_macrocells {
    int cells[3];    /* a slot's room on each axis; bit = (z * cells[1] + y) * cells[0] + x */
    int plane_words; /* a slot has two planes of bits: active, above */
    uint32_t slots;
    float *ranges; /* slots x cells x (min, max), stored values; min > max: nothing finite, or no such cell */
    uint32_t *words; /* what the buffer holds, or will */
    struct vr_buffer buffer;
};

int vr_macrocells_init(struct vr_macrocells *m, const struct brick_grid *grid, uint32_t slots,
                       struct brick_error *err);
void vr_macrocells_finish(struct vr_macrocells *m, struct vr_context *context);

/* Take over a brick's ranges as they stand in its payload behind the voxels. */
void vr_macrocells_set(struct vr_macrocells *m, uint32_t slot, const struct brick_grid *grid,
                       const struct brick_place *place, const void *ranges);
/* Find a slot's bits for a picture, and how many are active (brick_active_macrocells). Safe for different
 * slots at once. */
uint64_t vr_macrocells_classify(struct vr_macrocells *m, uint32_t slot, const struct brick_grid *grid,
                                const struct brick_active_query *query, bool whole);
/* Upload the bits of all slots; of some, whose numbers are sorted. The context is bound. */
int vr_macrocells_upload(struct vr_macrocells *m, struct vr_context *context, struct brick_error *err);
void vr_macrocells_update(struct vr_macrocells *m, struct vr_context *context, uint32_t *slots, size_t count);

#endif
