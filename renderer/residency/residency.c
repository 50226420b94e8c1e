/* The slot map and its upkeep.
 *
 * Invariants: slot s holds brick id[s] or NO_BRICK; slot_of[b] names the slot of brick b of the table's
 * level, or NO_SLOT, and the two agree; a slot that the picture at hand needs carries its number and is not
 * taken away. A brick is entered only once its voxels are in the texture, so an error in between leaves a
 * smaller but true map. */
#include "residency.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>

#include "page_table.h"

#define NO_BRICK UINT64_MAX
#define NO_SLOT  UINT32_MAX
/* Bricks read at once, a thread: enough to keep all busy, little memory. */
#define READS_A_THREAD 4
#define NO_LEVEL       UINT32_MAX

struct slot {
    uint64_t id;
    uint64_t picture;    /* the last that needed it */
    uint64_t classified; /* the classification its macrocell bits are of; 0: none */
};

/* What macrocell bits depend on, kept to see whether it changed. */
struct classification {
    uint64_t number;
    enum brick_mode mode;
    double isovalue;
    struct brick_transfer_knot *knots;
    size_t count;
};

struct vr_residency {
    struct vr_context *context;
    const struct brick_volume *volume;
    struct brick_pool *pool;
    struct vr_atlas atlas;
    struct vr_macrocells macrocells;
    struct vr_buffer pages;
    struct slot *slots;
    uint64_t used_slots, peak_slots, picture;
    struct classification classification;

    uint32_t level; /* of the arrays below */
    uint64_t bricks;
    uint32_t *slot_of, *page;
    uint8_t *state;

    unsigned reads; /* buffers */
    size_t read_bytes;
    uint8_t *read_data;
    struct brick_scratch *scratch;
};

struct missing {
    double distance;
    uint64_t id;
};

int vr_residency_create(struct vr_residency **out, struct vr_context *context,
                        const struct brick_volume *volume, uint64_t budget_bytes, struct brick_pool *pool,
                        struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    unsigned threads = brick_pool_threads(pool);
    uint64_t bytes;
    int result;
    struct vr_residency *r = calloc(1, sizeof *r);
    *out = NULL;
    if (!r)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the renderer");
    *r = (struct vr_residency){.context = context, .volume = volume, .pool = pool, .level = NO_LEVEL};
    if ((result = vr_atlas_init(&r->atlas, context, grid, budget_bytes, err)) ||
        (result = vr_macrocells_init(&r->macrocells, grid, r->atlas.count, err)))
        goto fail;
    r->reads = threads * READS_A_THREAD;
    r->read_bytes = (brick_grid_max_payload_bytes(grid) + 15) & ~(size_t)15;
    r->slots = malloc(r->atlas.count * sizeof *r->slots);
    r->scratch = calloc(threads, sizeof *r->scratch);
    if (!r->slots || !r->scratch || !brick_mul_u64(r->reads, r->read_bytes, &bytes) ||
        !(r->read_data = malloc(bytes))) {
        result =
            brick_fail(err, BRICK_ERR_MEMORY, "no memory for %u bricks on their way to the GPU", r->reads);
        goto fail;
    }
    for (uint32_t s = 0; s < r->atlas.count; s++)
        r->slots[s] = (struct slot){.id = NO_BRICK};
    *out = r;
    return BRICK_OK;
fail:
    vr_residency_destroy(&r);
    return result;
}

void vr_residency_destroy(struct vr_residency **residency)
{
    struct vr_residency *r = *residency;
    if (!r)
        return;
    vr_buffer_finish(&r->pages, r->context);
    vr_macrocells_finish(&r->macrocells, r->context);
    vr_atlas_finish(&r->atlas, r->context);
    for (unsigned t = 0; r->scratch && t < brick_pool_threads(r->pool); t++)
        brick_scratch_finish(&r->scratch[t]);
    free(r->scratch);
    free(r->read_data);
    free(r->slots);
    free(r->classification.knots);
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

static bool same_classification(const struct classification *c, const struct brick_active_query *q)
{
    size_t count = q->transfer && q->mode != BRICK_MODE_ISO ? q->transfer->count : 0;
    return c->number && c->mode == q->mode && (q->mode != BRICK_MODE_ISO || c->isovalue == q->isovalue) &&
           c->count == count && (!count || !memcmp(c->knots, q->transfer->knots, count * sizeof *c->knots));
}

static int set_classification(struct vr_residency *r, const struct brick_active_query *q,
                              struct brick_error *err)
{
    struct classification *c = &r->classification;
    size_t count = q->transfer && q->mode != BRICK_MODE_ISO ? q->transfer->count : 0;
    if (same_classification(c, q))
        return BRICK_OK;
    struct brick_transfer_knot *knots = count ? malloc(count * sizeof *knots) : NULL;
    if (count && !knots)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a transfer function of %zu knots", count);
    if (count)
        memcpy(knots, q->transfer->knots, count * sizeof *knots);
    free(c->knots);
    *c = (struct classification){c->number + 1, q->mode, q->isovalue, knots, count};
    return BRICK_OK;
}

static double eye_distance(const struct vr_residency *r, const struct brick_camera *camera, uint64_t id)
{
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    const struct brick_level *l = &grid->level[r->level];
    struct brick_place place;
    double index[3], squared = 0.0, along = 0.0;
    brick_grid_place(grid, id, &place);
    for (int a = 0; a < 3; a++)
        index[a] =
            l->scale[a] * ((double)(place.at[a] * grid->edge) + 0.5 * place.core[a] - 0.5) + l->offset[a];
    for (int a = 0; a < 3; a++) {
        const double *m = grid->affine[a];
        double d = m[0] * index[0] + m[1] * index[1] + m[2] * index[2] + m[3] - camera->eye_mm[a];
        squared += d * d;
        along += d * (camera->look_mm[a] - camera->eye_mm[a]);
    }
    return camera->ortho_height_mm > 0.0 ? along : squared;
}

static int nearer(const void *a, const void *b)
{
    const struct missing *p = a, *q = b;
    if (p->distance != q->distance)
        return p->distance < q->distance ? -1 : 1;
    return (p->id > q->id) - (p->id < q->id);
}

struct spare {
    uint64_t picture;
    uint32_t slot;
};

static int older(const void *a, const void *b)
{
    const struct spare *p = a, *q = b;
    if (p->picture != q->picture)
        return p->picture < q->picture ? -1 : 1;
    return (p->slot > q->slot) - (p->slot < q->slot);
}

struct batch {
    struct vr_residency *r;
    const struct missing *missing;
};

static int read_job(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct batch *batch = context;
    struct vr_residency *r = batch->r;
    return brick_volume_read(r->volume, batch->missing[item].id, r->read_data + item * r->read_bytes,
                             &r->scratch[worker], err);
}

static void enter(struct vr_residency *r, uint32_t s, uint64_t id, const uint8_t *payload)
{
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    struct slot *slot = &r->slots[s];
    struct brick_place place;
    uint64_t first = grid->level[r->level].first_brick;
    if (slot->id == NO_BRICK)
        r->used_slots++;
    else if (slot->id - first < r->bricks)
        r->slot_of[slot->id - first] = NO_SLOT;
    brick_grid_place(grid, id, &place);
    vr_atlas_upload(&r->atlas, r->context, s, place.stored, payload);
    vr_macrocells_set(&r->macrocells, s, grid, &place, payload + brick_place_voxel_bytes(grid, &place));
    *slot = (struct slot){.id = id, .picture = r->picture};
    r->slot_of[id - first] = s;
}

/* Read the missing bricks batch by batch, on all threads, and upload each batch in order. */
static int load(struct vr_residency *r, const struct missing *missing, uint64_t count,
                struct vr_residency_counters *counters, struct brick_error *err)
{
    int result = BRICK_OK;
    uint64_t spares = 0;
    struct spare *spare = malloc(r->atlas.count * sizeof *spare);
    if (!spare)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of %u slots", r->atlas.count);
    for (uint32_t s = 0; s < r->atlas.count; s++)
        if (r->slots[s].picture != r->picture)
            spare[spares++] = (struct spare){r->slots[s].picture, s};
    qsort(spare, spares, sizeof *spare, older);
    for (uint64_t i = 0; !result && i < count; i += r->reads) {
        struct batch batch = {r, missing + i};
        uint64_t n = count - i < r->reads ? count - i : r->reads;
        result = brick_pool_run(r->pool, n, read_job, &batch, err);
        for (uint64_t j = 0; !result && j < n; j++) {
            enter(r, spare[i + j].slot, missing[i + j].id, r->read_data + j * r->read_bytes);
            counters->bricks_loaded++;
            counters->bytes_read += brick_volume_entry(r->volume, missing[i + j].id)->bytes;
        }
    }
    free(spare);
    return result ? result : vr_context_check(r->context, "brick upload", err);
}

static int too_small(const struct vr_residency *r, uint64_t active, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    uint64_t bytes = vr_atlas_bytes_for(r->context, grid, active);
    double mib = 1024.0 * 1024.0;
    if (!bytes)
        return brick_fail(
            err, BRICK_ERR_MEMORY,
            "the picture needs %llu bricks (%.0f MiB) and one GPU cache texture holds at most %.0f MiB: "
            "use a coarser level or a transfer function that shows less",
            (unsigned long long)active, ceil((double)active * (double)r->atlas.slot_bytes / mib),
            (double)VR_ATLAS_MAX_BYTES / mib);
    return brick_fail(err, BRICK_ERR_MEMORY,
                      "the picture needs %llu bricks and the GPU cache holds %u: --gpu-cache %.0fM would do",
                      (unsigned long long)active, r->atlas.count, ceil((double)bytes / mib));
}

/* Macrocell bits of every brick the picture needs, where they are of another picture. */
static int classify_job(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct {
        struct vr_residency *r;
        const struct brick_active_query *query;
    } *job = context;
    struct vr_residency *r = job->r;
    struct slot *slot = &r->slots[item];
    (void)worker, (void)err;
    if (slot->id == NO_BRICK || slot->picture != r->picture || slot->classified == r->classification.number)
        return BRICK_OK;
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    vr_macrocells_classify(&r->macrocells, (uint32_t)item, grid, job->query,
                           r->state[slot->id - grid->level[r->level].first_brick] == BRICK_STATE_WHOLE);
    slot->classified = r->classification.number;
    return BRICK_OK;
}

static bool classification_due(const struct vr_residency *r)
{
    for (uint32_t s = 0; s < r->atlas.count; s++)
        if (r->slots[s].picture == r->picture && r->slots[s].classified != r->classification.number)
            return true;
    return false;
}

static void fill_pages(struct vr_residency *r)
{
    for (uint64_t b = 0; b < r->bricks; b++) {
        uint32_t at[3] = {0, 0, 0};
        enum vr_page_state state = r->state[b] == BRICK_STATE_ABOVE ? VR_PAGE_ABOVE : VR_PAGE_EMPTY;
        if (r->state[b] >= BRICK_STATE_ACTIVE) {
            state = r->slot_of[b] == NO_SLOT ? VR_PAGE_MISSING : VR_PAGE_RESIDENT;
            if (state == VR_PAGE_RESIDENT)
                vr_atlas_slot_place(&r->atlas, r->slot_of[b], at);
        }
        r->page[b] = vr_page(state, r->level, at);
    }
}

int vr_residency_update(struct vr_residency *r, const struct brick_active_query *query,
                        const struct brick_camera *camera, struct vr_residency_counters *counters,
                        struct brick_error *err)
{
    uint64_t first = brick_volume_grid(r->volume)->level[query->level].first_brick, absent = 0;
    struct missing *missing = NULL;
    int result;

    *counters = (struct vr_residency_counters){.cache_bytes = r->atlas.count * r->atlas.slot_bytes};
    if ((result = set_level(r, query->level, err)) || (result = set_classification(r, query, err)))
        return result;
    r->picture++;
    counters->bricks_total = r->bricks;
    brick_active_set(r->volume, query, r->state);
    for (uint64_t b = 0; b < r->bricks; b++) {
        if (r->state[b] < BRICK_STATE_ACTIVE)
            continue;
        counters->bricks_active++;
        if (r->slot_of[b] == NO_SLOT)
            absent++;
        else
            r->slots[r->slot_of[b]].picture = r->picture;
    }
    if (counters->bricks_active > r->atlas.count)
        return too_small(r, counters->bricks_active, err);
    if (absent) {
        missing = malloc(absent * sizeof *missing);
        if (!missing)
            return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of %llu bricks",
                              (unsigned long long)absent);
        absent = 0;
        for (uint64_t b = 0; b < r->bricks; b++)
            if (r->state[b] >= BRICK_STATE_ACTIVE && r->slot_of[b] == NO_SLOT)
                missing[absent++] = (struct missing){eye_distance(r, camera, first + b), first + b};
        qsort(missing, absent, sizeof *missing, nearer);
        result = load(r, missing, absent, counters, err);
        free(missing);
        if (result)
            return result;
    }
    r->peak_slots = r->used_slots > r->peak_slots ? r->used_slots : r->peak_slots;
    counters->cache_peak_bytes = r->peak_slots * r->atlas.slot_bytes;

    if (classification_due(r)) {
        struct {
            struct vr_residency *r;
            const struct brick_active_query *query;
        } job = {r, query};
        if ((result = brick_pool_run(r->pool, r->atlas.count, classify_job, &job, err)))
            return result;
        r->macrocells.dirty = true;
    }
    fill_pages(r);
    if ((result = vr_buffer_write(&r->pages, r->context, GL_R32UI, r->page, r->bricks * sizeof *r->page,
                                  "page table", err)))
        return result;
    return vr_macrocells_upload(&r->macrocells, r->context, err);
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
