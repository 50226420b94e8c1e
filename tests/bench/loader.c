/* How loading scales with threads: bricks a second through the loader against a bare loop of
 * brick_volume_read in one thread, the file in the page cache. The caller only unpins, so that loading is all
 * there is to wait for. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <brick/loader.h>
#include <brick/threads.h>

#include "../support/memory_source.h"

enum { N = 320, SLOTS = 64, REPEATS = 15 };

struct rate {
    double per_second, cpu_us;
};

static struct rate rate_since(uint64_t started_ns, clock_t cpu, uint64_t n)
{
    return (struct rate){(double)n / ((double)(brick_now_ns() - started_ns) * 1e-9),
                         (double)(clock() - cpu) * (1e6 / CLOCKS_PER_SEC) / (double)n};
}

static void keep_best(struct rate *best, struct rate r)
{
    best->per_second = r.per_second > best->per_second ? r.per_second : best->per_second;
    best->cpu_us = best->cpu_us > 0.0 && best->cpu_us < r.cpu_us ? best->cpu_us : r.cpu_us;
}

static void fail(const struct brick_error *err)
{
    fprintf(stderr, "%s\n", err->message);
    exit(1);
}

/* Smooth with a little noise, as scans are. */
static struct brick_volume *make_volume(void)
{
    uint16_t *voxels = malloc((size_t)N * N * N * sizeof *voxels);
    for (size_t i = 0; i < (size_t)N * N * N; i++) {
        size_t x = i % N, y = i / N % N, z = i / N / N;
        voxels[i] = (uint16_t)((x * x + y * y + z * z) / 8 + noise64(1, i) % 16);
    }
    struct memory_source source;
    memory_source_init(&source, BRICK_U16, N, N, N, voxels);
    struct brick_volume *v = build_and_open(&source, "bench.brick", NULL);
    free(voxels);
    return v;
}

/* Into as much memory as the cache has, touched before. */
static struct rate read_bare(const struct brick_volume *v, uint64_t n)
{
    struct brick_error err;
    struct brick_scratch scratch = {0};
    size_t bytes = brick_grid_max_payload_bytes(brick_volume_grid(v));
    unsigned char *payloads = malloc(SLOTS * bytes);
    uint64_t started = 0;
    clock_t cpu = 0;
    for (uint64_t i = 0; i < SLOTS + n; i++) {
        if (i == SLOTS)
            started = brick_now_ns(), cpu = clock();
        if (brick_volume_read(v, i % n, payloads + i % SLOTS * bytes, &scratch, &err))
            fail(&err);
    }
    struct rate rate = rate_since(started, cpu, n);
    brick_scratch_finish(&scratch);
    free(payloads);
    return rate;
}

static struct rate load(const struct brick_volume *v, const uint64_t *ids, uint64_t n, unsigned threads)
{
    struct brick_error err;
    struct brick_cache *cache;
    struct brick_loader *loader;
    struct brick_taken t;
    if (brick_cache_create(&cache, v, SLOTS * brick_grid_max_payload_bytes(brick_volume_grid(v)), &err) ||
        brick_loader_create(&loader, cache, threads, 0, &err))
        fail(&err);
    /* Once for the memory of the slots, which is touched first here. */
    struct rate rate = {0};
    for (int round = 0; round < 2; round++) {
        uint64_t started = brick_now_ns();
        clock_t cpu = clock();
        if (brick_loader_want(loader, ids + (uint64_t)round * n, n, &err))
            fail(&err);
        for (;;) {
            if (brick_loader_take(loader, UINT64_MAX, &t, &err))
                fail(&err);
            if (t.what == BRICK_TAKE_DONE)
                break;
            brick_cache_unpin(cache, t.id);
        }
        rate = rate_since(started, cpu, n);
    }
    brick_loader_destroy(&loader);
    brick_cache_destroy(&cache);
    return rate;
}

int main(void)
{
    struct brick_volume *v = make_volume();
    const uint64_t n = brick_volume_grid(v)->level[1].first_brick / 2; /* the other half warms the slots */
    uint64_t *ids = malloc(2 * n * sizeof *ids);
    for (uint64_t i = 0; i < 2 * n; i++)
        ids[i] = i < n ? n + i : i - n;
    printf("%llu bricks of %zu bytes, %u cores\n", (unsigned long long)n,
           brick_grid_max_payload_bytes(brick_volume_grid(v)), brick_cores());
    /* A noisy machine: the best of several runs in turn, and processor time, which others do not change as
     * much. */
    printf("%8s %12s %8s %14s\n", "threads", "bricks/s", "/ bare", "cpu us a brick");
    struct rate bare = {0}, with[4] = {{0}};
    for (int repeat = 0; repeat < REPEATS; repeat++) {
        keep_best(&bare, read_bare(v, n));
        for (unsigned k = 0; k < 4; k++)
            keep_best(&with[k], load(v, ids, n, 1u << k));
    }
    printf("%8s %12.0f %8.2f %14.1f\n", "bare", bare.per_second, 1.0, bare.cpu_us);
    for (unsigned k = 0; k < 4; k++)
        printf("%8u %12.0f %8.2f %14.1f\n", 1u << k, with[k].per_second, with[k].per_second / bare.per_second,
               with[k].cpu_us);
    free(ids);
    brick_volume_close(&v);
    return 0;
}
