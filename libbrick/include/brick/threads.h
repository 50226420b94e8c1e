/* A pool of worker threads for data-parallel loops. The caller of brick_pool_run is one of the workers. */
#ifndef BRICK_THREADS_H
#define BRICK_THREADS_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

#include <brick/error.h>

#ifdef __cplusplus
extern "C" {
#endif

struct brick_pool;

/* threads: 1..256, or 0 for one a core. */
int brick_pool_create(struct brick_pool **pool, unsigned threads, struct brick_error *err);
void brick_pool_destroy(struct brick_pool **pool);
unsigned brick_pool_threads(const struct brick_pool *pool);

/* A job handles item i in [0,n); worker in [0, threads) names the thread's scratch space. Returns 0 or an
 * error, after which no new items are started. */
typedef int brick_pool_job(void *context, uint64_t item, unsigned worker, struct brick_error *err);

/* Run job for every item, in any order, and return when all have ended. With several failures the one of the
 * lowest item is reported, so that messages do not depend on timing. One caller at a time. */
int brick_pool_run(struct brick_pool *pool, uint64_t n, brick_pool_job *job, void *context,
                   struct brick_error *err);

/* One thread with a stack of 1 MiB (the pool's have that, too), to be joined with pthread_join. false:
 * refused. */
bool brick_thread_start(pthread_t *id, void *(*run)(void *context), void *context);

/* Cores this process may use, at least 1. */
unsigned brick_cores(void);
/* Monotonic time in nanoseconds. */
uint64_t brick_now_ns(void);
/* Time that the calling thread has spent on a core, in nanoseconds. */
uint64_t brick_thread_ns(void);
/* The same of all threads of this process. */
uint64_t brick_process_ns(void);
/* Peak resident set of this process in bytes (getrusage). */
uint64_t brick_peak_rss_bytes(void);

#ifdef __cplusplus
}
#endif
#endif
