/* Slots of the host cache. Invariants, under the lock: a slot is in the map from the moment its load starts;
 * it is in the line `idle` or `kept` (by its flag) iff it is loaded and not pinned; memory of slots never
 * exceeds the budget, and is taken only when first needed. Reading and decoding happen outside the lock, into
 * a slot that nobody else touches because it is in the map, pinned, and not ready. */
#include "slots.h"

#include <stdlib.h>

struct scratch {
    struct brick_scratch memory;
    struct scratch *next;
};

int brick_cache_create(struct brick_cache **cache, const struct brick_volume *volume, uint64_t budget_bytes,
                       struct brick_error *err)
{
    *cache = NULL;
    const struct brick_grid *grid = brick_volume_grid(volume);
    size_t slot_bytes = brick_grid_max_payload_bytes(grid);
    uint64_t n = budget_bytes / slot_bytes;
    if (n > grid->bricks)
        n = grid->bricks;
    if (n > UINT32_MAX / 4)
        n = UINT32_MAX / 4;
    if (n == 0)
        return brick_fail(err, BRICK_ERR_ARGUMENT,
                          "a host cache of %llu bytes does not hold one brick of %zu bytes",
                          (unsigned long long)budget_bytes, slot_bytes);
    struct brick_cache *c = calloc(1, sizeof *c);
    uint32_t buckets = 16;
    while (buckets < n)
        buckets *= 2;
    if (c) {
        c->slots = calloc(n, sizeof *c->slots);
        c->buckets = malloc(buckets * sizeof *c->buckets);
    }
    if (!c || !c->slots || !c->buckets) {
        if (c) {
            free(c->slots);
            free(c->buckets);
        }
        free(c);
        return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a host cache of %llu bricks",
                          (unsigned long long)n);
    }
    c->volume = volume;
    c->slot_bytes = slot_bytes;
    c->slots_max = (uint32_t)n;
    c->bucket_mask = buckets - 1;
    for (uint32_t i = 0; i < buckets; i++)
        c->buckets[i] = SLOT_NONE;
    c->empty = SLOT_NONE;
    c->idle = c->kept = (struct slot_line){SLOT_NONE, SLOT_NONE};
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&c->loaded, &monotonic);
    pthread_condattr_destroy(&monotonic);
    pthread_cond_init(&c->work, NULL);
    pthread_mutex_init(&c->lock, NULL);
    *cache = c;
    return BRICK_OK;
}

void brick_cache_destroy(struct brick_cache **cache)
{
    struct brick_cache *c = *cache;
    if (!c)
        return;
    for (uint32_t i = 0; i < c->slots_used; i++)
        free(c->slots[i].data);
    while (c->scratches) {
        struct scratch *next = c->scratches->next;
        brick_scratch_finish(&c->scratches->memory);
        free(c->scratches);
        c->scratches = next;
    }
    pthread_mutex_destroy(&c->lock);
    pthread_cond_destroy(&c->loaded);
    pthread_cond_destroy(&c->work);
    free(c->slots);
    free(c->buckets);
    free(c);
    *cache = NULL;
}

static uint32_t *bucket_of(struct brick_cache *c, uint64_t id)
{
    return &c->buckets[(id * UINT64_C(0x9e3779b97f4a7c15)) >> 32 & c->bucket_mask];
}

uint32_t slots_find(struct brick_cache *c, uint64_t id)
{
    uint32_t s = *bucket_of(c, id);
    while (s != SLOT_NONE && c->slots[s].id != id)
        s = c->slots[s].chain;
    return s;
}

static void map_add(struct brick_cache *c, uint32_t s)
{
    uint32_t *link = bucket_of(c, c->slots[s].id);
    c->slots[s].chain = *link;
    *link = s;
}

static void map_remove(struct brick_cache *c, uint32_t s)
{
    uint32_t *link = bucket_of(c, c->slots[s].id);
    while (*link != s)
        link = &c->slots[*link].chain;
    *link = c->slots[s].chain;
}

static void line_remove(struct brick_cache *c, uint32_t s)
{
    struct slot *slot = &c->slots[s];
    struct slot_line *line = slot->kept ? &c->kept : &c->idle;
    *(slot->newer == SLOT_NONE ? &line->newest : &c->slots[slot->newer].older) = slot->older;
    *(slot->older == SLOT_NONE ? &line->oldest : &c->slots[slot->older].newer) = slot->newer;
}

static void line_add(struct brick_cache *c, uint32_t s)
{
    struct slot *slot = &c->slots[s];
    struct slot_line *line = slot->kept ? &c->kept : &c->idle;
    slot->newer = SLOT_NONE;
    slot->older = line->newest;
    *(line->newest == SLOT_NONE ? &line->oldest : &c->slots[line->newest].newer) = s;
    line->newest = s;
    if (!slot->kept && c->has_loader)
        pthread_cond_signal(&c->work);
}

void slots_pin(struct brick_cache *c, uint32_t s)
{
    if (c->slots[s].pins++ == 0)
        line_remove(c, s);
    c->counters.hits++;
}

void slots_unpin(struct brick_cache *c, uint32_t s)
{
    if (--c->slots[s].pins == 0)
        line_add(c, s);
}

void slots_keep(struct brick_cache *c, uint32_t s, bool keep)
{
    bool lined = c->slots[s].pins == 0;
    if (lined)
        line_remove(c, s);
    c->slots[s].kept = keep;
    if (lined)
        line_add(c, s);
}

bool slots_spare(const struct brick_cache *c)
{
    return c->empty != SLOT_NONE || c->slots_used < c->slots_max || c->idle.oldest != SLOT_NONE;
}

/* A slot without a brick. */
static int take_slot(struct brick_cache *c, bool take_kept, uint32_t *out, struct brick_error *err)
{
    if (c->empty != SLOT_NONE) {
        *out = c->empty;
        c->empty = c->slots[*out].chain;
    } else if (c->slots_used < c->slots_max) {
        void *data = malloc(c->slot_bytes);
        if (!data)
            return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a brick of %zu bytes", c->slot_bytes);
        *out = c->slots_used++;
        c->slots[*out].data = data;
        c->counters.peak_bytes += c->slot_bytes;
    } else if (c->idle.oldest != SLOT_NONE || (take_kept && c->kept.oldest != SLOT_NONE)) {
        *out = c->idle.oldest != SLOT_NONE ? c->idle.oldest : c->kept.oldest;
        line_remove(c, *out);
        map_remove(c, *out);
        c->slots[*out].kept = false;
    } else {
        return brick_fail(err, BRICK_ERR_MEMORY,
                          "the host cache of %u bricks is in use entirely: enlarge --host-cache",
                          c->slots_max);
    }
    return BRICK_OK;
}

static int take_scratch(struct brick_cache *c, struct scratch **out, struct brick_error *err)
{
    *out = c->scratches;
    if (*out)
        c->scratches = (*out)->next;
    else if (!(*out = calloc(1, sizeof **out)))
        return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a thread that loads bricks");
    return BRICK_OK;
}

int slots_load(struct brick_cache *c, uint64_t id, bool take_kept, uint32_t *out, struct brick_error *err)
{
    struct scratch *scratch;
    int code = take_scratch(c, &scratch, err);
    if (code)
        return code;
    if (!(code = take_slot(c, take_kept, out, err))) {
        struct slot *slot = &c->slots[*out];
        slot->id = id;
        slot->pins = 1;
        slot->ready = false;
        map_add(c, *out);
        pthread_mutex_unlock(&c->lock);
        code = brick_volume_read(c->volume, id, slot->data, &scratch->memory, err);
        pthread_mutex_lock(&c->lock);
        if (code) {
            map_remove(c, *out);
            slot->chain = c->empty;
            c->empty = *out;
            if (c->has_loader)
                pthread_cond_signal(&c->work);
        } else {
            slot->ready = true;
            c->counters.loads++;
            c->counters.bytes_read += brick_volume_entry(c->volume, id)->bytes;
        }
        pthread_cond_broadcast(&c->loaded);
    }
    scratch->next = c->scratches;
    c->scratches = scratch;
    return code;
}
