/* Files with a lossy codec: the tolerance holds from end to end, and everything a file says about itself is
 * about the voxels that it gives. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include <brick/writer.h>

#include "../support/memory_source.h"

/* NaN, Inf: not zfp's. A whole volume with some of them still passes every check. */
static void bricks_that_are_not_finite_are_lossless(void **state)
{
    (void)state;
    if (!brick_codec_is_built(BRICK_CODEC_ZFP))
        skip();
    enum { N = 40 };
    float *voxels = malloc(sizeof(float) * N * N * N);
    for (int i = 0; i < N * N * N; i++)
        voxels[i] = (float)sin(0.01 * i) + (float)(noise64(1, (uint64_t)i) % 1000) * 1e-4f;
    voxels[5 * N * N + 5 * N + 5] = NAN;
    voxels[6 * N * N + 5 * N + 5] = -INFINITY;
    struct memory_source source;
    memory_source_init(&source, BRICK_F32, N, N, N, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.edge = 16;
    params.codec = BRICK_CODEC_ZFP;
    params.tolerance = 1e-2;
    struct brick_volume *v = build_and_open(&source, "nan.brick", &params);
    struct brick_error err = {0};
    if (brick_check(v, 2, NULL, NULL, &err))
        fail_msg("%s", err.message);
    int used[BRICK_CODEC_COUNT] = {0};
    for (uint64_t id = 0; id < brick_volume_grid(v)->bricks; id++)
        used[brick_volume_entry(v, id)->codec]++;
    assert_true(used[BRICK_CODEC_ZFP] > 0 && used[BRICK_CODEC_ZSTD_DELTA] > 0);
    assert_int_equal(brick_volume_entry(v, 0)->codec, BRICK_CODEC_ZSTD_DELTA);
    assert_int_equal(brick_volume_stats(v)->nonfinite, 2);
    brick_volume_close(&v);
    free(voxels);
}

static void fill_body(enum brick_type type, void *voxels, const uint64_t n[3])
{
    /* Air that is one value, a ball with structure and noise in it. */
    for (uint64_t z = 0, i = 0; z < n[2]; z++)
        for (uint64_t y = 0; y < n[1]; y++)
            for (uint64_t x = 0; x < n[0]; x++, i++) {
                double r = hypot(hypot((double)x - 50, (double)y - 30), (double)z - 30);
                double v = r > 20 ? 3 : 25 + 20 * sin(0.4 * r) + (double)(noise64(4, i) % 70);
                store_voxel(type, voxels, i, v);
            }
}

/* A whole file: every voxel within the tolerance, checks pass, ranges of every level hold what a reader sees
 * at level 0, constants are constants, threads do not matter. */
static void lossy_files(void **state)
{
    (void)state;
    if (!brick_codec_is_built(BRICK_CODEC_ZFP))
        skip();
    const uint64_t n[3] = {71, 60, 60}, zero[3] = {0, 0, 0};
    const double slopes[] = {1.0, -0.1}, tolerances[] = {8.0, 0.93};
    size_t count = (size_t)(n[0] * n[1] * n[2]);
    void *voxels = malloc(count * 4), *back = malloc(count * 4);
    for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++)
        for (int k = 0; k < 2; k++) {
            struct memory_source source;
            fill_body((enum brick_type)type, voxels, n);
            memory_source_init(&source, (enum brick_type)type, n[0], n[1], n[2], voxels);
            source.base.geometry.slope = slopes[k];
            struct brick_build_params params = brick_build_defaults;
            params.edge = 8;
            params.macrocell = 4;
            params.codec = BRICK_CODEC_ZFP;
            params.tolerance = tolerances[k];
            params.threads = 1;
            struct brick_volume *v = build_and_open(&source, "lossy.brick", &params);
            struct brick_error err = {0};
            if (brick_check(v, 2, NULL, NULL, &err))
                fail_msg("%s", err.message);
            assert_true(brick_volume_tolerance(v) == tolerances[k]);
            assert_non_null(strstr(brick_volume_provenance(v), "zfp"));
            assert_int_equal(brick_volume_read_box(v, 0, zero, n, back, &err), 0);
            size_t changed = 0;
            for (size_t i = 0; i < count; i++) {
                double a = brick_type_load((enum brick_type)type, voxels, i),
                       b = brick_type_load((enum brick_type)type, back, i);
                assert_true(fabs(slopes[k]) * fabs(a - b) <= tolerances[k]);
                changed += a != b;
            }
            assert_true(changed > count / 50);

            /* Level 0's decoded voxels against every coarser brick and macrocell over the same place. */
            const struct brick_grid *g = brick_volume_grid(v);
            void *payload = malloc(brick_grid_max_payload_bytes(g));
            struct brick_scratch scratch = {0};
            uint64_t constant[2] = {0, 0};
            for (uint64_t id = 0; id < g->bricks; id++) {
                struct brick_place p;
                brick_grid_place(g, id, &p);
                const struct brick_entry *e = brick_volume_entry(v, id);
                constant[p.level > 0] += e->flags & BRICK_FLAG_CONSTANT;
                if (p.level == 0)
                    continue;
                assert_int_equal(brick_volume_read(v, id, payload, &scratch, &err), 0);
                const char *cells = (const char *)payload + brick_place_voxel_bytes(g, &p);
                const struct brick_level *level = &g->level[p.level];
                for (uint64_t t = 0; t < 300; t++) {
                    uint64_t cell = 0, at[3];
                    for (int a = 2; a >= 0; a--) {
                        /* A core voxel of the coarse brick and one of level 0's voxels below it. */
                        uint64_t c = noise64(id, 3 * t + (uint64_t)a) % p.core[a];
                        uint64_t step = (uint64_t)level->scale[a];
                        at[a] = (p.at[a] * g->edge + c) * step + noise64(id, t + 1000) % step;
                        at[a] = at[a] < n[a] ? at[a] : n[a] - 1;
                        cell = cell * p.macrocells[a] + c / g->macrocell;
                    }
                    double f = brick_type_load(g->type, back, (at[2] * n[1] + at[1]) * n[0] + at[0]);
                    assert_true(f >= (double)e->min && f <= (double)e->max);
                    assert_true(f >= brick_type_load(g->type, cells, 2 * cell) &&
                                f <= brick_type_load(g->type, cells, 2 * cell + 1));
                }
            }
            assert_true(constant[0] > 10 && constant[1] > 0);
            brick_scratch_finish(&scratch);
            free(payload);

            params.threads = 3;
            struct brick_volume *w = build_and_open(&source, "lossy3.brick", &params);
            size_t n_v, n_w;
            void *file_v = read_file(brick_volume_path(v), &n_v),
                 *file_w = read_file(brick_volume_path(w), &n_w);
            assert_int_equal(n_v, n_w);
            assert_memory_equal(file_v, file_w, n_v);
            free(file_v);
            free(file_w);
            brick_volume_close(&w);
            brick_volume_close(&v);
        }
    free(voxels);
    free(back);
}

static void zfp_and_a_tolerance_go_together(void **state)
{
    (void)state;
    static const uint8_t voxels[512];
    struct memory_source source;
    struct brick_error err = {0};
    memory_source_init(&source, BRICK_U8, 8, 8, 8, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.tolerance = 1.0;
    assert_int_equal(brick_build(&source.base, test_path("no.brick"), &params, NULL, &err),
                     BRICK_ERR_ARGUMENT);
    params.codec = BRICK_CODEC_ZFP;
    params.tolerance = 0.0;
    assert_int_equal(brick_build(&source.base, test_path("no.brick"), &params, NULL, &err),
                     BRICK_ERR_ARGUMENT);
    params.tolerance = NAN;
    assert_int_equal(brick_build(&source.base, test_path("no.brick"), &params, NULL, &err),
                     BRICK_ERR_ARGUMENT);
}

/* Write v again with a tolerance in the header and one voxel of brick 1, in its border outside every cell,
 * moved. */
static int check_with_a_moved_border(struct brick_volume *v, double tolerance, int move,
                                     struct brick_error *err)
{
    const struct brick_grid *g = brick_volume_grid(v);
    const char *path = test_path("moved.brick");
    struct brick_writer *w = NULL;
    struct brick_scratch scratch = {0};
    uint64_t bytes;
    uint8_t *payload = malloc(brick_grid_max_payload_bytes(g));
    assert_int_equal(brick_writer_create(&w, path, g, err), 0);
    brick_writer_set_tolerance(w, tolerance);
    for (uint64_t id = 0; id < g->bricks; id++) {
        struct brick_place p;
        brick_grid_place(g, id, &p);
        assert_int_equal(brick_volume_read(v, id, payload, &scratch, err), 0);
        if (id == 1)
            payload[((size_t)6 * p.stored[1] + 6) * p.stored[0]] += (uint8_t)move;
        struct brick_entry e = *brick_volume_entry(v, id);
        assert_int_equal(brick_writer_put(w, id, &e, payload, brick_place_payload_bytes(g, &p), err), 0);
    }
    assert_int_equal(brick_writer_finish(w, brick_volume_stats(v), "", &bytes, err), 0);
    brick_writer_destroy(&w);
    brick_scratch_finish(&scratch);
    free(payload);
    struct brick_volume *moved = NULL;
    assert_int_equal(brick_volume_open(&moved, path, err), 0);
    int code = brick_check(moved, 2, NULL, NULL, err);
    brick_volume_close(&moved);
    return code;
}

static void neighbours_may_differ_by_twice_the_tolerance(void **state)
{
    (void)state;
    enum { N = 24 };
    static uint8_t voxels[N * N * N];
    for (size_t i = 0; i < N * N * N; i++)
        voxels[i] = (uint8_t)(noise64(5, i) % 200);
    struct memory_source source;
    memory_source_init(&source, BRICK_U8, N, N, N, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.edge = 8;
    params.codec = BRICK_CODEC_NONE;
    struct brick_volume *v = build_and_open(&source, "still.brick", &params);
    struct brick_error err = {0};
    assert_int_equal(check_with_a_moved_border(v, 0.0, 0, &err), 0);
    assert_int_equal(check_with_a_moved_border(v, 0.0, 1, &err), BRICK_ERR_FORMAT);
    assert_int_equal(check_with_a_moved_border(v, 0.9, 1, &err), BRICK_ERR_FORMAT); /* u8: nothing may move */
    assert_int_equal(check_with_a_moved_border(v, 1.0, 2, &err), 0);
    assert_int_equal(check_with_a_moved_border(v, 1.0, 3, &err), BRICK_ERR_FORMAT);
    assert_non_null(strstr(err.message, "neighbour"));
    brick_volume_close(&v);
}

/* The header's tolerance: zfp bricks without one, or one that is no number, contradict the format. */
static void impossible_tolerances(void **state)
{
    (void)state;
    if (!brick_codec_is_built(BRICK_CODEC_ZFP))
        skip();
    static float voxels[20 * 20 * 20];
    for (size_t i = 0; i < 8000; i++)
        voxels[i] = (float)(i % 20);
    struct memory_source source;
    memory_source_init(&source, BRICK_F32, 20, 20, 20, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.edge = 8;
    params.codec = BRICK_CODEC_ZFP;
    params.tolerance = 0.5;
    struct brick_volume *v = build_and_open(&source, "header.brick", &params);
    const char *path = test_path("header.brick");
    brick_volume_close(&v);
    const double bad[] = {0.0, -1.0, NAN, INFINITY};
    for (int i = 0; i < 4; i++) {
        unsigned char header[512];
        FILE *f = fopen(path, "r+b");
        assert_int_equal(fread(header, 1, 512, f), 512);
        double was;
        memcpy(&was, header + 288, 8);
        assert_true(i || was == 0.5);
        memcpy(header + 288, &bad[i], 8);
        uint64_t checksum = XXH3_64bits(header, 504);
        memcpy(header + 504, &checksum, 8);
        rewind(f);
        fwrite(header, 1, 512, f);
        fclose(f);
        struct brick_error err = {0};
        assert_int_equal(brick_volume_open(&v, path, &err), BRICK_ERR_FORMAT);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bricks_that_are_not_finite_are_lossless),
        cmocka_unit_test(lossy_files),
        cmocka_unit_test(zfp_and_a_tolerance_go_together),
        cmocka_unit_test(neighbours_may_differ_by_twice_the_tolerance),
        cmocka_unit_test(impossible_tolerances),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
