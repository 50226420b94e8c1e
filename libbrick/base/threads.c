/* A fixed pool for data-parallel loops. Invariants: `next` counts items handed out; a run has ended when no
 * worker is inside it; with failures the lowest failing item's error is kept, whatever the timing: items are
 * handed out in ascending order, so every item below a failing one was started and its own failure is seen.
 */
#include <brick/threads.h>

#include <pthread.h>
#include <sched.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

/* The default, often 8 MiB, would count as address space where that is limited. */
#define STACK_BYTES ((size_t)1 << 20)

struct brick_pool {
    unsigned threads, started; /* workers, the caller included; threads really created */
    pthread_t *ids;
    pthread_mutex_t lock;
    pthread_cond_t wake, done;
    uint64_t generation; /* counts runs; a worker takes part in each once */
    bool quit;

    brick_pool_job *job;
    void *context;
    uint64_t n, next;
    unsigned busy;
    int code;
    uint64_t failed_item;
    struct brick_error error;
};

static void work(struct brick_pool *p, unsigned worker)
{
    pthread_mutex_lock(&p->lock);
    while (!p->code && p->next < p->n) {
        uint64_t item = p->next++;
        pthread_mutex_unlock(&p->lock);
        struct brick_error error = {0};
        int code = p->job(p->context, item, worker, &error);
        pthread_mutex_lock(&p->lock);
        if (code && (!p->code || item < p->failed_item)) {
            p->code = code;
            p->failed_item = item;
            p->error = error;
        }
    }
    pthread_mutex_unlock(&p->lock);
}

struct seat {
    struct brick_pool *pool;
    unsigned worker;
};

static void *worker_main(void *argument)
{
    struct seat seat = *(struct seat *)argument;
    free(argument);
    struct brick_pool *p = seat.pool;
    uint64_t seen = 0;
    pthread_mutex_lock(&p->lock);
    for (;;) {
        while (!p->quit && p->generation == seen)
            pthread_cond_wait(&p->wake, &p->lock);
        if (p->quit)
            break;
        seen = p->generation;
        pthread_mutex_unlock(&p->lock);
        work(p, seat.worker);
        pthread_mutex_lock(&p->lock);
        if (--p->busy == 0)
            pthread_cond_signal(&p->done);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

bool brick_thread_start(pthread_t *id, void *(*run)(void *context), void *context)
{
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes))
        return false;
    bool started = pthread_attr_setstacksize(&attributes, STACK_BYTES) == 0 &&
                   pthread_create(id, &attributes, run, context) == 0;
    pthread_attr_destroy(&attributes);
    return started;
}

int brick_pool_create(struct brick_pool **pool, unsigned threads, struct brick_error *err)
{
    *pool = NULL;
    if (threads == 0)
        threads = brick_cores();
    if (threads > 256)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%u threads are more than 256", threads);
    struct brick_pool *p = calloc(1, sizeof *p);
    pthread_t *ids = calloc(threads, sizeof *ids);
    if (!p || !ids) {
        free(p);
        free(ids);
        return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for %u threads", threads);
    }
    p->threads = threads;
    p->ids = ids;
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->wake, NULL);
    pthread_cond_init(&p->done, NULL);
    for (unsigned i = 1; i < threads; i++) {
        struct seat *seat = malloc(sizeof *seat);
        if (seat) {
            *seat = (struct seat){p, i};
            if (brick_thread_start(&p->ids[i - 1], worker_main, seat)) {
                p->started++;
                continue;
            }
            free(seat);
        }
        brick_pool_destroy(&p);
        return brick_fail(err, BRICK_ERR_MEMORY, "the system refuses to start %u threads", threads);
    }
    *pool = p;
    return BRICK_OK;
}

void brick_pool_destroy(struct brick_pool **pool)
{
    struct brick_pool *p = *pool;
    if (!p)
        return;
    pthread_mutex_lock(&p->lock);
    p->quit = true;
    pthread_cond_broadcast(&p->wake);
    pthread_mutex_unlock(&p->lock);
    for (unsigned i = 0; i < p->started; i++)
        pthread_join(p->ids[i], NULL);
    pthread_cond_destroy(&p->wake);
    pthread_cond_destroy(&p->done);
    pthread_mutex_destroy(&p->lock);
    free(p->ids);
    free(p);
    *pool = NULL;
}

unsigned brick_pool_threads(const struct brick_pool *pool)
{
    return pool->threads;
}

int brick_pool_run(struct brick_pool *p, uint64_t n, brick_pool_job *job, void *context,
                   struct brick_error *err)
{
    pthread_mutex_lock(&p->lock);
    p->job = job;
    p->context = context;
    p->n = n;
    p->next = 0;
    p->code = 0;
    bool alone = n <= 1;
    if (!alone) {
        p->busy = p->started;
        p->generation++;
        pthread_cond_broadcast(&p->wake);
    }
    pthread_mutex_unlock(&p->lock);

    work(p, 0);

    pthread_mutex_lock(&p->lock);
    while (p->busy)
        pthread_cond_wait(&p->done, &p->lock);
    int code = p->code;
    if (code && err)
        *err = p->error;
    pthread_mutex_unlock(&p->lock);
    return code;
}

unsigned brick_cores(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0) {
        int n = CPU_COUNT(&set);
        if (n > 0)
            return (unsigned)(n > 256 ? 256 : n);
    }
    return 1;
}

uint64_t brick_now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

uint64_t brick_thread_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

uint64_t brick_process_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

uint64_t brick_peak_rss_bytes(void)
{
    struct rusage usage;
    if (getrusage(RUSAGE_SELF, &usage))
        return 0;
    return (uint64_t)usage.ru_maxrss * 1024u;
}
