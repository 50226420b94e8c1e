/* The residency from inside: residency.c keeps the tables, bring.c decides what comes and goes.
 *
 * Invariants: slot s holds brick slots[s].id or NO_BRICK; slot_of[b] names the slot of brick b of the table's
 * level, or NO_SLOT, and the two agree; page[b] is what the GPU's table holds, or will at the end of the
 * call, unless `stale`. A brick that did not get into the texture, because of an error, is not in the map. */
#ifndef RENDERER_RESIDENCY_RESIDENT_H
#define RENDERER_RESIDENCY_RESIDENT_H

#include <brick/cache.h>

#include "classified.h"
#include "depth.h"
#include "residency.h"
#include "stand_ins.h"
#include "upload.h"
#include "wants.h"

#define NO_BRICK UINT64_MAX
#define NO_SLOT  UINT32_MAX
#define NO_LEVEL UINT32_MAX

/* Beside enum brick_state: nothing in the brick is visible, and yet it is asked for. */
#define STATE_ASKED (BRICK_STATE_WHOLE + 1)

struct slot {
    uint64_t id;
    uint64_t used;       /* number of the last pass that wanted it */
    uint64_t classified; /* the classification its macrocell bits are of; 0: none */
    bool whole;          /* all of them are active */
    bool kept;           /* the brick stands in for others */
};

enum worth { WORTH_NOTHING, WORTH_PAST, WORTH_FUTURE };

struct victim {
    enum worth worth;
    uint64_t used;
    double distance; /* WORTH_FUTURE */
    uint32_t slot;
};

struct vr_residency {
    struct vr_context *context;
    const struct brick_volume *volume;
    struct brick_pool *pool;
    struct brick_cache *cache;
    struct brick_loader *loader;
    uint64_t gpu_bytes;
    enum vr_filter filter;
    uint64_t texels_number; /* of what slots hold in place of voxels; 0: voxels */
    struct vr_atlas atlas;
    struct vr_upload upload;
    struct vr_macrocells macrocells;
    struct vr_buffer pages;
    struct slot *slots;
    uint64_t used_slots, peak_slots, pass;
    struct vr_classified classified;

    uint32_t level; /* of the arrays below */
    uint64_t bricks;
    uint32_t *slot_of, *page;
    uint8_t *state;                /* enum brick_state, or STATE_ASKED */
    bool stale;                    /* the GPU does not have what the arrays say */
    struct vr_stand_ins stand_ins; /* all of them are in slots that are kept, but while they are brought */

    /* The picture at hand. */
    struct brick_active_query query; /* only while bricks are classified */
    struct vr_depth depth;
    uint64_t active, loaded; /* active: by what it shows; bricks that came for a gradient are not counted */
    struct brick_cache_counters before;

    uint32_t *order; /* NULL until asked for */

    /* Of one pass; room for one a slot (changed_pages: two) but for wants, which grow. */
    struct vr_wants wants;
    struct victim *victims;
    uint64_t *ids;
    uint32_t *changed_pages, *changed_slots;
    size_t changed_page_count, changed_slot_count;
};

/* The brick's number in the table's level; `bricks` or more: of another one. */
static inline uint64_t brick_in(const struct vr_residency *r, uint32_t slot)
{
    return r->slots[slot].id - brick_volume_grid(r->volume)->level[r->level].first_brick;
}

static inline bool needed_by_picture(const struct vr_residency *r, uint32_t slot)
{
    return r->slots[slot].id != NO_BRICK && brick_in(r, slot) < r->bricks &&
           r->state[brick_in(r, slot)] >= BRICK_STATE_ACTIVE;
}

/* Find a slot's macrocell bits for the picture. */
void vr_resident_classify(struct vr_residency *r, uint32_t slot);
/* Find a brick's page; find all, and write them. */
void vr_resident_set_page(struct vr_residency *r, uint64_t b);
int vr_resident_write_pages(struct vr_residency *r, struct brick_error *err);
/* Nothing stands in any more; pages that say otherwise are no longer read. */
void vr_resident_release(struct vr_residency *r);

#endif
