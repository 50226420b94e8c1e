/* The host cache keeps its budget and its pins. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/cache.h>
#include <brick/threads.h>

#include "../support/memory_source.h"

enum { N = 64, EDGE = 8 };

static struct brick_volume *make_volume(double slope, double intercept)
{
    static int16_t voxels[N * N * N];
    for (int z = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < N; x++) {
                double r = sqrt((double)((x - 32) * (x - 32) + (y - 32) * (y - 32) + (z - 32) * (z - 32)));
                voxels[(z * N + y) * N + x] =
                    (int16_t)(r > 28 ? -1000
                                     : 1000.0 * cos(r * 0.5) + (double)(noise64(1, (uint64_t)x) % 20));
            }
    struct memory_source source;
    memory_source_init(&source, BRICK_I16, N, N, N, voxels);
    source.base.geometry.slope = slope;
    source.base.geometry.intercept = intercept;
    struct brick_build_params params = brick_build_defaults;
    params.edge = EDGE;
    return build_and_open(&source, "stream.brick", &params);
}

struct pinning {
    struct brick_cache *cache;
    const struct brick_volume *volume;
};

static int pin_item(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    (void)worker;
    struct pinning *p = context;
    uint64_t id = noise64(11, item) % brick_volume_grid(p->volume)->bricks;
    const void *data;
    int code = brick_cache_pin(p->cache, id, &data, err);
    if (code)
        return code;
    struct brick_place place;
    brick_grid_place(brick_volume_grid(p->volume), id, &place);
    size_t n = brick_place_payload_bytes(brick_volume_grid(p->volume), &place);
    static _Thread_local unsigned char own[(EDGE + 4) * (EDGE + 4) * (EDGE + 4) * 2 + 4096];
    struct brick_scratch scratch = {0};
    code = brick_volume_read(p->volume, id, own, &scratch, err);
    brick_scratch_finish(&scratch);
    if (!code && memcmp(own, data, n) != 0)
        code = brick_fail(err, BRICK_ERR_FORMAT, "brick %llu changed while pinned", (unsigned long long)id);
    brick_cache_unpin(p->cache, id);
    return code;
}

static void the_cache_keeps_its_budget(void **state)
{
    (void)state;
    struct brick_volume *v = make_volume(1, 0);
    struct brick_error err = {0};
    size_t brick = brick_grid_max_payload_bytes(brick_volume_grid(v));
    for (unsigned slots = 4; slots <= 4096; slots *= 4) {
        struct pinning p = {.volume = v};
        struct brick_pool *pool;
        assert_int_equal(brick_cache_create(&p.cache, v, slots * brick, &err), 0);
        assert_int_equal(brick_pool_create(&pool, 4, &err), 0);
        if (brick_pool_run(pool, 3000, pin_item, &p, &err))
            fail_msg("%s", err.message);
        struct brick_cache_counters c;
        brick_cache_count(p.cache, &c);
        assert_true(c.peak_bytes <= slots * brick);
        assert_int_equal(c.loads + c.hits, 3000);
        if (slots == 4096) /* larger than the volume: nothing is loaded twice */
            assert_true(c.loads <= brick_volume_grid(v)->bricks);
        brick_pool_destroy(&pool);
        brick_cache_destroy(&p.cache);
    }
    struct brick_cache *cache;
    assert_int_equal(brick_cache_create(&cache, v, brick - 1, &err), BRICK_ERR_ARGUMENT);
    assert_int_equal(brick_cache_create(&cache, v, 2 * brick, &err), 0);
    const void *data;
    assert_int_equal(brick_cache_pin(cache, 0, &data, &err), 0);
    assert_int_equal(brick_cache_pin(cache, 1, &data, &err), 0);
    assert_int_equal(brick_cache_pin(cache, 2, &data, &err), BRICK_ERR_MEMORY);
    brick_cache_unpin(cache, 1);
    assert_int_equal(brick_cache_pin(cache, 2, &data, &err), 0);
    brick_cache_destroy(&cache);
    brick_volume_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cache_keeps_its_budget),
    };
    return cmocka_run_group_tests_name("stream", tests, NULL, NULL);
}
