/* From memory to file and back: round trip, levels, ranges, masks, constants, statistics, determinism. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../support/memory_source.h"

enum { NX = 45, NY = 37, NZ = 70 }; /* no multiple of any brick */

static double value_of(enum brick_type type, uint64_t i)
{
    uint64_t r = noise64(7, i);
    switch (type) {
    case BRICK_U8:
        return (double)(r & 0xff);
    case BRICK_I8:
        return (double)(int8_t)(r & 0xff);
    case BRICK_U16:
        return (double)(r & 0xffff);
    case BRICK_I16:
        return (double)(int16_t)(r & 0xffff);
    default:
        return (double)((float)(int32_t)(r & 0xffffffff) * 1e-3f);
    }
}

static void *noise_volume(enum brick_type type)
{
    void *voxels = malloc((size_t)NX * NY * NZ * 4);
    for (size_t i = 0; i < (size_t)NX * NY * NZ; i++)
        store_voxel(type, voxels, i, value_of(type, i));
    return voxels;
}

static void round_trip(void **state)
{
    (void)state;
    for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++)
        for (int codec = 0; codec < BRICK_CODEC_COUNT; codec++)
            for (uint32_t edge = 8; edge <= 64 && !brick_codec_is_lossy((enum brick_codec)codec); edge *= 2) {
                struct memory_source source;
                void *voxels = noise_volume((enum brick_type)type);
                memory_source_init(&source, (enum brick_type)type, NX, NY, NZ, voxels);
                struct brick_build_params params = brick_build_defaults;
                params.edge = edge;
                params.codec = (enum brick_codec)codec;
                struct brick_volume *v = build_and_open(&source, "round.brick", &params);
                size_t bytes = (size_t)NX * NY * NZ * brick_type_bytes((enum brick_type)type);
                void *back = malloc(bytes);
                struct brick_error err = {0};
                assert_int_equal(
                    brick_volume_read_box(v, 0, (uint64_t[]){0, 0, 0}, (uint64_t[]){NX, NY, NZ}, back, &err),
                    0);
                assert_memory_equal(back, voxels, bytes);
                if (brick_check(v, 2, NULL, NULL, &err))
                    fail_msg("%s", err.message);
                free(back);
                free(voxels);
                brick_volume_close(&v);
            }
}

/* The next level, written as the definition reads. */
static double coarse_voxel(enum brick_type type, const void *fine, const uint64_t n[3], const int halved[3],
                           uint64_t x, uint64_t y, uint64_t z)
{
    const uint64_t at[3] = {x, y, z};
    double sum = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        uint64_t i[3];
        for (int a = 0; a < 3; a++) {
            i[a] = halved[a] ? 2 * at[a] + (corner >> a & 1) : at[a];
            if (i[a] >= n[a])
                i[a] = n[a] - 1;
        }
        sum += brick_type_load(type, fine, (i[2] * n[1] + i[1]) * n[0] + i[0]);
    }
    return brick_type_is_integer(type) ? nearbyint(sum / 8.0) : (double)(float)(sum / 8.0);
}

static void levels_average(void **state)
{
    (void)state;
    for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++) {
        struct memory_source source;
        void *voxels = noise_volume((enum brick_type)type);
        memory_source_init(&source, (enum brick_type)type, NX, NY, NZ, voxels);
        source.base.geometry.affine[2][2] = 3.0; /* z waits until x and y have caught up */
        struct brick_build_params params = brick_build_defaults;
        params.edge = 8;
        struct brick_volume *v = build_and_open(&source, "levels.brick", &params);
        const struct brick_grid *g = brick_volume_grid(v);
        assert_int_equal(g->level[1].dims[0], 23);
        assert_int_equal(g->level[1].dims[1], 19);
        assert_int_equal(g->level[1].dims[2], 70); /* 1 < 2 but 3 >= 2 */
        assert_int_equal(g->level[2].dims[2], 35);
        assert_true(g->level[2].scale[0] == 4.0 && g->level[2].offset[0] == 1.5);
        assert_true(g->level[2].scale[2] == 2.0 && g->level[2].offset[2] == 0.5);
        const struct brick_level *last = &g->level[g->levels - 1];
        assert_int_equal(last->bricks[0] * last->bricks[1] * last->bricks[2], 1);
        void *fine = malloc((size_t)NX * NY * NZ * 4), *coarse = malloc((size_t)NX * NY * NZ * 4);
        memcpy(fine, voxels, (size_t)NX * NY * NZ * brick_type_bytes(g->type));
        for (uint32_t l = 1; l < g->levels; l++) {
            const struct brick_level *a = &g->level[l - 1], *b = &g->level[l];
            const int halved[3] = {b->scale[0] > a->scale[0], b->scale[1] > a->scale[1],
                                   b->scale[2] > a->scale[2]};
            struct brick_error err = {0};
            assert_int_equal(brick_volume_read_box(v, l, (uint64_t[]){0, 0, 0}, b->dims, coarse, &err), 0);
            for (uint64_t z = 0, i = 0; z < b->dims[2]; z++)
                for (uint64_t y = 0; y < b->dims[1]; y++)
                    for (uint64_t x = 0; x < b->dims[0]; x++, i++)
                        assert_true(brick_type_load(g->type, coarse, i) ==
                                    coarse_voxel(g->type, fine, a->dims, halved, x, y, z));
            void *t = fine;
            fine = coarse;
            coarse = t;
        }
        free(fine);
        free(coarse);
        free(voxels);
        brick_volume_close(&v);
    }
}

/* Trilinear field of level 0 at p, the edge repeated; also the definition of what ranges must cover. */
static double field(enum brick_type type, const void *voxels, const uint64_t n[3], const double p[3])
{
    double f = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        double w = 1.0;
        uint64_t i[3];
        for (int a = 0; a < 3; a++) {
            double cell = floor(p[a]), t = p[a] - cell;
            double at = cell + (corner >> a & 1);
            w *= corner >> a & 1 ? t : 1.0 - t;
            i[a] = at < 0.0 ? 0 : at > (double)(n[a] - 1) ? n[a] - 1 : (uint64_t)at;
        }
        if (w != 0.0)
            f += w * brick_type_load(type, voxels, (i[2] * n[1] + i[1]) * n[0] + i[0]);
    }
    return f;
}

/* Level 0's field at random points lies in the range, the mask's bins and the macrocell's range of every
 * level. */
static void ranges_cover_the_field(void **state)
{
    (void)state;
    for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++) {
        struct memory_source source;
        void *voxels = noise_volume((enum brick_type)type);
        memory_source_init(&source, (enum brick_type)type, NX, NY, NZ, voxels);
        struct brick_build_params params = brick_build_defaults;
        params.edge = 16;
        params.macrocell = 4;
        struct brick_volume *v = build_and_open(&source, "ranges.brick", &params);
        const struct brick_grid *g = brick_volume_grid(v);
        void *payload = malloc(brick_grid_max_payload_bytes(g));
        struct brick_scratch scratch = {0};
        for (uint64_t id = 0; id < g->bricks; id++) {
            struct brick_place p;
            brick_grid_place(g, id, &p);
            const struct brick_level *level = &g->level[p.level];
            const struct brick_entry *e = brick_volume_entry(v, id);
            struct brick_error err = {0};
            assert_int_equal(brick_volume_read(v, id, payload, &scratch, &err), 0);
            const char *macrocells = (const char *)payload + brick_place_voxel_bytes(g, &p);
            for (uint64_t k = 0; k < 200; k++) {
                double local[3], p0[3];
                uint64_t cell[3];
                for (int a = 0; a < 3; a++) {
                    double u = (double)(noise64(id, 3 * k + (uint64_t)a) >> 11) * 0x1p-53;
                    local[a] = u * p.core[a]; /* position in the brick's cells */
                    cell[a] = (uint64_t)local[a] / g->macrocell;
                    p0[a] = level->scale[a] * ((double)(p.at[a] * g->edge) + local[a]) + level->offset[a];
                }
                double f = field(g->type, voxels, g->dims, p0), slack = 1e-12 * fabs(f);
                assert_true(f >= (double)e->min - slack && f <= (double)e->max + slack);
                double bin = (f - (double)e->min) * (64.0 / ((double)e->max - (double)e->min));
                unsigned low = (unsigned)fmax(0.0, bin - 1e-9),
                         high = (unsigned)fmin(63.0, fmax(0.0, bin + 1e-9));
                assert_true(e->mask >> (low < 63 ? low : 63) & 1 || e->mask >> high & 1);
                size_t m = (cell[2] * p.macrocells[1] + cell[1]) * p.macrocells[0] + cell[0];
                assert_true(f >= brick_type_load(g->type, macrocells, 2 * m) - slack);
                assert_true(f <= brick_type_load(g->type, macrocells, 2 * m + 1) + slack);
            }
        }
        brick_scratch_finish(&scratch);
        free(payload);
        free(voxels);
        brick_volume_close(&v);
    }
}

static void same_bytes_for_any_threads(void **state)
{
    (void)state;
    for (int type = BRICK_U16; type <= BRICK_F32; type += 2) {
        struct memory_source source;
        void *voxels = noise_volume((enum brick_type)type);
        memory_source_init(&source, (enum brick_type)type, NX, NY, NZ, voxels);
        struct brick_build_params params = brick_build_defaults;
        params.edge = 8;
        void *first = NULL;
        size_t first_bytes = 0;
        for (unsigned threads = 1; threads <= 5; threads += 2) {
            params.threads = threads;
            struct brick_volume *v = build_and_open(&source, "threads.brick", &params);
            brick_volume_close(&v);
            size_t bytes;
            void *data = read_file(test_path("threads.brick"), &bytes);
            if (!first) {
                first = data;
                first_bytes = bytes;
                continue;
            }
            assert_int_equal(bytes, first_bytes);
            assert_memory_equal(data, first, bytes);
            free(data);
        }
        free(first);
        free(voxels);
    }
}

static void constants_have_no_payload(void **state)
{
    (void)state;
    static int16_t voxels[96 * 40 * 40];
    for (size_t i = 0; i < 96 * 40 * 40; i++)
        voxels[i] = i % 96 < 50 ? -1000 : (int16_t)(i % 96);
    struct memory_source source;
    memory_source_init(&source, BRICK_I16, 96, 40, 40, voxels);
    struct brick_volume *v = build_and_open(&source, "constant.brick", NULL);
    const struct brick_entry *air = brick_volume_entry(v, 0), *second = brick_volume_entry(v, 1);
    assert_int_equal(air->flags, BRICK_FLAG_CONSTANT);
    assert_int_equal(air->bytes, 0);
    assert_true(air->min == -1000.0f && air->max == -1000.0f);
    assert_int_equal(second->flags, 0);
    int16_t *payload = malloc(brick_grid_max_payload_bytes(brick_volume_grid(v)));
    struct brick_scratch scratch = {0};
    struct brick_error err = {0};
    assert_int_equal(brick_volume_read(v, 0, payload, &scratch, &err), 0);
    for (size_t i = 0; i < 36 * 36 * 36 + 2 * 64; i++)
        assert_int_equal(payload[i], -1000);
    brick_scratch_finish(&scratch);
    free(payload);
    brick_volume_close(&v);
}

static void nonfinite_are_counted(void **state)
{
    (void)state;
    static float voxels[40 * 40 * 40];
    for (size_t i = 0; i < 40 * 40 * 40; i++)
        voxels[i] = i % 7 == 0 ? NAN : i % 11 == 0 ? INFINITY : (float)(i % 13);
    struct memory_source source;
    memory_source_init(&source, BRICK_F32, 40, 40, 40, voxels);
    struct brick_volume *v = build_and_open(&source, "nan.brick", NULL);
    uint64_t expect = 0, counted = 0;
    for (size_t i = 0; i < 40 * 40 * 40; i++)
        expect += !isfinite(voxels[i]);
    const struct brick_stats *s = brick_volume_stats(v);
    assert_int_equal(s->nonfinite, expect);
    assert_int_equal(s->count + s->nonfinite, 40 * 40 * 40);
    assert_true(s->min == 0.0 && s->max == 12.0);
    const struct brick_grid *g = brick_volume_grid(v);
    for (uint64_t id = 0; id < g->level[1].first_brick; id++)
        counted += brick_volume_entry(v, id)->nonfinite;
    assert_int_equal(counted, expect);
    struct brick_error err = {0};
    if (brick_check(v, 1, NULL, NULL, &err))
        fail_msg("%s", err.message);
    brick_volume_close(&v);

    for (size_t i = 0; i < 40 * 40 * 40; i++)
        voxels[i] = NAN;
    v = build_and_open(&source, "allnan.brick", NULL);
    assert_int_equal(brick_volume_stats(v)->count, 0);
    double range[2];
    brick_volume_value_range(v, range);
    assert_true(range[0] == 0.0 && range[1] == 0.0);
    if (brick_check(v, 1, NULL, NULL, &err))
        fail_msg("%s", err.message);
    brick_volume_close(&v);
}

static void statistics_are_right(void **state)
{
    (void)state;
    static float voxels[50 * 50 * 50];
    double sum = 0.0, m2 = 0.0;
    size_t n = 50 * 50 * 50;
    for (size_t i = 0; i < n; i++) { /* a mean far above the deviation: the hard case for variances */
        voxels[i] = 1e6f + (float)(noise64(3, i) % 16);
        sum += (double)voxels[i];
    }
    for (size_t i = 0; i < n; i++)
        m2 += ((double)voxels[i] - sum / (double)n) * ((double)voxels[i] - sum / (double)n);
    struct memory_source source;
    memory_source_init(&source, BRICK_F32, 50, 50, 50, voxels);
    struct brick_volume *v = build_and_open(&source, "stats.brick", NULL);
    const struct brick_stats *s = brick_volume_stats(v);
    /* n sums of numbers below 2^20 in double: relative error below n * 2^-53 of the largest */
    assert_true(fabs(s->mean - sum / (double)n) < 1e-9 * s->mean);
    assert_true(fabs(s->variance - m2 / (double)n) < 1e-9 * s->variance);
    brick_volume_close(&v);

    static uint16_t ints[50 * 50 * 50];
    for (size_t i = 0; i < n; i++)
        ints[i] = (uint16_t)(noise64(5, i) % 1000);
    memory_source_init(&source, BRICK_U16, 50, 50, 50, ints);
    v = build_and_open(&source, "stats16.brick", NULL);
    s = brick_volume_stats(v);
    uint64_t want = 0;
    for (size_t i = 0; i < n; i++)
        want += ints[i] == 500;
    assert_int_equal(s->histogram[500 - s->first_bin], want);
    assert_true(fabs(brick_stats_percentile(s, BRICK_U16, 0.5) - 500.0) < 15.0); /* 3 sigma of the median */
    brick_volume_close(&v);
}

static void wide_types_convert_or_refuse(void **state)
{
    (void)state;
    static int32_t voxels[20 * 20 * 20];
    struct memory_source source;
    struct brick_error err = {0};
    for (size_t i = 0; i < 8000; i++)
        voxels[i] = (int32_t)i * 2000 - 8000000; /* below 2^24: exact */
    memory_source_init(&source, BRICK_I32, 20, 20, 20, voxels);
    struct brick_volume *v = build_and_open(&source, "i32.brick", NULL);
    assert_int_equal(brick_volume_grid(v)->type, BRICK_F32);
    float back;
    assert_int_equal(
        brick_volume_read_box(v, 0, (uint64_t[]){19, 19, 19}, (uint64_t[]){20, 20, 20}, &back, &err), 0);
    assert_true(back == (float)voxels[7999]);
    brick_volume_close(&v);
    voxels[4321] = 16777217;
    assert_int_equal(brick_build(&source.base, test_path("no.brick"), &brick_build_defaults, NULL, &err),
                     BRICK_ERR_INEXACT);
    assert_non_null(strstr(err.message, "voxel 4321"));
    assert_null(fopen(test_path("no.brick"), "rb"));
    assert_null(fopen(test_path("no.brick.part"), "rb"));
    struct brick_build_params params = brick_build_defaults;
    params.round_to_f32 = true;
    v = build_and_open(&source, "rounded.brick", &params);
    brick_volume_close(&v);
}

static void memory_cap_is_said(void **state)
{
    (void)state;
    struct memory_source source;
    struct brick_error err = {0};
    void *voxels = noise_volume(BRICK_U16);
    memory_source_init(&source, BRICK_U16, NX, NY, NZ, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.memory_bytes = 1 << 20;
    assert_int_equal(brick_build(&source.base, test_path("cap.brick"), &params, NULL, &err),
                     BRICK_ERR_MEMORY);
    assert_non_null(strstr(err.message, "--memory"));
    source.base.read_box = NULL;
    assert_int_equal(brick_build(&source.base, test_path("cap.brick"), &params, NULL, &err),
                     BRICK_ERR_MEMORY);
    assert_non_null(strstr(err.message, "front to back"));
    free(voxels);
}

static void thin_volumes(void **state)
{
    (void)state;
    const uint64_t dims[][3] = {{1, 1, 1},    {1, 1, 5000}, {5000, 1, 1},
                                {1, 5000, 1}, {2, 3, 33},   {33, 32, 31}};
    static uint8_t voxels[33 * 32 * 31];
    for (size_t i = 0; i < sizeof voxels; i++)
        voxels[i] = (uint8_t)noise64(9, i);
    for (size_t k = 0; k < sizeof dims / sizeof dims[0]; k++) {
        struct memory_source source;
        memory_source_init(&source, BRICK_U8, dims[k][0], dims[k][1], dims[k][2], voxels);
        struct brick_volume *v = build_and_open(&source, "thin.brick", NULL);
        static uint8_t back[sizeof voxels];
        struct brick_error err = {0};
        assert_int_equal(brick_volume_read_box(v, 0, (uint64_t[]){0, 0, 0}, dims[k], back, &err), 0);
        assert_memory_equal(back, voxels, dims[k][0] * dims[k][1] * dims[k][2]);
        if (brick_check(v, 2, NULL, NULL, &err))
            fail_msg("%s", err.message);
        brick_volume_close(&v);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip),
        cmocka_unit_test(levels_average),
        cmocka_unit_test(ranges_cover_the_field),
        cmocka_unit_test(same_bytes_for_any_threads),
        cmocka_unit_test(constants_have_no_payload),
        cmocka_unit_test(nonfinite_are_counted),
        cmocka_unit_test(statistics_are_right),
        cmocka_unit_test(wide_types_convert_or_refuse),
        cmocka_unit_test(memory_cap_is_said),
        cmocka_unit_test(thin_volumes),
    };
    return cmocka_run_group_tests_name("build", tests, NULL, NULL);
}
