/* The host brick cache: decoded bricks in memory within a byte budget, least recently used out first.
 * Safe from several threads. A pinned brick stays; one that two threads want is loaded once; reading and
 * decoding run in parallel. */
#ifndef BRICK_CACHE_H
#define BRICK_CACHE_H

#include <brick/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

struct brick_cache;

/* budget_bytes must hold at least one brick for each thread that pins (BRICK_ERR_ARGUMENT below one brick).
 * Decoded bricks never exceed it; beside them each thread that loads needs room for one encoded brick. */
int brick_cache_create(struct brick_cache **cache, const struct brick_volume *volume, uint64_t budget_bytes,
                       struct brick_error *err);
/* Nobody uses it any more. */
void brick_cache_destroy(struct brick_cache **cache);
/* Bricks that the budget holds; no more than the volume has. */
uint64_t brick_cache_slots(const struct brick_cache *cache);

/* Decoded brick (layout of brick_volume_read), valid until unpinned. BRICK_ERR_MEMORY when every slot is
 * pinned; errors of reading name the brick, which is then as if never asked for. */
int brick_cache_pin(struct brick_cache *cache, uint64_t id, const void **data, struct brick_error *err);
void brick_cache_unpin(struct brick_cache *cache, uint64_t id);

struct brick_cache_counters {
    uint64_t loads, hits, bytes_read,
        peak_bytes; /* since creation; bytes_read as stored, peak_bytes decoded */
};
void brick_cache_count(struct brick_cache *cache, struct brick_cache_counters *counters);

#ifdef __cplusplus
}
#endif
#endif
