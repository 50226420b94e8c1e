/* The choice, as a map from bricks of coarser levels to slots. An active brick's coarser ones are active,
 * too, since ranges hold what lies below them. */
#include "stand_ins.h"

#include <stdlib.h>

#include <brick/active.h>

#define NOT_CHOSEN UINT32_MAX
#define NO_SLOT    (UINT32_MAX - 1) /* chosen, not there yet */

uint64_t vr_stand_ins_above(const struct brick_grid *grid, uint32_t level, uint64_t b, uint32_t coarser)
{
    const struct brick_level *l = &grid->level[level], *c = &grid->level[coarser];
    uint64_t at[3] = {b % l->bricks[0], b / l->bricks[0] % l->bricks[1], b / l->bricks[0] / l->bricks[1]};
    for (int a = 0; a < 3; a++)
        at[a] /= (uint64_t)(c->scale[a] / l->scale[a]);
    return brick_grid_id(grid, coarser, at[0], at[1], at[2]);
}

int vr_stand_ins_choose(struct vr_stand_ins *s, const struct brick_grid *grid, uint32_t level,
                        const uint8_t *states, uint64_t most, struct brick_error *err)
{
    const struct brick_level *l = &grid->level[level];
    const uint64_t bricks = l->bricks[0] * l->bricks[1] * l->bricks[2],
                   coarser = grid->bricks - bricks - l->first_brick;
    vr_stand_ins_finish(s);
    if (!coarser || !most)
        return BRICK_OK;
    s->first = l->first_brick + bricks;
    s->slot_of = malloc(coarser * sizeof *s->slot_of);
    if (!s->slot_of)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of %llu bricks",
                          (unsigned long long)coarser);
    for (uint64_t i = 0; i < coarser; i++)
        s->slot_of[i] = NOT_CHOSEN;
    s->finest = grid->levels;
    for (uint32_t c = grid->levels - 1; c > level; c--) {
        const uint64_t end = s->finest < grid->levels ? grid->level[s->finest].first_brick : grid->bricks;
        uint64_t n = 0;
        for (uint64_t b = 0; b < bricks; b++) {
            if (states[b] < BRICK_STATE_ACTIVE)
                continue;
            uint32_t *slot = &s->slot_of[vr_stand_ins_above(grid, level, b, c) - s->first];
            n += *slot == NOT_CHOSEN;
            *slot = NO_SLOT;
        }
        if (s->count + n > most) {
            for (uint64_t id = grid->level[c].first_brick; id < end; id++)
                s->slot_of[id - s->first] = NOT_CHOSEN;
            break;
        }
        s->count += n;
        s->finest = c;
    }
    return BRICK_OK;
}

void vr_stand_ins_finish(struct vr_stand_ins *s)
{
    free(s->slot_of);
    *s = (struct vr_stand_ins){0};
}

bool vr_stand_ins_chosen(const struct vr_stand_ins *s, uint64_t id)
{
    return s->slot_of && id >= s->first && s->slot_of[id - s->first] != NOT_CHOSEN;
}

bool vr_stand_ins_missing(const struct vr_stand_ins *s, uint64_t id)
{
    return vr_stand_ins_chosen(s, id) && s->slot_of[id - s->first] == NO_SLOT;
}

void vr_stand_ins_enter(struct vr_stand_ins *s, uint64_t id, uint32_t slot)
{
    s->slot_of[id - s->first] = slot;
}

bool vr_stand_ins_find(const struct vr_stand_ins *s, const struct brick_grid *grid, uint32_t level,
                       uint64_t b, uint32_t *slot, uint32_t *slot_level)
{
    for (uint32_t c = s->finest; s->slot_of && c < grid->levels; c++) {
        uint32_t found = s->slot_of[vr_stand_ins_above(grid, level, b, c) - s->first];
        if (found < NO_SLOT) {
            *slot = found;
            *slot_level = c;
            return true;
        }
    }
    return false;
}
