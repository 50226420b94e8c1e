/* Encoded bricks on their way out: a thread of its own writes them in the order of their tickets, whatever
 * the order in which they become ready. */
#ifndef BRICK_BUILD_DRAIN_H
#define BRICK_BUILD_DRAIN_H

#include <pthread.h>
#include <stdbool.h>

#include <brick/writer.h>

#include "encode.h"

struct drain {
    struct brick_writer *writer; /* the caller's */
    struct encoded *slot;
    uint64_t slots;

    pthread_t thread;
    bool running;
    pthread_mutex_t lock;
    pthread_cond_t filled, freed; /* waited for by the thread; by the others */
    /* Under the lock. */
    uint64_t written; /* tickets [0, written) are */
    bool quit;
    int code;
    struct brick_error error;

    /* The thread's own, the caller's once it has flushed. Level 0's, in the order of its bricks. */
    struct tally_moments moments;
    double min, max;
    struct brick_build_cost cost;
};

/* payload_bytes: room of one slot. */
int drain_init(struct drain *drain, uint64_t slots, size_t payload_bytes, struct brick_error *err);
int drain_start(struct drain *drain, struct brick_writer *writer, struct brick_error *err);
/* Stops writing where it is. */
void drain_finish(struct drain *drain);

/* The slot for a ticket (counted from 0), once it is free. Tickets must be asked for in ascending order by
 * and large: whoever waits here relies on all lower ones becoming ready. NULL: writing has failed. */
struct encoded *drain_slot(struct drain *drain, uint64_t ticket);
/* The slot is filled. */
void drain_ready(struct drain *drain, uint64_t ticket);
/* Wait until tickets [0, end) are written. */
int drain_flush(struct drain *drain, uint64_t end, struct brick_error *err);

#endif
