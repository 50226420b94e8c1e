/* The slot map and its tables, from picture to picture. */
#include "resident.h"

#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>

#include "page_table.h"

static void empty_slots(struct vr_residency *r)
{
    for (size_t s = 0; s < r->atlas.count; s++)
        r->slots[s] = (struct slot){.id = NO_BRICK};
    for (uint64_t b = 0; r->level != NO_LEVEL && b < r->bricks; b++)
        r->slot_of[b] = NO_SLOT;
    r->used_slots = r->peak_slots = 0;
    vr_resident_release(r);
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
    vr_stand_ins_finish(&r->stand_ins);
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

void vr_resident_classify(struct vr_residency *r, uint32_t s)
{
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    struct brick_place place;
    brick_grid_place(grid, r->slots[s].id, &place);
    uint64_t active = vr_macrocells_classify(&r->macrocells, s, grid, &r->query,
                                             r->state[brick_in(r, s)] == BRICK_STATE_WHOLE);
    r->slots[s].whole = active >= (uint64_t)place.macrocells[0] * place.macrocells[1] * place.macrocells[2];
    r->slots[s].classified = r->classified.number;
}

static int classify_job(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct vr_residency *r = context;
    (void)worker, (void)err;
    if (needed_by_picture(r, (uint32_t)item) && r->slots[item].classified != r->classified.number)
        vr_resident_classify(r, (uint32_t)item);
    return BRICK_OK;
}

void vr_resident_set_page(struct vr_residency *r, uint64_t b)
{
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    uint32_t at[3] = {0, 0, 0}, slot = r->slot_of[b], level = r->level;
    enum vr_page_state state = VR_PAGE_INACTIVE;
    at[0] = r->state[b] == BRICK_STATE_ABOVE;
    if (r->state[b] >= BRICK_STATE_ACTIVE) {
        state = slot == NO_SLOT ? VR_PAGE_MISSING : r->slots[slot].whole ? VR_PAGE_WHOLE : VR_PAGE_RESIDENT;
        if (slot != NO_SLOT || vr_stand_ins_find(&r->stand_ins, grid, r->level, b, &slot, &level))
            vr_atlas_slot_place(&r->atlas, slot, at);
    }
    r->page[b] = vr_page(state, level, at);
}

int vr_resident_write_pages(struct vr_residency *r, struct brick_error *err)
{
    for (uint64_t b = 0; b < r->bricks; b++)
        vr_resident_set_page(r, b);
    return vr_buffer_write(&r->pages, r->context, GL_R32UI, r->page, r->bricks * sizeof *r->page,
                           "page table", err);
}

void vr_resident_release(struct vr_residency *r)
{
    if (!r->stand_ins.slot_of)
        return;
    vr_stand_ins_finish(&r->stand_ins);
    for (uint32_t s = 0; s < r->atlas.count; s++)
        r->slots[s].kept = false;
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
    vr_resident_release(r);
    r->active = brick_active_set(r->volume, query, r->state);
    if ((result = brick_pool_run(r->pool, r->atlas.count, classify_job, r, err)))
        return result;
    if ((result = vr_resident_write_pages(r, err)) ||
        (result = vr_macrocells_upload(&r->macrocells, r->context, err)))
        return result;
    r->stale = false;
    return BRICK_OK;
}

uint32_t vr_residency_slot(const struct vr_residency *r, uint32_t brick)
{
    return r->slot_of[brick];
}

const uint8_t *vr_residency_states(const struct vr_residency *r)
{
    return r->state;
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

enum vr_filter vr_residency_filter(const struct vr_residency *residency)
{
    return residency->filter;
}

const struct vr_macrocells *vr_residency_macrocells(const struct vr_residency *residency)
{
    return &residency->macrocells;
}

const struct vr_buffer *vr_residency_pages(const struct vr_residency *residency)
{
    return &residency->pages;
}
