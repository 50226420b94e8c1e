/* The slot map and its upkeep.
 *
 * Invariants: slot s holds brick slots[s].id or NO_BRICK; slot_of[b] names the slot of brick b of the table's
 * level, or NO_SLOT, and the two agree; page[b] is what the GPU's table holds, or will at the end of the
 * call, unless `stale`. A brick that did not get into the texture, because of an error, is not in the map.
 *
 * Bricks come nearest first, whether a ray waits for them or only asks ahead (victims.h says why that is
 * right): a front that sweeps the volume once, and few bricks come twice. With bricks that are waited for
 * before all others, translucent volumes take a third more uploads (docs/performance.md). */
#include "residency.h"

#include <stdlib.h>
#include <string.h>

#include <brick/cache.h>

#include "classified.h"
#include "depth.h"
#include "page_table.h"
#include "upload.h"
#include "victims.h"
#include "wants.h"

#define NO_BRICK UINT64_MAX
#define NO_SLOT  UINT32_MAX
#define NO_LEVEL UINT32_MAX

struct slot {
    uint64_t id;
    uint64_t used;       /* number of the last pass that wanted it */
    uint64_t classified; /* the classification its macrocell bits are of; 0: none */
};

struct vr_residency {
    struct vr_context *context;
    const struct brick_volume *volume;
    struct brick_pool *pool;
    struct brick_cache *cache;
    struct brick_loader *loader;
    uint64_t gpu_bytes;
    enum vr_filter filter;
    uint64_t texels_number; /* of what slots hold in place of voxels */
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
    uint8_t *state;
    bool stale; /* the GPU does not have what the arrays say */

    /* The picture at hand. */
    struct brick_active_query query; /* only while bricks are classified */
    struct vr_depth depth;
    uint64_t active, loaded;
    struct brick_cache_counters before;
    uint32_t *order; /* NULL until asked for */

    /* Of one pass; room for one a slot (changed_pages: two) but for wants. */
    struct vr_wants wants;
    struct vr_victim *victims;
    uint64_t *ids;
    uint32_t *changed_pages, *changed_slots;
    size_t changed_page_count, changed_slot_count;
};

static void empty_slots(struct vr_residency *r)
{
    for (size_t s = 0; s < r->atlas.count; s++)
        r->slots[s] = (struct slot){.id = NO_BRICK};
    for (uint64_t b = 0; r->level != NO_LEVEL && b < r->bricks; b++)
        r->slot_of[b] = NO_SLOT;
    r->used_slots = r->peak_slots = 0;
    r->stale = true;
}

static void drop_slots(struct vr_residency *r)
{
    vr_macrocells_finish(&r->macrocells, r->context);
    vr_upload_finish(&r->upload, r->context);
    vr_atlas_finish(&r->atlas, r->context);
    free(r->slots), r->slots = NULL;
    free(r->victims), r->victims = NULL;
    free(r->ids), r->ids = NULL;
    free(r->changed_pages), r->changed_pages = NULL;
}

/* The atlas and what goes with its slots, within the budget. */
static int make_slots(struct vr_residency *r, const struct vr_texels *texels, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    int result = vr_atlas_init(&r->atlas, r->context, grid, r->filter, texels, r->gpu_bytes, err);
    if (result || (result = vr_upload_init(&r->upload, r->context, &r->atlas, err)) ||
        (result = vr_macrocells_init(&r->macrocells, grid, r->atlas.count, err)))
        goto fail;
    size_t n = r->atlas.count;
    r->slots = malloc(n * sizeof *r->slots);
    r->victims = malloc(n * sizeof *r->victims);
    r->ids = malloc(n * sizeof *r->ids);
    r->changed_pages = malloc(3 * n * sizeof *r->changed_pages);
    if (!r->slots || !r->victims || !r->ids || !r->changed_pages) {
        result = brick_fail(err, BRICK_ERR_MEMORY, "no memory for a GPU cache of %zu bricks", n);
        goto fail;
    }
    r->changed_slots = r->changed_pages + 2 * n;
    empty_slots(r);
    return BRICK_OK;
fail:
    drop_slots(r);
    return result;
}

int vr_residency_create(struct vr_residency **out, struct vr_context *context,
                        const struct brick_volume *volume, const struct vr_renderer_params *params,
                        struct brick_pool *pool, struct brick_error *err)
{
    int result;
    struct vr_residency *r = calloc(1, sizeof *r);
    *out = NULL;
    if (!r)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the renderer");
    *r = (struct vr_residency){.context = context, .volume = volume, .pool = pool, .level = NO_LEVEL};
    /* No standard says what a sampler makes of NaN times 0. */
    r->filter = brick_volume_stats(volume)->nonfinite ? VR_FILTER_EXACT : params->filter;
    r->gpu_bytes = params->gpu_cache_bytes;
    if ((result = brick_cache_create(&r->cache, volume, params->host_cache_bytes, err)) ||
        (result = brick_loader_create(&r->loader, r->cache, brick_pool_threads(pool), 0, err)) ||
        (result = make_slots(r, NULL, err))) {
        vr_residency_destroy(&r);
        return result;
    }
    *out = r;
    return BRICK_OK;
}

int vr_residency_set_texels(struct vr_residency *r, const struct vr_texels *texels, struct brick_error *err)
{
    const uint64_t number = texels ? texels->number : 0;
    const bool another = number != r->texels_number;
    /* texels may be the struct of last time, filled anew: what the atlas is made for, it knows itself. */
    const bool same_layout =
        texels ? texels->voxels.internal == r->atlas.voxels.internal && r->atlas.texels : !r->atlas.texels;
    r->texels_number = number;
    r->atlas.texels = texels;
    if (same_layout && r->atlas.count) {
        if (another)
            empty_slots(r);
        return BRICK_OK;
    }
    drop_slots(r);
    int result = make_slots(r, texels, err);
    if (result)
        r->texels_number = 0, make_slots(r, NULL, NULL); /* or else next time */
    return result;
}

void vr_residency_destroy(struct vr_residency **residency)
{
    struct vr_residency *r = *residency;
    if (!r)
        return;
    brick_loader_destroy(&r->loader);
    brick_cache_destroy(&r->cache);
    vr_buffer_finish(&r->pages, r->context);
    drop_slots(r);
    vr_wants_finish(&r->wants);
    free(r->order);
    vr_classified_finish(&r->classified);
    free(r->slot_of);
    free(r->page);
    free(r->state);
    free(r);
    *residency = NULL;
}

/* Arrays of one word a brick for another level; what is resident of it is found again from the slots. */
static int set_level(struct vr_residency *r, uint32_t level, struct brick_error *err)
{
    const struct brick_level *l = &brick_volume_grid(r->volume)->level[level];
    uint64_t n = l->bricks[0] * l->bricks[1] * l->bricks[2];
    if (level == r->level)
        return BRICK_OK;
    r->level = NO_LEVEL;
    if (n > (uint64_t)r->context->max_buffer_elements)
        return brick_fail(
            err, BRICK_ERR_UNSUPPORTED,
            "level %u has %llu bricks; one page table of OpenGL (%s) holds %lld: use a coarser level or "
            "larger bricks",
            level, (unsigned long long)n, r->context->renderer, (long long)r->context->max_buffer_elements);
    free(r->slot_of);
    free(r->page);
    free(r->state);
    r->slot_of = malloc(n * sizeof *r->slot_of);
    r->page = malloc(n * sizeof *r->page);
    r->state = malloc(n);
    if (!r->slot_of || !r->page || !r->state)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a page table of %llu bricks",
                          (unsigned long long)n);
    r->level = level;
    r->bricks = n;
    for (uint64_t b = 0; b < n; b++)
        r->slot_of[b] = NO_SLOT;
    for (uint32_t s = 0; s < r->atlas.count; s++)
        if (r->slots[s].id != NO_BRICK && r->slots[s].id - l->first_brick < n)
            r->slot_of[r->slots[s].id - l->first_brick] = s;
    return BRICK_OK;
}

/* The brick's number in the table's level; `bricks` or more: of another one. */
static uint64_t brick_in(const struct vr_residency *r, uint32_t slot)
{
    return r->slots[slot].id - brick_volume_grid(r->volume)->level[r->level].first_brick;
}

static bool needed_by_picture(const struct vr_residency *r, uint32_t slot)
{
    return r->slots[slot].id != NO_BRICK && brick_in(r, slot) < r->bricks &&
           r->state[brick_in(r, slot)] >= BRICK_STATE_ACTIVE;
}

static void classify(struct vr_residency *r, uint32_t s)
{
    vr_macrocells_classify(&r->macrocells, s, brick_volume_grid(r->volume), &r->query,
                           r->state[brick_in(r, s)] == BRICK_STATE_WHOLE);
    r->slots[s].classified = r->classified.number;
}

static int classify_job(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct vr_residency *r = context;
    (void)worker, (void)err;
    if (needed_by_picture(r, (uint32_t)item) && r->slots[item].classified != r->classified.number)
        classify(r, (uint32_t)item);
    return BRICK_OK;
}

static void set_page(struct vr_residency *r, uint64_t b)
{
    uint32_t at[3] = {0, 0, 0};
    enum vr_page_state state = r->state[b] == BRICK_STATE_ABOVE ? VR_PAGE_ABOVE : VR_PAGE_EMPTY;
    if (r->state[b] >= BRICK_STATE_ACTIVE) {
        state = r->slot_of[b] == NO_SLOT ? VR_PAGE_MISSING : VR_PAGE_RESIDENT;
        if (state == VR_PAGE_RESIDENT)
            vr_atlas_slot_place(&r->atlas, r->slot_of[b], at);
    }
    r->page[b] = vr_page(state, r->level, at);
}

int vr_residency_begin(struct vr_residency *r, const struct brick_active_query *query,
                       const struct brick_camera *camera, struct brick_error *err)
{
    uint64_t classification = r->classified.number;
    uint32_t level = r->level;
    int result;

    if ((result = set_level(r, query->level, err)) ||
        (result = vr_classified_set(&r->classified, query, err)))
        return result;
    r->query = *query;
    vr_depth_init(&r->depth, brick_volume_grid(r->volume), query->level, camera);
    r->loaded = 0;
    brick_cache_count(r->cache, &r->before);
    if (!r->stale && level == r->level && classification == r->classified.number)
        return BRICK_OK;
    r->stale = true;
    r->active = brick_active_set(r->volume, query, r->state);
    if ((result = brick_pool_run(r->pool, r->atlas.count, classify_job, r, err)))
        return result;
    for (uint64_t b = 0; b < r->bricks; b++)
        set_page(r, b);
    if ((result = vr_buffer_write(&r->pages, r->context, GL_R32UI, r->page, r->bricks * sizeof *r->page,
                                  "page table", err)) ||
        (result = vr_macrocells_upload(&r->macrocells, r->context, err)))
        return result;
    r->stale = false;
    return BRICK_OK;
}

static double distance_of(const struct vr_residency *r, uint64_t b, bool far_first)
{
    double depth = vr_depth_of(&r->depth, b);
    return far_first ? -depth : depth;
}

/* Slots that this pass does not want, those that go first in front. front: distance of the first brick that
 * this pass wants; distances are depths, or for a sweep towards the eye their negatives. */
static void find_victims(struct vr_residency *r, double front, bool far_first)
{
    size_t n = 0;
    for (uint32_t s = 0; s < r->atlas.count; s++) {
        if (r->slots[s].used == r->pass)
            continue;
        struct vr_victim v = {VR_WORTH_PAST, r->slots[s].used, 0.0, s};
        if (r->slots[s].id == NO_BRICK) {
            v.worth = VR_WORTH_NOTHING;
        } else if (needed_by_picture(r, s)) {
            v.distance = distance_of(r, brick_in(r, s), far_first);
            v.worth = v.distance < front ? VR_WORTH_PAST : VR_WORTH_FUTURE;
        }
        r->victims[n++] = v;
    }
    vr_victims_sort(r->victims, n);
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
        set_page(r, b);
        r->changed_pages[r->changed_page_count++] = (uint32_t)b;
    }
}

/* A brick in a slot to the shaders, in this picture from now on active: a ray may ask for one in which
 * nothing is visible, for a gradient at its edge. */
static void show(struct vr_residency *r, uint64_t b)
{
    uint32_t s = r->slot_of[b];
    if (r->state[b] < BRICK_STATE_ACTIVE)
        r->state[b] = BRICK_STATE_ACTIVE;
    classify(r, s);
    set_page(r, b);
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
    r->slot_of[b] = s;
    if (++r->used_slots > r->peak_slots)
        r->peak_slots = r->used_slots;
    show(r, b);
    return BRICK_OK;
}

/* The bricks ids[0..n), into the slots of the first n victims in the order in which they come. */
static int load(struct vr_residency *r, size_t n, struct brick_error *err)
{
    struct brick_taken taken = {.what = BRICK_TAKE_LATER};
    size_t entered = 0;
    for (size_t i = 0; i < n; i++)
        evict(r, r->victims[i].slot);
    int result = brick_loader_want(r->loader, r->ids, n, err);
    while (!result && entered < n) {
        result = brick_loader_take(r->loader, UINT64_MAX, &taken, err);
        if (result || taken.what != BRICK_TAKE_BRICK)
            break;
        result = enter(r, r->victims[entered].slot, taken.id, taken.data, err);
        entered += !result;
        brick_cache_unpin(r->cache, taken.id);
    }
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
    for (size_t i = 0; i < count && i < r->atlas.count; i++) {
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

int vr_residency_bring(struct vr_residency *r, const struct vr_feedback *feedback, uint64_t *wanted,
                       struct brick_error *err)
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
    for (size_t i = 0; i < missing; i++) {
        const struct vr_want *w = &r->wants.item[i];
        const struct vr_victim *v = &r->victims[n];
        /* What comes next does not push out what is nearer. */
        if (w->needed || v->worth != VR_WORTH_FUTURE || v->distance > w->distance)
            r->ids[n++] = first + w->brick;
    }
    return load(r, n, err);
}

int vr_residency_order(struct vr_residency *r, bool far_first, const uint32_t **bricks, size_t *count,
                       struct brick_error *err)
{
    size_t n = 0;
    int result = vr_wants_reserve(&r->wants, r->active, err);
    uint32_t *order = realloc(r->order, (r->active ? r->active : 1) * sizeof *order);
    if (order)
        r->order = order;
    else if (!result)
        result = brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of %llu bricks",
                            (unsigned long long)r->active);
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
    for (size_t i = 0; i < n; i++)
        r->wants.item[i] = (struct vr_want){0.0, bricks[i], true};
    const size_t missing = find_missing(r, n);
    if (!missing)
        return BRICK_OK;
    find_victims(r, distance_of(r, bricks[0], far_first), far_first);
    for (size_t i = 0; i < missing; i++)
        r->ids[i] = first + r->wants.item[i].brick;
    return load(r, missing, err);
}

uint32_t vr_residency_slot(const struct vr_residency *r, uint32_t brick)
{
    return r->slot_of[brick];
}

void vr_residency_count(const struct vr_residency *r, struct vr_residency_counters *counters)
{
    struct brick_cache_counters now;
    brick_cache_count(r->cache, &now);
    *counters = (struct vr_residency_counters){
        .bricks_total = r->bricks,
        .bricks_active = r->active,
        .bricks_loaded = r->loaded,
        .bricks_read = now.loads - r->before.loads,
        .bytes_read = now.bytes_read - r->before.bytes_read,
        .cache_bytes = r->atlas.bytes,
        .cache_peak_bytes = r->peak_slots * r->atlas.slot_bytes,
        .host_cache_peak_bytes = now.peak_bytes,
    };
}

const struct vr_atlas *vr_residency_atlas(const struct vr_residency *residency)
{
    return &residency->atlas;
}

const struct vr_macrocells *vr_residency_macrocells(const struct vr_residency *residency)
{
    return &residency->macrocells;
}

const struct vr_buffer *vr_residency_pages(const struct vr_residency *residency)
{
    return &residency->pages;
}
