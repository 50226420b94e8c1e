/* The active set never culls what is visible; the host cache keeps its budget and its pins. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/active.h>
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

/* Extinction at every voxel and at random points of every cell of a culled brick is zero. */
static void culling_is_safe(void **state)
{
    (void)state;
    static const double maps[][2] = {{1, 0}, {1, -24}, {-0.37, 11.5}, {1e-3, 4e3}};
    for (int k = 0; k < 4; k++) {
        struct brick_volume *v = make_volume(maps[k][0], maps[k][1]);
        const struct brick_grid *g = brick_volume_grid(v);
        double lo = 600 * maps[k][0] + maps[k][1], hi = 700 * maps[k][0] + maps[k][1], a = fmin(lo, hi),
               b = fmax(lo, hi), w = b - a;
        struct brick_transfer_point points[] = {{a - 9 * w, 1, 1, 1, 0},   {a, 1, 1, 1, 0},
                                                {a + w / 2, 1, 1, 1, 0.5}, {b, 1, 1, 1, 0},
                                                {b + w, 1, 1, 1, 0},       {b + 1.5 * w, 1, 0, 0, 0.3},
                                                {b + 2 * w, 1, 0, 0, 0}};
        struct brick_transfer_spec spec = {.points = points, .count = 7, .unit = 1.0};
        struct brick_transfer *t;
        struct brick_error err;
        assert_int_equal(brick_transfer_create(&t, &spec, 1.0, (double[]){0, 1}, &err), 0);
        uint64_t n = g->level[1].first_brick;
        uint8_t *states = malloc(n);
        struct brick_active_query query = {.mode = BRICK_MODE_DVR, .transfer = t};
        uint64_t active = brick_active_set(v, &query, states), culled = 0;
        assert_true(active > 0 && active < n);
        int16_t *payload = malloc(brick_grid_max_payload_bytes(g));
        struct brick_scratch scratch = {0};
        for (uint64_t id = 0; id < n; id++) {
            if (states[id] == BRICK_STATE_ACTIVE)
                continue;
            culled++;
            assert_int_equal(brick_volume_read(v, id, payload, &scratch, &err), 0);
            for (uint64_t i = 0; i < 3000; i++) {
                double f = 0.0, u[3];
                int c[3];
                for (int d = 0; d < 3; d++) {
                    double p = (double)(noise64(id, 3 * i + (uint64_t)d) >> 11) * 0x1p-53 * EDGE;
                    c[d] = (int)p;
                    u[d] = i % 3 ? p - c[d] : 0.0; /* a third of them on voxels */
                }
                for (int corner = 0; corner < 8; corner++) {
                    double weight = 1.0;
                    size_t at = 0;
                    for (int d = 2; d >= 0; d--) {
                        weight *= corner >> d & 1 ? u[d] : 1.0 - u[d];
                        at = at * (EDGE + 4) + (size_t)(2 + c[d] + (corner >> d & 1));
                    }
                    f += weight * payload[at];
                }
                double rgb[3], sigma;
                brick_transfer_eval(t, g->slope * f + g->intercept, rgb, &sigma);
                assert_true(sigma == 0.0);
            }
        }
        assert_int_equal(culled + active, n);
        brick_scratch_finish(&scratch);
        free(payload);
        free(states);
        brick_transfer_destroy(&t);
        brick_volume_close(&v);
    }
}

static void iso_states_tell_the_side(void **state)
{
    (void)state;
    struct brick_volume *v = make_volume(1, 0);
    const struct brick_grid *g = brick_volume_grid(v);
    uint8_t *states = malloc(g->level[1].first_brick);
    struct brick_active_query query = {.mode = BRICK_MODE_ISO, .isovalue = -999.5};
    brick_active_set(v, &query, states);
    unsigned seen = 0;
    for (uint64_t id = 0; id < g->level[1].first_brick; id++) {
        const struct brick_entry *e = brick_volume_entry(v, id);
        seen |= 1u << states[id];
        if (states[id] == BRICK_STATE_EMPTY)
            assert_true(e->max < -999.5f);
        if (states[id] == BRICK_STATE_ABOVE)
            assert_true(e->min > -999.5f);
    }
    assert_int_equal(seen, 7);
    free(states);
    brick_volume_close(&v);
}

/* A continuous field takes every value of its range; a wall of NaN lets a brick hold two ranges, and the mask
 * tells. */
static void the_mask_sees_what_nan_separates(void **state)
{
    (void)state;
    static float voxels[16 * 8 * 8];
    for (size_t i = 0; i < 16 * 8 * 8; i++)
        voxels[i] = i % 16 < 3   ? (float)(i % 2)
                    : i % 16 < 6 ? NAN
                    : i % 16 < 8 ? 100.0f + (float)(i % 2)
                                 : 7.0f;
    struct memory_source source;
    memory_source_init(&source, BRICK_F32, 16, 8, 8, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.edge = 8;
    struct brick_volume *v = build_and_open(&source, "mask.brick", &params);
    const struct brick_entry *e = brick_volume_entry(v, 0);
    assert_true(e->min == 0.0f && e->max == 101.0f);
    assert_int_equal(e->mask & 1, 1);
    assert_int_equal(e->mask >> 63, 1);
    assert_int_equal(e->mask >> 2 & 1, 0); /* bins of 1.58: values 3.2 to 4.7, between 0..1 and 7..101 */
    struct brick_error err;
    struct brick_transfer_point points[] = {
        {0, 1, 1, 1, 0}, {3.3, 1, 1, 1, 0}, {3.9, 1, 1, 1, 0.5}, {4.6, 1, 1, 1, 0}, {9, 1, 1, 1, 0}};
    struct brick_transfer_spec spec = {.points = points, .count = 5, .unit = 1.0};
    struct brick_transfer *t;
    assert_int_equal(brick_transfer_create(&t, &spec, 1.0, (double[]){0, 1}, &err), 0);
    uint8_t states[2];
    struct brick_active_query query = {.mode = BRICK_MODE_DVR, .transfer = t};
    brick_active_set(v, &query, states);
    assert_int_equal(states[0], BRICK_STATE_EMPTY);
    assert_int_equal(brick_transfer_visible(t, (double)e->min, (double)e->max), true);
    brick_transfer_destroy(&t);
    if (brick_check(v, 1, NULL, NULL, &err))
        fail_msg("%s", err.message);
    brick_volume_close(&v);
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
        cmocka_unit_test(culling_is_safe),
        cmocka_unit_test(iso_states_tell_the_side),
        cmocka_unit_test(the_mask_sees_what_nan_separates),
        cmocka_unit_test(the_cache_keeps_its_budget),
    };
    return cmocka_run_group_tests_name("stream", tests, NULL, NULL);
}
