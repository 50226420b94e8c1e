/* Coarser bricks that stand in for missing ones while a picture is not final: all of the coarsest levels that
 * active bricks lie under, as far down as a share of the slots holds them. */
#ifndef RENDERER_RESIDENCY_STAND_INS_H
#define RENDERER_RESIDENCY_STAND_INS_H

#include <stdbool.h>
#include <stdint.h>

#include <brick/grid.h>

/* Of all slots. */
#define VR_STAND_INS_SHARE 8

struct vr_stand_ins {
    uint64_t first;    /* number of the first brick of a coarser level */
    uint32_t *slot_of; /* of the bricks from there on; NULL: none stand in */
    uint32_t finest;   /* level among them */
    uint64_t count;    /* that have a slot, or are to have one */
};

/* Choose for a level: its active bricks' coarser ones, at most `most`. states: of the level's bricks. One of
 * zeros is empty. */
int vr_stand_ins_choose(struct vr_stand_ins *stand_ins, const struct brick_grid *grid, uint32_t level,
                        const uint8_t *states, uint64_t most, struct brick_error *err);
void vr_stand_ins_finish(struct vr_stand_ins *stand_ins);

/* Is a brick (by its number in the volume) among the chosen? */
bool vr_stand_ins_chosen(const struct vr_stand_ins *stand_ins, uint64_t id);
/* And does it have no slot yet? */
bool vr_stand_ins_missing(const struct vr_stand_ins *stand_ins, uint64_t id);
/* A chosen brick has come into a slot. */
void vr_stand_ins_enter(struct vr_stand_ins *stand_ins, uint64_t id, uint32_t slot);
/* The slot of the finest brick that stands in for brick b of the level; false when there is none. */
bool vr_stand_ins_find(const struct vr_stand_ins *stand_ins, const struct brick_grid *grid, uint32_t level,
                       uint64_t b, uint32_t *slot, uint32_t *slot_level);
/* The coarser level's brick that holds brick b of the level. The finer brick's samples lie in it and, being
 * up to half a voxel before its start, in its border. */
uint64_t vr_stand_ins_above(const struct brick_grid *grid, uint32_t level, uint64_t b, uint32_t coarser);

#endif
