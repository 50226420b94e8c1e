/* The host cache as callers see it: pin, use, unpin. A thread that wants a brick which another one is loading
 * waits for that load; what it then finds decides, for the load may have failed. */
#include <brick/cache.h>

#include "slots.h"

int brick_cache_pin(struct brick_cache *c, uint64_t id, const void **data, struct brick_error *err)
{
    uint32_t s;
    int code = BRICK_OK;
    pthread_mutex_lock(&c->lock);
    while ((s = slots_find(c, id)) != SLOT_NONE && !c->slots[s].ready)
        pthread_cond_wait(&c->loaded, &c->lock);
    if (s != SLOT_NONE)
        slots_pin(c, s);
    else
        code = slots_load(c, id, true, &s, err);
    if (!code)
        *data = c->slots[s].data;
    pthread_mutex_unlock(&c->lock);
    return code;
}

void brick_cache_unpin(struct brick_cache *c, uint64_t id)
{
    pthread_mutex_lock(&c->lock);
    uint32_t s = slots_find(c, id);
    if (s != SLOT_NONE && c->slots[s].ready && c->slots[s].pins)
        slots_unpin(c, s);
    pthread_mutex_unlock(&c->lock);
}

void brick_cache_count(struct brick_cache *c, struct brick_cache_counters *counters)
{
    pthread_mutex_lock(&c->lock);
    *counters = c->counters;
    pthread_mutex_unlock(&c->lock);
}

uint64_t brick_cache_slots(const struct brick_cache *c)
{
    return c->slots_max;
}
