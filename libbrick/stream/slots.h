/* The slots of a host cache: who has memory, which brick is where, which goes next. Private to the cache and
 * its loader. All functions are called with `lock` held. */
#ifndef STREAM_SLOTS_H
#define STREAM_SLOTS_H

#include <pthread.h>

#include <brick/cache.h>

#define SLOT_NONE UINT32_MAX

struct slot {
    void *data;
    uint64_t id;
    uint32_t pins;
    uint32_t chain;        /* next slot in the same bucket, or the next empty one */
    uint32_t newer, older; /* neighbours in idle or kept */
    bool ready;            /* false while its load is under way */
    bool kept;             /* the loader owes it to its caller */
};

struct slot_line { /* by last use */
    uint32_t newest, oldest;
};

struct brick_cache {
    const struct brick_volume *volume;
    size_t slot_bytes;
    uint32_t slots_max, slots_used; /* used: have memory */
    struct slot *slots;
    uint32_t *buckets, bucket_mask;
    uint32_t empty; /* chain of slots with memory and no brick */
    struct slot_line idle, kept;
    pthread_mutex_t lock;
    pthread_cond_t loaded; /* a load has ended, well or not; what a taker waits for has changed */
    pthread_cond_t work;   /* one more thing that a loader's thread may wait for; only they wait here */
    bool has_loader;
    struct scratch *scratches; /* of threads that load; idle ones */
    struct brick_cache_counters counters;
};

/* SLOT_NONE when the brick is neither loaded nor on its way. */
uint32_t slots_find(struct brick_cache *c, uint64_t id);
/* Could slots_load have a slot without taking a kept brick's? */
bool slots_spare(const struct brick_cache *c);
/* Load a brick that slots_find does not find, pinned once. Takes an empty slot, a new one, the brick idle
 * longest, and only if allowed a kept one. The lock is released while reading and decoding. BRICK_ERR_MEMORY:
 * every slot is in use; errors of reading. */
int slots_load(struct brick_cache *c, uint64_t id, bool take_kept, uint32_t *slot, struct brick_error *err);
/* The slot is ready. Counts a hit. */
void slots_pin(struct brick_cache *c, uint32_t s);
/* The slot is ready and pinned. */
void slots_unpin(struct brick_cache *c, uint32_t s);
/* Kept bricks make room last. The slot is ready. */
void slots_keep(struct brick_cache *c, uint32_t s, bool keep);

#endif
