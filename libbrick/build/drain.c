/* Invariants: slot t % slots belongs to ticket t from the moment t - slots is written; its `ready` says t + 1
 * when ticket t waits in it. What depends on the order of bricks (statistics of f32) is merged here, in that
 * order. */
#include "drain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int drain_init(struct drain *d, uint64_t slots, size_t payload_bytes, struct brick_error *err)
{
    *d = (struct drain){.min = INFINITY, .max = -INFINITY};
    pthread_mutex_init(&d->lock, NULL);
    pthread_cond_init(&d->filled, NULL);
    pthread_cond_init(&d->freed, NULL);
    d->slots = slots;
    d->slot = calloc(slots, sizeof *d->slot);
    bool all = d->slot != NULL;
    for (uint64_t i = 0; all && i < slots; i++)
        all = (d->slot[i].payload = malloc(payload_bytes)) != NULL;
    return all ? BRICK_OK : brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a queue of bricks");
}

static int write_one(struct drain *d, const struct encoded *e, struct brick_error *err)
{
    uint64_t start = brick_now_ns();
    if (e->level0) {
        tally_merge_moments(&d->moments, &e->moments);
        d->min = fmin(d->min, (double)e->entry.min);
        d->max = fmax(d->max, (double)e->entry.max);
    }
    if (e->written)
        return BRICK_OK;
    int code = brick_writer_put(d->writer, e->id, &e->entry, e->bytes ? e->payload : NULL, e->bytes, err);
    d->cost.ns += brick_now_ns() - start;
    d->cost.bytes += e->bytes;
    return code;
}

/* Bricks that wait in a row are written without looking up in between: on few cores, threads that wake each
 * other for every brick spend their time on that. */
static void *drain_main(void *context)
{
    struct drain *d = context;
    pthread_mutex_lock(&d->lock);
    while (!d->code && !d->quit) {
        uint64_t end = d->written;
        while (end < d->written + d->slots && d->slot[end % d->slots].ready == end + 1)
            end++;
        if (end == d->written) {
            pthread_cond_wait(&d->filled, &d->lock);
            continue;
        }
        uint64_t next = d->written;
        struct brick_error error = {0};
        int code = BRICK_OK;
        pthread_mutex_unlock(&d->lock);
        for (; !code && next < end; next++)
            code = write_one(d, &d->slot[next % d->slots], &error);
        pthread_mutex_lock(&d->lock);
        d->code = code;
        d->error = error;
        d->written = code ? next - 1 : next;
        pthread_cond_broadcast(&d->freed);
    }
    pthread_mutex_unlock(&d->lock);
    return NULL;
}

int drain_start(struct drain *d, struct brick_writer *writer, struct brick_error *err)
{
    d->writer = writer;
    d->running = brick_thread_start(&d->thread, drain_main, d);
    return d->running ? BRICK_OK
                      : brick_fail(err, BRICK_ERR_MEMORY, "the system refuses to start a thread for writing");
}

void drain_finish(struct drain *d)
{
    if (!d->slots)
        return;
    pthread_mutex_lock(&d->lock);
    d->quit = true;
    pthread_cond_signal(&d->filled);
    pthread_mutex_unlock(&d->lock);
    if (d->running)
        pthread_join(d->thread, NULL);
    pthread_cond_destroy(&d->filled);
    pthread_cond_destroy(&d->freed);
    pthread_mutex_destroy(&d->lock);
    for (uint64_t i = 0; d->slot && i < d->slots; i++)
        free(d->slot[i].payload);
    free(d->slot);
    memset(d, 0, sizeof *d);
}

struct encoded *drain_slot(struct drain *d, uint64_t ticket)
{
    pthread_mutex_lock(&d->lock);
    while (!d->code && ticket >= d->written + d->slots)
        pthread_cond_wait(&d->freed, &d->lock);
    bool failed = d->code != 0;
    pthread_mutex_unlock(&d->lock);
    return failed ? NULL : &d->slot[ticket % d->slots];
}

void drain_ready(struct drain *d, uint64_t ticket)
{
    pthread_mutex_lock(&d->lock);
    d->slot[ticket % d->slots].ready = ticket + 1;
    if (ticket == d->written)
        pthread_cond_signal(&d->filled);
    pthread_mutex_unlock(&d->lock);
}

int drain_flush(struct drain *d, uint64_t end, struct brick_error *err)
{
    pthread_mutex_lock(&d->lock);
    while (!d->code && d->written < end)
        pthread_cond_wait(&d->freed, &d->lock);
    int code = d->code;
    if (code && err)
        *err = d->error;
    pthread_mutex_unlock(&d->lock);
    return code;
}
