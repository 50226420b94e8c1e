/* Which brick comes and goes when. Depths of bricks ascend along every ray (depth.h). Hence no ray will need
 * a brick that is nearer than the nearest brick that some ray waits for; and that one is needed now for the
 * last time. So bricks come nearest first, whether a ray waits for them or only asks ahead: a front that
 * sweeps the volume once, and few bricks come twice. (With bricks that are waited for before all others,
 * translucent volumes take a third more uploads: docs/performance.md.) Bricks behind the front go first,
 * least recently used ones before others; after them the farthest, which are needed last. */
#include "resident.h"

#include <stdlib.h>

#include <brick/threads.h>

static double distance_of(const struct vr_residency *r, uint64_t b, bool far_first)
{
    double depth = vr_depth_of(&r->depth, b);
    return far_first ? -depth : depth;
}

static int better_victim(const void *a, const void *b)
{
    const struct victim *p = a, *q = b;
    if (p->worth != q->worth)
        return p->worth < q->worth ? -1 : 1;
    if (p->worth == WORTH_FUTURE && p->distance != q->distance)
        return p->distance > q->distance ? -1 : 1;
    if (p->used != q->used)
        return p->used < q->used ? -1 : 1;
    return (p->slot > q->slot) - (p->slot < q->slot);
}

/* Slots that this pass does not want, those that go first in front. front: distance of the first brick that
 * this pass wants; distances are depths, or for a sweep towards the eye their negatives. */
static void find_victims(struct vr_residency *r, double front, bool far_first)
{
    size_t n = 0;
    for (uint32_t s = 0; s < r->atlas.count; s++) {
        if (r->slots[s].used == r->pass || r->slots[s].kept)
            continue;
        struct victim v = {WORTH_PAST, r->slots[s].used, 0.0, s};
        if (r->slots[s].id == NO_BRICK) {
            v.worth = WORTH_NOTHING;
        } else if (needed_by_picture(r, s)) {
            v.distance = distance_of(r, brick_in(r, s), far_first);
            v.worth = v.distance < front ? WORTH_PAST : WORTH_FUTURE;
        }
        r->victims[n++] = v;
    }
    qsort(r->victims, n, sizeof *r->victims, better_victim);
}

static void evict(struct vr_residency *r, uint32_t s)
{
    if (r->slots[s].id == NO_BRICK)
        return;
    uint64_t b = brick_in(r, s);
    r->slots[s].id = NO_BRICK;
    r->used_slots--;
    if (b < r->bricks) {
        r->slot_of[b] = NO_SLOT;
        vr_resident_set_page(r, b);
        r->changed_pages[r->changed_page_count++] = (uint32_t)b;
    }
}

/* A brick in a slot to the shaders, in this picture from now on active: a ray may ask for one in which
 * nothing is visible, for a gradient at its edge. */
static void show(struct vr_residency *r, uint64_t b)
{
    uint32_t s = r->slot_of[b];
    if (r->state[b] < BRICK_STATE_ACTIVE)
        r->state[b] = STATE_ASKED;
    vr_resident_classify(r, s);
    vr_resident_set_page(r, b);
    r->changed_pages[r->changed_page_count++] = (uint32_t)b;
    r->changed_slots[r->changed_slot_count++] = s;
}

static int enter(struct vr_residency *r, uint32_t s, uint64_t id, const uint8_t *payload,
                 struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    uint64_t b = id - grid->level[r->level].first_brick;
    struct brick_place place;
    brick_grid_place(grid, id, &place);
    size_t bytes = brick_place_voxel_bytes(grid, &place);
    int result = vr_upload_add(&r->upload, r->context, &r->atlas, s, place.stored, payload, err);
    if (result)
        return result;
    vr_macrocells_set(&r->macrocells, s, grid, &place, payload + bytes);
    r->slots[s] = (struct slot){.id = id, .used = r->pass};
    if (++r->used_slots > r->peak_slots)
        r->peak_slots = r->used_slots;
    if (b >= r->bricks) /* it is to stand in */
        return BRICK_OK;
    r->slot_of[b] = s;
    show(r, b);
    return BRICK_OK;
}

/* The bricks ids[0..n), into the slots of the first victims in the order in which they come; after one has
 * come, no more beyond the deadline. */
static int load(struct vr_residency *r, size_t n, uint64_t deadline_ns, struct brick_error *err)
{
    struct brick_taken taken = {.what = BRICK_TAKE_LATER};
    size_t entered = 0;
    int result = brick_loader_want(r->loader, r->ids, n, err);
    while (!result && entered < n && (!entered || brick_now_ns() < deadline_ns)) {
        result = brick_loader_take(r->loader, UINT64_MAX, &taken, err);
        if (result || taken.what != BRICK_TAKE_BRICK)
            break;
        evict(r, r->victims[entered].slot);
        result = enter(r, r->victims[entered].slot, taken.id, taken.data, err);
        entered += !result;
        brick_cache_unpin(r->cache, taken.id);
    }
    if (!result && entered < n)
        result = brick_loader_want(r->loader, NULL, 0, err);
    if (!result)
        result = vr_upload_flush(&r->upload, r->context, &r->atlas, err);
    if (result) {
        brick_loader_want(r->loader, NULL, 0, NULL);
        vr_upload_flush(&r->upload, r->context, &r->atlas, NULL);
        r->changed_page_count = 0;
        for (size_t i = 0; i < entered; i++)
            evict(r, r->victims[i].slot);
        r->stale = true;
        return result;
    }
    r->loaded += entered;
    vr_buffer_update(&r->pages, r->context, r->page, sizeof *r->page, r->changed_pages,
                     r->changed_page_count);
    vr_macrocells_update(&r->macrocells, r->context, r->changed_slots, r->changed_slot_count);
    return vr_context_check(r->context, "brick upload", err);
}

/* Of the wants that a slot can hold: those that are missing, to the list's start. Returns their number. */
static size_t find_missing(struct vr_residency *r, size_t count)
{
    size_t missing = 0;
    r->pass++;
    r->changed_page_count = r->changed_slot_count = 0;
    for (size_t i = 0; i < count && i < r->atlas.count - r->stand_ins.count; i++) {
        uint32_t b = r->wants.item[i].brick, s = r->slot_of[b];
        if (s == NO_SLOT) {
            r->wants.item[missing++] = r->wants.item[i];
            continue;
        }
        r->slots[s].used = r->pass;
        if (r->state[b] < BRICK_STATE_ACTIVE)
            show(r, b);
    }
    return missing;
}

int vr_residency_bring(struct vr_residency *r, const struct vr_feedback *feedback,
                       const struct vr_residency_limit *limit, uint64_t *wanted, struct brick_error *err)
{
    uint64_t first = brick_volume_grid(r->volume)->level[r->level].first_brick;
    size_t count = 0, n = 0;
    int result = vr_wants_gather(&r->wants, feedback, &r->depth, &count, err);
    *wanted = count;
    if (result)
        return result;
    const double front = count ? r->wants.item[0].distance : 0.0;
    const size_t missing = find_missing(r, count);
    if (!missing && !r->changed_page_count)
        return BRICK_OK;
    find_victims(r, front, false);
    for (size_t i = 0; i < missing && n < limit->bricks; i++) {
        const struct vr_want *w = &r->wants.item[i];
        const struct victim *v = &r->victims[n];
        /* What comes next does not push out what is nearer. */
        if (w->needed || v->worth != WORTH_FUTURE || v->distance > w->distance)
            r->ids[n++] = first + w->brick;
    }
    return load(r, n, limit->deadline_ns, err);
}

/* Slots whose bricks have been chosen to stand in are kept, and the chosen ones that have none go to ids.
 * Returns their number. */
static size_t keep_stand_ins(struct vr_residency *r)
{
    const uint64_t end = brick_volume_grid(r->volume)->bricks;
    size_t n = 0;
    for (uint32_t s = 0; s < r->atlas.count; s++)
        if (r->slots[s].id != NO_BRICK && vr_stand_ins_chosen(&r->stand_ins, r->slots[s].id)) {
            vr_stand_ins_enter(&r->stand_ins, r->slots[s].id, s);
            r->slots[s].kept = true;
        }
    for (uint64_t id = end; n < r->stand_ins.count && id-- > r->stand_ins.first;)
        if (vr_stand_ins_missing(&r->stand_ins, id))
            r->ids[n++] = id;
    return n;
}

int vr_residency_stand_in(struct vr_residency *r, struct brick_error *err)
{
    const uint64_t most =
        r->atlas.count > VR_STAND_INS_SHARE ? r->atlas.count / VR_STAND_INS_SHARE : r->atlas.count > 1;
    if (r->stand_ins.slot_of)
        return BRICK_OK;
    int result =
        vr_stand_ins_choose(&r->stand_ins, brick_volume_grid(r->volume), r->level, r->state, most, err);
    if (result || !r->stand_ins.count)
        return result;
    r->pass++;
    r->changed_page_count = r->changed_slot_count = 0;
    size_t n = keep_stand_ins(r);
    find_victims(r, 0.0, false);
    if ((result = load(r, n, UINT64_MAX, err))) {
        vr_resident_release(r);
        return result;
    }
    keep_stand_ins(r);
    return vr_resident_write_pages(r, err);
}

/* Ask for the bricks around one. One that happens to be resident has bits of another classification. */
static bool ask_around(struct vr_residency *r, const uint64_t bricks[3], const uint64_t at[3])
{
    bool asked = false;
    for (unsigned n = 0; n < 27; n++) {
        const uint64_t next[3] = {at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1};
        if (next[0] >= bricks[0] || next[1] >= bricks[1] || next[2] >= bricks[2])
            continue;
        const uint64_t b = (next[2] * bricks[1] + next[1]) * bricks[0] + next[0];
        if (r->state[b] >= BRICK_STATE_ACTIVE)
            continue;
        r->state[b] = STATE_ASKED;
        if (r->slot_of[b] != NO_SLOT)
            vr_resident_classify(r, r->slot_of[b]);
        asked = true;
    }
    return asked;
}

int vr_residency_touching(struct vr_residency *r, struct brick_error *err)
{
    const uint64_t *bricks = brick_volume_grid(r->volume)->level[r->level].bricks;
    const uint8_t *state = r->state;
    bool asked = false;
    for (uint64_t z = 0; z < bricks[2]; z++)
        for (uint64_t y = 0; y < bricks[1]; y++)
            for (uint64_t x = 0; x < bricks[0]; x++, state++)
                if (*state == BRICK_STATE_ACTIVE || *state == BRICK_STATE_WHOLE)
                    asked |= ask_around(r, bricks, (const uint64_t[]){x, y, z});
    if (!asked)
        return BRICK_OK;
    int result = vr_resident_write_pages(r, err);
    if (!result)
        result = vr_macrocells_upload(&r->macrocells, r->context, err);
    r->stale = result;
    return result;
}

int vr_residency_order(struct vr_residency *r, bool far_first, const uint32_t **bricks, size_t *count,
                       struct brick_error *err)
{
    size_t most = 0, n = 0;
    for (uint64_t b = 0; b < r->bricks; b++) /* r->active lacks those that came for a gradient */
        most += r->state[b] >= BRICK_STATE_ACTIVE;
    int result = vr_wants_reserve(&r->wants, most, err);
    uint32_t *order = realloc(r->order, (most ? most : 1) * sizeof *order);
    if (order)
        r->order = order;
    else if (!result)
        result = brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of %zu bricks", most);
    if (result)
        return result;
    for (uint64_t b = 0; b < r->bricks; b++)
        if (r->state[b] >= BRICK_STATE_ACTIVE)
            r->wants.item[n++] = (struct vr_want){distance_of(r, b, far_first), (uint32_t)b, true};
    vr_wants_sort(&r->wants, n);
    for (size_t i = 0; i < n; i++)
        order[i] = r->wants.item[i].brick;
    *bricks = order;
    *count = n;
    return BRICK_OK;
}

int vr_residency_hold(struct vr_residency *r, const uint32_t *bricks, size_t n, bool far_first,
                      struct brick_error *err)
{
    uint64_t first = brick_volume_grid(r->volume)->level[r->level].first_brick;
    int result = vr_wants_reserve(&r->wants, n, err);
    if (result || !n)
        return result;
    vr_resident_release(r); /* n may be all slots */
    for (size_t i = 0; i < n; i++)
        r->wants.item[i] = (struct vr_want){0.0, bricks[i], true};
    const size_t missing = find_missing(r, n);
    if (!missing)
        return BRICK_OK;
    find_victims(r, distance_of(r, bricks[0], far_first), far_first);
    for (size_t i = 0; i < missing; i++)
        r->ids[i] = first + r->wants.item[i].brick;
    return load(r, missing, UINT64_MAX, err);
}
