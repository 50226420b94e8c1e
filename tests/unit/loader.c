/* The loader: what is wanted comes, once, whatever the size of the cache; what is no longer wanted does not;
 * errors name their brick; nothing hangs. Also run under the thread and address sanitizers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <dirent.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <brick/loader.h>
#include <brick/threads.h>

#include "../support/memory_source.h"

enum { N = 48, EDGE = 8 };
static const uint64_t patience_ns = UINT64_C(60000000000); /* longer than any load: what takes it hangs */

/* Noise, so that no brick is constant and none like another. */
static struct brick_volume *make_volume(void)
{
    static uint16_t voxels[N * N * N];
    for (size_t i = 0; i < N * N * N; i++)
        voxels[i] = (uint16_t)noise64(5, i);
    struct memory_source source;
    memory_source_init(&source, BRICK_U16, N, N, N, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.edge = EDGE;
    return build_and_open(&source, "loader.brick", &params);
}

static struct brick_cache *make_cache(const struct brick_volume *v, uint64_t slots)
{
    struct brick_cache *cache;
    struct brick_error err;
    if (brick_cache_create(&cache, v, slots * brick_grid_max_payload_bytes(brick_volume_grid(v)), &err))
        fail_msg("%s", err.message);
    return cache;
}

static struct brick_loader *make_loader(struct brick_cache *cache, unsigned threads, unsigned in_flight)
{
    struct brick_loader *loader;
    struct brick_error err;
    if (brick_loader_create(&loader, cache, threads, in_flight, &err))
        fail_msg("%s", err.message);
    return loader;
}

static void want(struct brick_loader *loader, const uint64_t *ids, size_t n)
{
    struct brick_error err;
    if (brick_loader_want(loader, ids, n, &err))
        fail_msg("%s", err.message);
}

static struct brick_taken take(struct brick_loader *loader)
{
    struct brick_taken taken;
    struct brick_error err;
    if (brick_loader_take(loader, patience_ns, &taken, &err))
        fail_msg("%s", err.message);
    assert_int_not_equal(taken.what, BRICK_TAKE_LATER);
    return taken;
}

/* Is that the brick? */
static bool right(const struct brick_volume *v, uint64_t id, const void *data)
{
    static _Thread_local unsigned char own[(EDGE + 4) * (EDGE + 4) * (EDGE + 4) * 2 + 4096];
    struct brick_place place;
    struct brick_scratch scratch = {0};
    struct brick_error err;
    brick_grid_place(brick_volume_grid(v), id, &place);
    int code = brick_volume_read(v, id, own, &scratch, &err);
    brick_scratch_finish(&scratch);
    return !code && !memcmp(own, data, brick_place_payload_bytes(brick_volume_grid(v), &place));
}

static uint64_t loads(struct brick_cache *cache)
{
    struct brick_cache_counters c;
    brick_cache_count(cache, &c);
    return c.loads;
}

/* Nothing is left pinned: the caller can have every slot. */
static void nothing_is_pinned(const struct brick_volume *v, struct brick_cache *cache)
{
    struct brick_error err;
    const void *data;
    (void)v;
    for (uint64_t id = 0; id < brick_cache_slots(cache); id++)
        if (brick_cache_pin(cache, id, &data, &err))
            fail_msg("%s", err.message);
    for (uint64_t id = 0; id < brick_cache_slots(cache); id++)
        brick_cache_unpin(cache, id);
}

/* Take everything, holding `hold` bricks pinned; each must be wanted, and come once. */
static void take_all(const struct brick_volume *v, struct brick_cache *cache, struct brick_loader *loader,
                     const uint64_t *ids, size_t n, unsigned hold)
{
    uint64_t bricks = brick_volume_grid(v)->bricks, held[8];
    unsigned char *due = calloc(bricks, 1);
    unsigned holding = 0;
    for (size_t i = 0; i < n; i++)
        due[ids[i]] = 1;
    for (;;) {
        struct brick_taken t = take(loader);
        if (t.what == BRICK_TAKE_DONE)
            break;
        assert_true(due[t.id]);
        due[t.id] = 0;
        assert_true(right(v, t.id, t.data));
        held[holding++] = t.id;
        while (holding >= hold)
            brick_cache_unpin(cache, held[--holding]);
    }
    while (holding)
        brick_cache_unpin(cache, held[--holding]);
    for (uint64_t id = 0; id < bricks; id++)
        assert_int_equal(due[id], 0);
    free(due);
}

static void each_brick_is_read_once_in_any_cache(void **state)
{
    (void)state;
    struct brick_volume *v = make_volume();
    uint64_t bricks = brick_volume_grid(v)->bricks;
    static const uint64_t slots[] = {1, 2, 3, 8, 64, 100000};
    static const unsigned threads[] = {1, 2, 4}, in_flight[] = {1, 3, 16};
    uint64_t ids[300];
    for (int k = 0; k < 6 * 3 * 3; k++) {
        uint64_t n_slots = slots[k % 6];
        struct brick_cache *cache = make_cache(v, n_slots);
        struct brick_loader *loader = make_loader(cache, threads[k / 6 % 3], in_flight[k / 18]);
        struct brick_cache_counters c;
        struct brick_loader_counters lc;
        for (int round = 0; round < 4; round++) {
            unsigned char *seen = calloc(bricks, 1);
            uint64_t distinct = 0, before = loads(cache);
            for (size_t i = 0; i < 300; i++) { /* some twice; about half of them again in the next round */
                ids[i] =
                    (noise64((uint64_t)(k * 4 + round), i) % (bricks / 2) + (uint64_t)round * 40) % bricks;
                distinct += !seen[ids[i]];
                seen[ids[i]] = 1;
            }
            want(loader, ids, 300);
            take_all(v, cache, loader, ids, 300, n_slots > 8 ? 8 : (unsigned)n_slots);
            uint64_t read = loads(cache) - before;
            assert_true(read <= distinct);
            assert_true(read >= distinct - (round ? (n_slots < distinct ? n_slots : distinct) : 0));
            want(loader, ids, n_slots < 8 ? n_slots / 2 : 4); /* few enough to be in the cache or come */
            take_all(v, cache, loader, ids, n_slots < 8 ? n_slots / 2 : 4, 1);
            free(seen);
        }
        if (n_slots >= bricks)
            assert_true(loads(cache) <= bricks);
        brick_cache_count(cache, &c);
        brick_loader_count(loader, &lc);
        assert_true(c.peak_bytes <= n_slots * brick_grid_max_payload_bytes(brick_volume_grid(v)));
        assert_true(lc.in_flight_peak >= 1 && lc.in_flight_peak <= in_flight[k / 18]);
        assert_int_equal(lc.cancelled, 0);
        brick_loader_destroy(&loader);
        nothing_is_pinned(v, cache);
        brick_cache_destroy(&cache);
    }
    brick_volume_close(&v);
}

/* What is in the cache and wanted stays there while others are loaded, and costs no reading. */
static void found_bricks_are_not_pushed_out(void **state)
{
    (void)state;
    struct brick_volume *v = make_volume();
    struct brick_cache *cache = make_cache(v, 4);
    struct brick_loader *loader = make_loader(cache, 2, 8);
    uint64_t ids[100];
    for (uint64_t i = 0; i < 100; i++)
        ids[i] = i;
    want(loader, ids, 3);
    take_all(v, cache, loader, ids, 3, 1);
    assert_int_equal(loads(cache), 3);
    for (uint64_t i = 0; i < 100; i++)
        ids[i] = 99 - i; /* the three are wanted last */
    want(loader, ids, 100);
    usleep(20000); /* the threads could push them out now */
    take_all(v, cache, loader, ids, 100, 1);
    assert_int_equal(loads(cache), 100);
    brick_loader_destroy(&loader);
    brick_cache_destroy(&cache);
    brick_volume_close(&v);
}

static void what_is_not_wanted_is_cancelled(void **state)
{
    (void)state;
    struct brick_volume *v = make_volume();
    uint64_t bricks = brick_volume_grid(v)->bricks, ids[200];
    for (int round = 0; round < 60; round++) {
        struct brick_cache *cache = make_cache(v, round % 2 ? 5 : 1000);
        struct brick_loader *loader = make_loader(cache, 3, 6);
        for (int list = 0; list < 20; list++) {
            for (size_t i = 0; i < 200; i++)
                ids[i] = noise64((uint64_t)(round * 20 + list), i) % bricks;
            want(loader, ids, 200);
            for (int i = 0; i < list % 3; i++) {
                struct brick_taken t = take(loader);
                assert_int_equal(t.what, BRICK_TAKE_BRICK);
                assert_true(right(v, t.id, t.data));
                brick_cache_unpin(cache, t.id);
            }
        }
        if (round % 2 == 0) /* nothing was pushed out, so nothing was read twice, cancelled or not */
            assert_true(loads(cache) <= bricks);
        struct brick_loader_counters lc;
        brick_loader_count(loader, &lc);
        assert_true(lc.cancelled > 0 && lc.in_flight_peak <= 6);
        if (round % 3 == 0) {
            want(loader, NULL, 0);
            assert_int_equal(take(loader).what, BRICK_TAKE_DONE);
        } else if (round % 3 == 1) { /* half of the list as it was, in the middle of loading it */
            want(loader, ids, 100);
            take_all(v, cache, loader, ids, 100, 1);
        } /* else: destroyed with everything under way */
        brick_loader_destroy(&loader);
        nothing_is_pinned(v, cache);
        brick_cache_destroy(&cache);
    }
    brick_volume_close(&v);
}

static void a_full_cache_makes_it_wait(void **state)
{
    (void)state;
    struct brick_volume *v = make_volume();
    struct brick_cache *cache = make_cache(v, 2);
    struct brick_loader *loader = make_loader(cache, 2, 4), *second;
    struct brick_error err;
    struct brick_taken t;
    uint64_t ids[] = {7, 8, 9, 9, 7}, beyond = brick_volume_grid(v)->bricks;
    assert_int_equal(brick_loader_create(&second, cache, 1, 1, &err), BRICK_ERR_ARGUMENT);
    assert_null(second);
    want(loader, ids, 5);
    assert_int_equal(brick_loader_want(loader, &beyond, 1, &err), BRICK_ERR_ARGUMENT);
    uint64_t a = take(loader).id, b = take(loader).id;
    assert_true(a != b && a <= 9 && b <= 9);
    assert_int_equal(brick_loader_take(loader, 0, &t, &err), 0);
    assert_int_equal(t.what, BRICK_TAKE_LATER);
    assert_int_equal(brick_loader_take(loader, 20000000, &t, &err), 0);
    assert_int_equal(t.what, BRICK_TAKE_LATER);
    assert_int_equal(t.id, BRICK_NO_BRICK);
    brick_cache_unpin(cache, a);
    t = take(loader);
    assert_int_equal(t.id, 7 + 8 + 9 - a - b);
    assert_int_equal(take(loader).what, BRICK_TAKE_DONE);
    want(loader, &b, 1); /* still pinned: found, and pinned once more */
    assert_int_equal(take(loader).id, b);
    brick_cache_unpin(cache, b);
    brick_cache_unpin(cache, b);
    brick_cache_unpin(cache, t.id);
    brick_loader_destroy(&loader);
    nothing_is_pinned(v, cache);
    loader = make_loader(cache, 1, 1); /* the first one is gone */
    brick_loader_destroy(&loader);
    brick_cache_destroy(&cache);
    brick_volume_close(&v);
}

static void flip_a_byte(const char *path, uint64_t at)
{
    unsigned char byte;
    int fd = open(path, O_RDWR);
    assert_true(fd >= 0);
    assert_int_equal(pread(fd, &byte, 1, (off_t)at), 1);
    byte ^= 4;
    assert_int_equal(pwrite(fd, &byte, 1, (off_t)at), 1);
    close(fd);
}

/* Reads of the volume fail from now on: its file descriptor becomes that of a folder. */
static void break_reading(const char *path)
{
    DIR *fds = opendir("/proc/self/fd");
    struct dirent *entry;
    int broken = 0, folder = open("/", O_RDONLY | O_DIRECTORY);
    while ((entry = readdir(fds))) {
        char link[300], target[512];
        snprintf(link, sizeof link, "/proc/self/fd/%s", entry->d_name);
        ssize_t n = readlink(link, target, sizeof target - 1);
        if (n > 0 && (target[n] = 0, !strcmp(target, path)))
            broken += dup2(folder, atoi(entry->d_name)) >= 0;
    }
    closedir(fds);
    close(folder);
    assert_int_equal(broken, 1);
}

/* Take all: how many came, how many failed and how. */
static void count_faults(struct brick_cache *cache, struct brick_loader *loader, uint64_t *came,
                         uint64_t *failed, int expected, uint64_t only)
{
    struct brick_taken t;
    struct brick_error err;
    *came = *failed = 0;
    for (;;) {
        int code = brick_loader_take(loader, patience_ns, &t, &err);
        if (code) {
            char name[40];
            snprintf(name, sizeof name, "brick %llu ", (unsigned long long)t.id);
            assert_int_equal(code, expected);
            assert_int_equal(err.code, expected);
            assert_int_equal(err.brick, t.id);
            assert_non_null(strstr(err.message, name));
            assert_null(strchr(err.message, '\n'));
            if (only != BRICK_NO_BRICK)
                assert_int_equal(t.id, only);
            ++*failed;
        } else if (t.what == BRICK_TAKE_BRICK) {
            brick_cache_unpin(cache, t.id);
            ++*came;
        } else {
            assert_int_equal(t.what, BRICK_TAKE_DONE);
            return;
        }
    }
}

static void faults_name_their_brick(void **state)
{
    (void)state;
    struct brick_volume *v = make_volume();
    char *path = strdup(brick_volume_path(v));
    uint64_t n = brick_volume_grid(v)->level[1].first_brick, bad = n / 3, came, failed;
    uint64_t *ids = malloc(n * sizeof *ids);
    for (uint64_t i = 0; i < n; i++)
        ids[i] = i;
    struct brick_cache *cache = make_cache(v, 6);
    struct brick_loader *loader = make_loader(cache, 2, 4);

    flip_a_byte(path, brick_volume_entry(v, bad)->offset + 20);
    for (int again = 0; again < 2; again++) { /* reported once a list, and again when wanted again */
        want(loader, ids, n);
        count_faults(cache, loader, &came, &failed, BRICK_ERR_CHECKSUM, bad);
        assert_int_equal(failed, 1);
        assert_int_equal(came, n - 1);
    }
    flip_a_byte(path, brick_volume_entry(v, bad)->offset + 20);

    assert_int_equal(truncate(path, (off_t)(brick_volume_entry(v, n / 2)->offset + 7)), 0);
    want(loader, ids, n);
    count_faults(cache, loader, &came, &failed, BRICK_ERR_FORMAT, BRICK_NO_BRICK);
    assert_true(failed >= n - n / 2 - 6 && failed <= n - n / 2); /* up to six are in the cache */
    assert_int_equal(came + failed, n);

    break_reading(path);
    want(loader, ids, n);
    count_faults(cache, loader, &came, &failed, BRICK_ERR_IO, BRICK_NO_BRICK);
    assert_true(came <= 6);
    assert_int_equal(came + failed, n);
    want(loader, ids, n); /* destroyed with failing requests under way and untaken */
    brick_loader_destroy(&loader);
    brick_cache_destroy(&cache);
    free(ids);
    free(path);
    brick_volume_close(&v);
}

struct crowd {
    struct brick_volume *volume;
    struct brick_cache *cache;
    struct brick_loader *loader;
    int wrong, taken, pinned; /* atomic */
    bool end_takers, end;     /* atomic */
};

static void *taker(void *argument)
{
    struct crowd *c = argument;
    while (!__atomic_load_n(&c->end_takers, __ATOMIC_RELAXED)) {
        struct brick_taken t;
        struct brick_error err;
        if (brick_loader_take(c->loader, 1000000, &t, &err) ||
            (t.what == BRICK_TAKE_BRICK && !right(c->volume, t.id, t.data)))
            __atomic_add_fetch(&c->wrong, 1, __ATOMIC_RELAXED);
        if (t.what == BRICK_TAKE_BRICK) {
            brick_cache_unpin(c->cache, t.id);
            __atomic_add_fetch(&c->taken, 1, __ATOMIC_RELAXED);
        } else {
            usleep(50);
        }
    }
    return NULL;
}

static void *pinner(void *argument)
{
    struct crowd *c = argument;
    uint64_t bricks = brick_volume_grid(c->volume)->bricks;
    for (uint64_t i = 0; !__atomic_load_n(&c->end, __ATOMIC_RELAXED); i++) {
        struct brick_error err;
        const void *data;
        uint64_t id = noise64(77, i) % bricks;
        int code = brick_cache_pin(c->cache, id, &data, &err);
        if (code == BRICK_ERR_MEMORY)
            continue; /* all in use at the moment */
        if (code || !right(c->volume, id, data))
            __atomic_add_fetch(&c->wrong, 1, __ATOMIC_RELAXED);
        if (!code) {
            brick_cache_unpin(c->cache, id);
            __atomic_add_fetch(&c->pinned, 1, __ATOMIC_RELAXED);
        }
    }
    return NULL;
}

/* Several takers, others at the same cache, and wants that change all the time. */
static void a_crowd_gets_what_it_wants(void **state)
{
    (void)state;
    static const uint64_t slots[] = {3, 10, 1000};
    struct crowd c = {.volume = make_volume()};
    uint64_t bricks = brick_volume_grid(c.volume)->bricks, ids[100];
    for (int k = 0; k < 3; k++) {
        pthread_t threads[4];
        c.cache = make_cache(c.volume, slots[k]);
        c.loader = make_loader(c.cache, 3, 5);
        c.taken = c.pinned = 0;
        c.end_takers = c.end = false;
        for (int i = 0; i < 4; i++)
            assert_int_equal(pthread_create(&threads[i], NULL, i < 2 ? taker : pinner, &c), 0);
        for (uint64_t list = 0; list < 150; list++) {
            for (size_t i = 0; i < 100; i++)
                ids[i] = noise64(list, i) % bricks;
            want(c.loader, ids, list % 7 ? 100 : 0);
            usleep(300);
        }
        __atomic_store_n(&c.end_takers, true, __ATOMIC_RELAXED);
        pthread_join(threads[0], NULL);
        pthread_join(threads[1], NULL);
        for (uint64_t list = 0; list < 20;
             list++) { /* and with others at the cache lists are served to their ends */
            for (size_t i = 0; i < 100; i++)
                ids[i] = noise64(500 + list, i) % bricks;
            want(c.loader, ids, 100);
            take_all(c.volume, c.cache, c.loader, ids, 100, 1);
        }
        __atomic_store_n(&c.end, true, __ATOMIC_RELAXED);
        pthread_join(threads[2], NULL);
        pthread_join(threads[3], NULL);
        assert_int_equal(c.wrong, 0);
        assert_true(c.taken > 0 && c.pinned > 0);
        brick_loader_destroy(&c.loader);
        nothing_is_pinned(c.volume, c.cache);
        brick_cache_destroy(&c.cache);
    }
    brick_volume_close(&c.volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_brick_is_read_once_in_any_cache),
        cmocka_unit_test(found_bricks_are_not_pushed_out),
        cmocka_unit_test(what_is_not_wanted_is_cancelled),
        cmocka_unit_test(a_full_cache_makes_it_wait),
        cmocka_unit_test(faults_name_their_brick),
        cmocka_unit_test(a_crowd_gets_what_it_wants),
    };
    return cmocka_run_group_tests_name("loader", tests, NULL, NULL);
}
