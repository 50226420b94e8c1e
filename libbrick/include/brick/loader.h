/* Threads that load wanted bricks into a host cache, most wanted first.
 *
 * The caller says what it wants (brick_loader_want) and takes bricks as they come (brick_loader_take). For
 * one list of wants each brick is read from disk at most once, and not at all if it was in the cache, however
 * small the cache: what is loaded or found stays until it is taken or no longer wanted. (Another user of the
 * cache who pins everything else may push out what was found.) Which bricks come first depends on timing;
 * which are read does not.
 *
 * Loading never fails for lack of room: with every slot pinned it waits for brick_cache_unpin. */
#ifndef BRICK_LOADER_H
#define BRICK_LOADER_H

#include <stddef.h>
#include <stdint.h>

#include <brick/cache.h>

#ifdef __cplusplus
extern "C" {
#endif

struct brick_loader;

/* threads: 1..256, 0 for one a core. in_flight_max: bricks being loaded or loaded and not yet taken, 1..4096;
 * 0 for four a thread. A cache has one loader at a time (BRICK_ERR_ARGUMENT) and outlives it; brick_cache_pin
 * works beside it. */
int brick_loader_create(struct brick_loader **loader, struct brick_cache *cache, unsigned threads,
                        unsigned in_flight_max, struct brick_error *err);
/* Waits for reads under way; what was not taken is unpinned, what was taken stays pinned. */
void brick_loader_destroy(struct brick_loader **loader);

/* Replace the list of wanted bricks, most wanted first; n may be 0, and a brick may be named twice. What is
 * no longer wanted is cancelled: not started, unpinned if loaded, its error forgotten. A brick that was taken
 * before may be wanted again. BRICK_ERR_ARGUMENT for a number that is no brick's, BRICK_ERR_MEMORY: the list
 * before stays. */
int brick_loader_want(struct brick_loader *loader, const uint64_t *ids, size_t n, struct brick_error *err);

enum brick_take {
    BRICK_TAKE_BRICK,
    BRICK_TAKE_LATER, /* nothing within the time given */
    BRICK_TAKE_DONE   /* all that was wanted has been taken or reported */
};

struct brick_taken {
    enum brick_take what;
    uint64_t id;      /* BRICK_TAKE_BRICK, and after an error the brick it belongs to; else BRICK_NO_BRICK */
    const void *data; /* layout of brick_volume_read; pinned: the caller calls brick_cache_unpin */
};

/* The next brick: one that was in the cache, else the most wanted of those loaded. Waits up to timeout_ns (0:
 * not at all, UINT64_MAX: for ever; with all slots pinned by the caller nothing comes until it unpins one).
 * An error of a wanted brick (BRICK_ERR_IO, _FORMAT, _CHECKSUM, _MEMORY) is returned once and ends that
 * request; others go on. */
int brick_loader_take(struct brick_loader *loader, uint64_t timeout_ns, struct brick_taken *taken,
                      struct brick_error *err);

struct brick_loader_counters {
    uint64_t in_flight_peak;
    uint64_t cancelled; /* wanted, then not, before they were taken */
};
void brick_loader_count(struct brick_loader *loader, struct brick_loader_counters *counters);

#ifdef __cplusplus
}
#endif
#endif
