/* The loader: wanted bricks from disk to pinned slots, in the order of need.
 *
 * Everything is under the cache's lock; only reading and decoding are not. Invariants: a wanted brick is in
 * exactly one place: the list `found` (in the cache, its slot kept, or being loaded by somebody else), the
 * list `missing`, or a flight. A flight is from the start of a load until its brick is taken, or dropped
 * because nobody wants it. A thread starts a load only when a flight is free and a slot can be had without
 * pushing out a brick that is pinned or kept; so whatever the cache's size, nothing wanted is read twice, and
 * a full cache makes threads wait.
 *
 * Each event that lets one more load start (a flight freed, a slot freed, a brick missing) signals one
 * thread, and the threads are equal, so no wake-up is lost. */
#include <brick/loader.h>

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <brick/threads.h>

#include "slots.h"

#define NO_REQUEST UINT32_MAX

struct request {
    uint64_t id;
    uint32_t next; /* in found or missing */
    bool flying;
};

/* What is wanted; a request's place in the array is its rank. */
struct wants {
    struct request *requests;
    uint32_t count;
    uint32_t *table, mask;   /* hash table of ranks, while the list is made */
    uint32_t found, missing; /* first of each list */
};

enum flight_state { FLIGHT_FREE = 0, FLIGHT_LOADING, FLIGHT_LOADED, FLIGHT_FAILED };

struct flight {
    enum flight_state state;
    bool wanted;
    uint64_t id;
    uint32_t rank, slot;
    int code;
    struct brick_error error;
};

struct brick_loader {
    struct brick_cache *cache;
    struct flight *flights;
    unsigned flights_max, flights_used;
    struct wants wants;
    pthread_t *ids;
    unsigned threads; /* started */
    bool quit;
    struct brick_loader_counters counters;
};

static void push(struct wants *w, uint32_t *list, uint32_t rank)
{
    w->requests[rank].next = *list;
    *list = rank;
}

/* Remove the request after `before`, or the first one. */
static uint32_t take_after(struct wants *w, uint32_t *list, uint32_t before)
{
    uint32_t *link = before == NO_REQUEST ? list : &w->requests[before].next, rank = *link;
    *link = w->requests[rank].next;
    return rank;
}

static void wants_finish(struct wants *w)
{
    free(w->requests);
    free(w->table);
    *w = (struct wants){.found = NO_REQUEST, .missing = NO_REQUEST};
}

/* Place of a brick in the hash table: its rank, or NO_REQUEST where it would go. */
static uint32_t *place_of(const struct wants *w, uint64_t id)
{
    uint32_t i = (uint32_t)((id * UINT64_C(0x9e3779b97f4a7c15)) >> 32) & w->mask;
    while (w->table[i] != NO_REQUEST && w->requests[w->table[i]].id != id)
        i = (i + 1) & w->mask;
    return &w->table[i];
}

/* The list without repetitions; a brick's first mention counts. */
static int wants_init(struct wants *w, const struct brick_grid *grid, const uint64_t *ids, size_t n,
                      struct brick_error *err)
{
    wants_finish(w);
    if (n == 0)
        return BRICK_OK;
    size_t places = 2;
    while (places < 2 * n && places < UINT32_MAX / 2)
        places *= 2;
    if (places >= 2 * n) {
        w->requests = malloc(n * sizeof *w->requests);
        w->table = malloc(places * sizeof *w->table);
    }
    if (!w->requests || !w->table) {
        wants_finish(w);
        return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a list of %zu wanted bricks", n);
    }
    w->mask = (uint32_t)(places - 1);
    memset(w->table, 0xff, places * sizeof *w->table);
    for (size_t i = 0; i < n; i++) {
        if (ids[i] >= grid->bricks) {
            wants_finish(w);
            return brick_fail_at(err, BRICK_ERR_ARGUMENT, BRICK_NO_OFFSET, ids[i],
                                 "brick %llu is wanted; the volume has %llu", (unsigned long long)ids[i],
                                 (unsigned long long)grid->bricks);
        }
        uint32_t *place = place_of(w, ids[i]);
        if (*place != NO_REQUEST)
            continue;
        *place = w->count;
        w->requests[w->count++] = (struct request){.id = ids[i]};
    }
    return BRICK_OK;
}

static void free_flight(struct brick_loader *l, struct flight *f)
{
    f->state = FLIGHT_FREE;
    l->flights_used--;
    pthread_cond_signal(&l->cache->work);
}

static void drop_flight(struct brick_loader *l, struct flight *f)
{
    f->wanted = false;
    if (f->state == FLIGHT_LOADED)
        slots_unpin(l->cache, f->slot);
    if (f->state != FLIGHT_LOADING) /* else its thread drops it */
        free_flight(l, f);
}

/* Bricks that were found need not be kept any longer. */
static void let_go(struct brick_loader *l)
{
    struct wants *w = &l->wants;
    for (uint32_t r = w->found; r != NO_REQUEST; r = w->requests[r].next) {
        uint32_t s = slots_find(l->cache, w->requests[r].id);
        if (s != SLOT_NONE && l->cache->slots[s].ready)
            slots_keep(l->cache, s, false);
    }
}

/* A request to the list it belongs to, in front. */
static void enlist(struct brick_loader *l, struct wants *w, uint32_t rank)
{
    uint32_t s = slots_find(l->cache, w->requests[rank].id);
    if (s != SLOT_NONE && l->cache->slots[s].ready)
        slots_keep(l->cache, s, true);
    push(w, s == SLOT_NONE ? &w->missing : &w->found, rank);
    if (s == SLOT_NONE)
        pthread_cond_signal(&l->cache->work);
}

int brick_loader_want(struct brick_loader *l, const uint64_t *ids, size_t n, struct brick_error *err)
{
    struct wants wants = {0}, before;
    int code = wants_init(&wants, brick_volume_grid(l->cache->volume), ids, n, err);
    if (code)
        return code;
    pthread_mutex_lock(&l->cache->lock);
    let_go(l);
    uint64_t cancelled = 0;
    for (uint32_t r = l->wants.found; r != NO_REQUEST; r = l->wants.requests[r].next)
        cancelled += !n || *place_of(&wants, l->wants.requests[r].id) == NO_REQUEST;
    for (uint32_t r = l->wants.missing; r != NO_REQUEST; r = l->wants.requests[r].next)
        cancelled += !n || *place_of(&wants, l->wants.requests[r].id) == NO_REQUEST;
    for (unsigned i = 0; i < l->flights_max; i++) {
        struct flight *f = &l->flights[i];
        if (f->state == FLIGHT_FREE)
            continue;
        uint32_t rank = n ? *place_of(&wants, f->id) : NO_REQUEST;
        if (rank == NO_REQUEST) {
            cancelled += f->wanted;
            drop_flight(l, f);
        } else {
            f->wanted = wants.requests[rank].flying = true;
            f->rank = rank;
        }
    }
    for (uint32_t r = wants.count;
         r-- > 0;) /* backwards: of what is found the most wanted counts as the latest used */
        if (!wants.requests[r].flying)
            enlist(l, &wants, r);
    free(wants.table);
    wants.table = NULL;
    l->counters.cancelled += cancelled;
    before = l->wants;
    l->wants = wants;
    pthread_cond_broadcast(&l->cache->loaded); /* takers have something else to wait for */
    pthread_mutex_unlock(&l->cache->lock);
    wants_finish(&before);
    return BRICK_OK;
}

static void load_one(struct brick_loader *l)
{
    struct wants *w = &l->wants;
    uint32_t rank = take_after(w, &w->missing, NO_REQUEST);
    uint64_t id = w->requests[rank].id;
    if (slots_find(l->cache, id) != SLOT_NONE) { /* somebody else loaded it, or is about to */
        enlist(l, w, rank);
        pthread_cond_broadcast(&l->cache->loaded);
        return;
    }
    struct flight *f = l->flights;
    while (f->state != FLIGHT_FREE)
        f++;
    f->state = FLIGHT_LOADING;
    f->wanted = true;
    f->id = id;
    f->rank = rank;
    if (++l->flights_used > l->counters.in_flight_peak)
        l->counters.in_flight_peak = l->flights_used;
    f->code =
        slots_load(l->cache, id, false, &f->slot, &f->error); /* unlocks: another list may be wanted now */
    f->state = f->code ? FLIGHT_FAILED : FLIGHT_LOADED;
    if (!f->wanted)
        drop_flight(l, f);
    pthread_cond_broadcast(&l->cache->loaded);
}

static void *thread_main(void *argument)
{
    struct brick_loader *l = argument;
    struct brick_cache *c = l->cache;
    pthread_mutex_lock(&c->lock);
    while (!l->quit)
        if (l->wants.missing != NO_REQUEST && l->flights_used < l->flights_max && slots_spare(c))
            load_one(l);
        else
            pthread_cond_wait(&c->work, &c->lock);
    pthread_mutex_unlock(&c->lock);
    return NULL;
}

/* The first found brick that is ready; those that have gone again are missing. */
static bool take_found(struct brick_loader *l, struct brick_taken *taken)
{
    struct wants *w = &l->wants;
    uint32_t before = NO_REQUEST, r = w->found;
    while (r != NO_REQUEST) {
        uint32_t next = w->requests[r].next, s = slots_find(l->cache, w->requests[r].id);
        if (s == SLOT_NONE) {
            take_after(w, &w->found, before);
            enlist(l, w, r);
        } else if (l->cache->slots[s].ready) {
            take_after(w, &w->found, before);
            slots_keep(l->cache, s, false);
            slots_pin(l->cache, s);
            *taken = (struct brick_taken){BRICK_TAKE_BRICK, w->requests[r].id, l->cache->slots[s].data};
            return true;
        } else {
            before = r;
        }
        r = next;
    }
    return false;
}

/* The most wanted of the flights that have ended. *open: are there others that will? */
static struct flight *arrived(struct brick_loader *l, bool *open)
{
    struct flight *best = NULL;
    *open = l->wants.found != NO_REQUEST || l->wants.missing != NO_REQUEST;
    for (unsigned i = 0; i < l->flights_max; i++) {
        struct flight *f = &l->flights[i];
        if (f->state == FLIGHT_LOADING)
            *open |= f->wanted;
        else if (f->state != FLIGHT_FREE && (!best || f->rank < best->rank))
            best = f;
    }
    return best;
}

static struct timespec deadline_after(uint64_t timeout_ns)
{
    uint64_t now = brick_now_ns(), at = timeout_ns < UINT64_MAX - now ? now + timeout_ns : UINT64_MAX;
    return (struct timespec){(time_t)(at / 1000000000u), (long)(at % 1000000000u)};
}

int brick_loader_take(struct brick_loader *l, uint64_t timeout_ns, struct brick_taken *taken,
                      struct brick_error *err)
{
    struct brick_cache *c = l->cache;
    const struct timespec deadline = deadline_after(timeout_ns);
    bool late = timeout_ns == 0, open;
    int code = BRICK_OK;
    *taken = (struct brick_taken){BRICK_TAKE_LATER, BRICK_NO_BRICK, NULL};
    pthread_mutex_lock(&c->lock);
    while (!take_found(l, taken)) {
        struct flight *f = arrived(l, &open);
        if (f) {
            code = f->code;
            taken->id = f->id;
            if (code) {
                if (err)
                    *err = f->error;
            } else {
                taken->what = BRICK_TAKE_BRICK;
                taken->data = c->slots[f->slot].data;
            }
            free_flight(l, f);
            break;
        }
        if (!open)
            taken->what = BRICK_TAKE_DONE;
        if (!open || late)
            break;
        if (timeout_ns == UINT64_MAX)
            pthread_cond_wait(&c->loaded, &c->lock);
        else
            late = pthread_cond_timedwait(&c->loaded, &c->lock, &deadline) != 0;
    }
    pthread_mutex_unlock(&c->lock);
    return code;
}

void brick_loader_count(struct brick_loader *l, struct brick_loader_counters *counters)
{
    pthread_mutex_lock(&l->cache->lock);
    *counters = l->counters;
    pthread_mutex_unlock(&l->cache->lock);
}

/* The loader of a cache, or no longer; false if it has another. */
static bool attach(struct brick_cache *c, bool on)
{
    pthread_mutex_lock(&c->lock);
    bool changed = c->has_loader != on;
    c->has_loader = on;
    pthread_mutex_unlock(&c->lock);
    return changed;
}

int brick_loader_create(struct brick_loader **loader, struct brick_cache *cache, unsigned threads,
                        unsigned in_flight_max, struct brick_error *err)
{
    *loader = NULL;
    if (threads == 0)
        threads = brick_cores();
    if (threads > 256 || in_flight_max > 4096)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%u threads, %u bricks in flight: at most 256 and 4096",
                          threads, in_flight_max);
    if (in_flight_max == 0)
        in_flight_max = 4 * threads;
    if (threads > in_flight_max)
        threads = in_flight_max;
    struct brick_loader *l = calloc(1, sizeof *l);
    if (l) {
        l->flights = calloc(in_flight_max, sizeof *l->flights);
        l->ids = calloc(threads, sizeof *l->ids);
    }
    if (!l || !l->flights || !l->ids || !attach(cache, true)) {
        int code =
            !l || !l->flights || !l->ids
                ? brick_fail(err, BRICK_ERR_MEMORY, "out of memory for %u bricks in flight", in_flight_max)
                : brick_fail(err, BRICK_ERR_ARGUMENT, "the host cache has a loader already");
        if (l) {
            free(l->flights);
            free(l->ids);
        }
        free(l);
        return code;
    }
    l->cache = cache;
    l->flights_max = in_flight_max;
    wants_finish(&l->wants);
    while (l->threads < threads && pthread_create(&l->ids[l->threads], NULL, thread_main, l) == 0)
        l->threads++;
    if (l->threads < threads) {
        brick_loader_destroy(&l);
        return brick_fail(err, BRICK_ERR_MEMORY, "the system refuses to start %u threads", threads);
    }
    *loader = l;
    return BRICK_OK;
}

void brick_loader_destroy(struct brick_loader **loader)
{
    struct brick_loader *l = *loader;
    if (!l)
        return;
    pthread_mutex_lock(&l->cache->lock);
    l->quit = true;
    pthread_cond_broadcast(&l->cache->work);
    pthread_mutex_unlock(&l->cache->lock);
    for (unsigned i = 0; i < l->threads; i++)
        pthread_join(l->ids[i], NULL);
    pthread_mutex_lock(&l->cache->lock);
    let_go(l);
    for (unsigned i = 0; i < l->flights_max; i++)
        if (l->flights[i].state != FLIGHT_FREE)
            drop_flight(l, &l->flights[i]);
    pthread_mutex_unlock(&l->cache->lock);
    attach(l->cache, false);
    wants_finish(&l->wants);
    free(l->flights);
    free(l->ids);
    free(l);
    *loader = NULL;
}
