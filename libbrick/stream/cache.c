/* The host cache. Invariants, under the lock: a slot is in the map from the moment its load starts; a slot is
 * in the LRU list iff it is loaded and not pinned; memory of slots never exceeds the budget, and is taken
 * only when first needed. */
#include <brick/cache.h>

#include <pthread.h>
#include <stdlib.h>

#define NONE UINT32_MAX

struct slot {
    void *data;
    uint64_t id;
    uint32_t pins;
    uint32_t chain;        /* next slot in the same bucket */
    uint32_t newer, older; /* LRU neighbours */
    bool ready;            /* false while its load is under way */
};

struct brick_cache {
    const struct brick_volume *volume;
    size_t slot_bytes;
    uint32_t slots_max, slots_used; /* used: have memory */
    struct slot *slots;
    uint32_t *buckets, bucket_mask;
    uint32_t newest, oldest, free; /* LRU ends; chain of empty slots */
    pthread_mutex_t lock;
    pthread_cond_t loaded;
    struct brick_cache_counters counters;
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
        c->buckets[i] = NONE;
    c->newest = c->oldest = c->free = NONE;
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->loaded, NULL);
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
    pthread_mutex_destroy(&c->lock);
    pthread_cond_destroy(&c->loaded);
    free(c->slots);
    free(c->buckets);
    free(c);
    *cache = NULL;
}

static uint32_t *bucket_of(struct brick_cache *c, uint64_t id)
{
    return &c->buckets[(id * UINT64_C(0x9e3779b97f4a7c15)) >> 32 & c->bucket_mask];
}

static uint32_t map_find(struct brick_cache *c, uint64_t id)
{
    uint32_t s = *bucket_of(c, id);
    while (s != NONE && c->slots[s].id != id)
        s = c->slots[s].chain;
    return s;
}

static void map_remove(struct brick_cache *c, uint32_t s)
{
    uint32_t *link = bucket_of(c, c->slots[s].id);
    while (*link != s)
        link = &c->slots[*link].chain;
    *link = c->slots[s].chain;
}

static void lru_remove(struct brick_cache *c, uint32_t s)
{
    struct slot *slot = &c->slots[s];
    *(slot->newer == NONE ? &c->newest : &c->slots[slot->newer].older) = slot->older;
    *(slot->older == NONE ? &c->oldest : &c->slots[slot->older].newer) = slot->newer;
}

static void lru_add(struct brick_cache *c, uint32_t s)
{
    struct slot *slot = &c->slots[s];
    slot->newer = NONE;
    slot->older = c->newest;
    *(c->newest == NONE ? &c->oldest : &c->slots[c->newest].newer) = s;
    c->newest = s;
}

/* A slot without a brick: an empty one, a new one, or the least recently used. NONE when all are pinned. */
static int take_slot(struct brick_cache *c, uint32_t *out, struct brick_error *err)
{
    if (c->free != NONE) {
        *out = c->free;
        c->free = c->slots[*out].chain;
    } else if (c->slots_used < c->slots_max) {
        void *data = malloc(c->slot_bytes);
        if (!data)
            return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a brick of %zu bytes", c->slot_bytes);
        *out = c->slots_used++;
        c->slots[*out].data = data;
        c->counters.peak_bytes += c->slot_bytes;
    } else if (c->oldest != NONE) {
        *out = c->oldest;
        lru_remove(c, *out);
        map_remove(c, *out);
    } else {
        return brick_fail(err, BRICK_ERR_MEMORY,
                          "the host cache of %u bricks is in use entirely: enlarge --host-cache",
                          c->slots_max);
    }
    return BRICK_OK;
}

int brick_cache_pin(struct brick_cache *c, uint64_t id, const void **data, struct brick_error *err)
{
    pthread_mutex_lock(&c->lock);
    uint32_t s;
    while ((s = map_find(c, id)) != NONE && !c->slots[s].ready)
        pthread_cond_wait(&c->loaded, &c->lock);
    if (s != NONE) {
        if (c->slots[s].pins++ == 0)
            lru_remove(c, s);
        c->counters.hits++;
        *data = c->slots[s].data;
        pthread_mutex_unlock(&c->lock);
        return BRICK_OK;
    }
    int code = take_slot(c, &s, err);
    if (code) {
        pthread_mutex_unlock(&c->lock);
        return code;
    }
    struct slot *slot = &c->slots[s];
    slot->id = id;
    slot->pins = 1;
    slot->ready = false;
    slot->chain = *bucket_of(c, id);
    *bucket_of(c, id) = s;
    pthread_mutex_unlock(&c->lock);

    struct brick_scratch scratch = {0};
    code = brick_volume_read(c->volume, id, slot->data, &scratch, err);
    brick_scratch_finish(&scratch);

    pthread_mutex_lock(&c->lock);
    if (code) {
        map_remove(c, s);
        slot->chain = c->free;
        c->free = s;
    } else {
        slot->ready = true;
        c->counters.loads++;
        c->counters.bytes_read += brick_volume_entry(c->volume, id)->bytes;
        *data = slot->data;
    }
    pthread_cond_broadcast(&c->loaded);
    pthread_mutex_unlock(&c->lock);
    return code;
}

void brick_cache_unpin(struct brick_cache *c, uint64_t id)
{
    pthread_mutex_lock(&c->lock);
    uint32_t s = map_find(c, id);
    if (s != NONE && c->slots[s].pins && --c->slots[s].pins == 0)
        lru_add(c, s);
    pthread_mutex_unlock(&c->lock);
}

void brick_cache_count(struct brick_cache *c, struct brick_cache_counters *counters)
{
    pthread_mutex_lock(&c->lock);
    *counters = c->counters;
    pthread_mutex_unlock(&c->lock);
}
