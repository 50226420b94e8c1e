/* Level 0 on its way in: a thread of its own reads ahead of the encoding, as far as the plan has room. */
#ifndef BRICK_BUILD_FEED_H
#define BRICK_BUILD_FEED_H

#include <pthread.h>

#include "plan.h"
#include "window.h"

struct feed {
    struct brick_source *source;
    const struct brick_grid *grid;
    const struct plan *plan;
    bool round_to_f32;
    struct window window[2]; /* a ring uses the first, boxes take turns */
    void *staging;
    struct tile first;
    uint64_t fetched; /* slices that the source was told of; the reading thread's */

    pthread_t thread;
    bool running;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    /* Under the lock. Of a ring: slices read, and the first still in use; of boxes: tiles. */
    uint64_t read, released;
    bool quit;
    int code;
    struct brick_error error;
    struct brick_build_cost cost;

    uint64_t taken;   /* the consumer's */
    uint64_t wait_ns; /* time it waited for input */
};

int feed_init(struct feed *feed, struct brick_source *source, const struct brick_grid *grid,
              const struct plan *plan, bool round_to_f32, struct brick_error *err);
/* Begin reading with what this tile needs. */
int feed_start(struct feed *feed, const struct tile *first, struct brick_error *err);
/* Before that: memory for a tile's core, for the caller to fill. */
const struct window *feed_lend(struct feed *feed, const struct tile *tile);
/* Stops reading where it is. */
void feed_finish(struct feed *feed);

/* The window that holds a level-0 tile, once it is read. Tiles are asked for in order, each released before
 * the next is asked for. The failure of the first slice or tile that failed. */
int feed_take(struct feed *feed, const struct tile *tile, const struct window **window,
              struct brick_error *err);
void feed_release(struct feed *feed, const struct tile *tile, bool last_of_row);

#endif
