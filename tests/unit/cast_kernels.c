/* Renderer/cast from the inside: every table of kernels that this processor can run against the plain one,
 * bit for bit, on all types; rays in packets against rays in queues; the plain one's opacity and
 * classification against double precision; distances between bricks against the definition. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../support/memory_source.h"
#include "away.h"
#include "kernels.h"

enum { EDGE = 21, BORDER = 2, CORE = EDGE - 2 * BORDER, VOXELS = EDGE * EDGE * EDGE, RAYS = 40 };

struct work {
    struct vr_cast_queue queue;
    struct vr_cast_seen seen;
    _Alignas(64) float before[VR_CAST_ROOM];
};

static double uniform(uint64_t seed, uint64_t i)
{
    return (double)(noise64(seed, i) >> 11) * 0x1p-53;
}

/* A run of one ray from somewhere in the core, as many samples as stay there. */
static struct vr_cast_run run_of(uint64_t seed, uint32_t ray)
{
    struct vr_cast_run run = {.ray = ray, .length_mm = (float)(0.1 + uniform(seed, 9))};
    uint64_t most = 200;
    for (uint64_t a = 0; a < 3; a++) {
        const double at = BORDER + uniform(seed, a) * (CORE - 0.01), step = uniform(seed, a + 3) * 2.0 - 1.0;
        const double room = step > 0.0 ? BORDER + CORE - 0.01 - at : at - BORDER;
        run.at[a] = (uint64_t)(at * 0x1p56);
        run.step[a] = (uint64_t)(int64_t)(step * 0x1p56);
        if (room / fabs(step) < (double)most)
            most = (uint64_t)(room / fabs(step));
    }
    run.count = (uint32_t)most + 1;
    return run;
}

/* A transfer function as kernels have it. */
struct function {
    struct brick_transfer *transfer;
    struct vr_transfer_table table;
    struct vr_cast_pieces pieces;
};

static void function_init(struct function *f, const struct brick_transfer_point *points, size_t count)
{
    const struct brick_transfer_spec spec = {.points = (struct brick_transfer_point *)points,
                                             .count = count,
                                             .unit = 1.0,
                                             .unit_of = BRICK_UNIT_MM};
    const struct brick_grid grid = {.slope = 1.0};
    assert_int_equal(brick_transfer_create(&f->transfer, &spec, 1.0, (const double[2]){-100, 100}, NULL), 0);
    assert_int_equal(vr_transfer_table_init(&f->table, f->transfer, &grid, NULL), 0);
    assert_int_equal(vr_cast_pieces_init(&f->pieces, &f->table, NULL), 0);
}

static void function_finish(struct function *f)
{
    vr_cast_pieces_finish(&f->pieces);
    vr_transfer_table_finish(&f->table);
    brick_transfer_destroy(&f->transfer);
}

/* One with so few pieces that a vector holds them, with up to 32, with up to 64, and with more. */
enum { FUNCTIONS = 4 };
static void functions_init(struct function functions[FUNCTIONS])
{
    static const double most[FUNCTIONS] = {0.02, 0.02, 0.02, 1.0};
    static const size_t counts[FUNCTIONS] = {4, 18, 40, 60};
    static const uint32_t above[FUNCTIONS] = {1, 16, 32, 64}, limit[FUNCTIONS] = {16, 32, 64, UINT32_MAX};
    struct brick_transfer_point points[60];
    for (int f = 0; f < FUNCTIONS; f++) {
        for (uint64_t i = 0; i < counts[f]; i++)
            points[i] =
                (struct brick_transfer_point){-90.0 + 180.0 * (double)i / (double)counts[f], uniform(1, i),
                                              uniform(2, i), uniform(3, i), most[f] * uniform(4, i)};
        function_init(&functions[f], points, counts[f]);
        assert_in_range(functions[f].table.count, above[f] + 1, limit[f]);
    }
}

/* All kernels that samples in queues go through one after the other; *w is what they leave. */
static void go(const struct vr_cast_kernels *k, enum brick_type type, const struct vr_cast_brick *brick,
               const struct vr_cast_pieces *pieces, uint64_t seed, struct work *w)
{
    static float view[3][RAYS];
    struct vr_cast_light light = {.normal = {{0.9f, 0.1f, -0.2f}, {0.05f, 1.0f, 0.1f}, {0.1f, -0.3f, 0.7f}},
                                  .ambient = 0.2f,
                                  .diffuse = 0.7f,
                                  .specular = 0.3f,
                                  .shininess = seed % 2 ? 20.0f : 0.5f};
    const struct vr_cast_field field = {seed % 3 ? 1.0f : -1.0f, {-90.0f, 90.0f}, type == BRICK_F32};
    memset(w, 0, sizeof *w);
    for (uint32_t r = 0; r < RAYS && w->queue.count < VR_CAST_QUEUE; r++) {
        struct vr_cast_run run = run_of(seed * RAYS + r, r);
        for (uint64_t a = 0; a < 3; a++)
            view[a][r] = (float)(0.57735 * (1.0 - uniform(seed + r, a) * 1e-3));
        while (run.count && w->queue.count < VR_CAST_QUEUE)
            k->scan(&w->queue, brick, &run);
    }
    for (int a = 0; a < 3; a++)
        light.view[a] = view[a];
    k->typed[type].look(&w->seen, &w->queue, brick, &field, true);
    k->classify(&w->seen, pieces);
    k->typed[type].shade(&w->seen, brick, &light, field.nonfinite);
    for (uint32_t i = 0; i < w->seen.count; i++)
        w->before[i] = (float)(uniform(seed, i) * 100.0);
    k->dim(&w->seen, w->before);
}

#define SAME(array) assert_memory_equal(a->array, b->array, n * sizeof *a->array)

static void assert_same(const struct work *x, const struct work *y, bool *any)
{
    /* Sets queue different numbers of samples at a time, so only the order of all is the same. */
    const uint32_t queued = x->queue.count < y->queue.count ? x->queue.count : y->queue.count;
    size_t n = queued;
    {
        const struct vr_cast_queue *a = &x->queue, *b = &y->queue;
        SAME(ray);
        SAME(voxel);
        SAME(length_mm);
        SAME(at[0]);
        SAME(at[1]);
        SAME(at[2]);
    }
    n = x->seen.count < y->seen.count ? x->seen.count : y->seen.count;
    {
        const struct vr_cast_seen *a = &x->seen, *b = &y->seen;
        SAME(ray);
        SAME(voxel);
        SAME(value);
        SAME(length_mm);
        SAME(fraction[0]);
        SAME(fraction[1]);
        SAME(fraction[2]);
        SAME(depth);
        SAME(rgb[0]);
        SAME(rgb[1]);
        SAME(rgb[2]);
        SAME(alpha);
    }
    *any = *any || n > 16;
}

static void fill(float *voxels, enum brick_type type, uint64_t seed)
{
    for (uint64_t i = 0; i < VOXELS; i++) {
        double v = 100.0 * sin(0.5 * (double)(i % EDGE) + (double)(seed + i / EDGE)) + 9.0 * uniform(seed, i);
        if (type == BRICK_F32 && noise64(7, i) % 150 == 0)
            v = i % 2 ? NAN : INFINITY;
        store_voxel(type, voxels, i,
                    type == BRICK_U8 || type == BRICK_U16 ? fmax(rint(v), 0.0)
                    : type == BRICK_F32                   ? v
                                                          : rint(v));
    }
}

static void tables_agree(void **state)
{
    (void)state;
    static float voxels[VOXELS + 4]; /* of the largest type */
    static uint32_t bits[(5 * 5 * 5 + 31) / 32];
    static struct work plain, other;
    struct function functions[FUNCTIONS];
    unsigned last = 0;
    bool any = false;
    functions_init(functions);
    while (vr_cast_kernels_table(last + 1))
        last++;
    for (uint64_t round = 0; round < 60; round++)
        for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++) {
            struct vr_cast_brick brick = {.voxels = voxels,
                                          .row = EDGE,
                                          .slice = EDGE * EDGE,
                                          .border = BORDER,
                                          .bits = bits,
                                          .words = round % 3 == 1 ? 2 : 4,
                                          .bit_row = round % 3 == 1 ? 3 : 5,
                                          .bit_slice = round % 3 == 1 ? 9 : 25,
                                          .macro_shift = round % 3 == 1 ? 3 : 2};
            fill(voxels, (enum brick_type)type, round);
            for (uint64_t i = 0; i < sizeof bits / sizeof *bits; i++)
                bits[i] = (uint32_t)(noise64(round, i) | noise64(round, i + 99));
            const struct vr_cast_pieces *pieces = &functions[round % FUNCTIONS].pieces;
            go(vr_cast_kernels_table(last), (enum brick_type)type, &brick, pieces, round, &plain);
            for (unsigned t = 0; t < last; t++) {
                go(vr_cast_kernels_table(t), (enum brick_type)type, &brick, pieces, round, &other);
                assert_same(&plain, &other, &any);
            }
        }
    assert_true(any || last == 0);
    for (int f = 0; f < FUNCTIONS; f++)
        function_finish(&functions[f]);
}

/* What a ray gathers. */
struct sums {
    float depth, rgb[3];
};

/* A ray's samples alone, through the queues of the plain table, and added up one by one. */
static struct sums sums_in_queues(const struct vr_cast_kernels *k, enum brick_type type,
                                  const struct vr_cast_brick *brick, const struct vr_cast_field *field,
                                  const struct vr_cast_pieces *pieces, const struct vr_cast_light *light,
                                  struct vr_cast_run run, float depth_end, bool mip)
{
    static struct work w;
    struct sums sums = {0};
    w.queue.count = 0;
    while (run.count)
        k->scan(&w.queue, brick, &run);
    k->typed[type].look(&w.seen, &w.queue, brick, field, true);
    k->classify(&w.seen, pieces);
    if (light)
        k->typed[type].shade(&w.seen, brick, light, field->nonfinite);
    for (uint32_t i = 0; i < w.seen.count; i++) {
        if (mip) {
            sums.rgb[0] = i ? fmaxf(sums.rgb[0], w.seen.value[i]) : w.seen.value[i];
            sums.depth = 1.0f;
            continue;
        }
        w.before[i] = sums.depth;
        if (!(sums.depth > depth_end))
            sums.depth += w.seen.depth[i];
        else
            w.seen.alpha[i] = 0.0f;
    }
    if (mip)
        return sums;
    k->dim(&w.seen, w.before);
    for (uint32_t i = 0; i < w.seen.count; i++)
        for (int c = 0; c < 3; c++)
            sums.rgb[c] += w.seen.alpha[i] * w.seen.rgb[c][i];
    return sums;
}

/* Side by side rays gather the bits that they do through queues, in all sets, whether they end early or not.
 */
static void packets_are_queues(void **state)
{
    (void)state;
    static float voxels[VOXELS + 4], view[3][RAYS];
    static struct vr_cast_packet p;
    static struct vr_cast_seen seen;
    static uint32_t all[4];
    struct function functions[FUNCTIONS];
    const struct vr_cast_kernels *plain = NULL;
    uint32_t early = 0;
    functions_init(functions);
    memset(all, 255, sizeof all);
    for (unsigned t = 0; vr_cast_kernels_table(t); t++)
        plain = vr_cast_kernels_table(t);
    for (uint32_t i = 0; i < 3 * RAYS; i++)
        view[i / RAYS][i % RAYS] = (float)(0.57735 * (1.0 - uniform(3, i) * 1e-3));
    for (uint64_t round = 0; round < 40; round++)
        for (unsigned t = 0; vr_cast_kernels_table(t); t++) {
            const struct vr_cast_kernels *k = vr_cast_kernels_table(t);
            const enum brick_type type = (enum brick_type)(round % BRICK_TYPE_STORED_COUNT);
            const struct vr_cast_brick brick = {.voxels = voxels,
                                                .row = EDGE,
                                                .slice = EDGE * EDGE,
                                                .border = BORDER,
                                                .bits = all,
                                                .words = 4,
                                                .bit_row = 5,
                                                .bit_slice = 25,
                                                .macro_shift = 2};
            const struct vr_cast_field field = {round % 3 ? 1.0f : -1.0f, {-90.0f, 90.0f}, type == BRICK_F32};
            const struct vr_cast_light light = {
                .normal = {{0.9f, 0.1f, -0.2f}, {0.05f, 1.0f, 0.1f}, {0.1f, -0.3f, 0.7f}},
                .ambient = 0.2f,
                .diffuse = 0.7f,
                .specular = 0.3f,
                .shininess = 20.0f,
                .view = {view[0], view[1], view[2]}};
            const struct vr_cast_pieces *pieces = &functions[round % FUNCTIONS].pieces;
            const bool mip = round % 4 == 3, shaded = round % 4 == 2;
            const float depth_end = mip || round % 8 == 0 ? INFINITY : 0.5f;
            struct vr_cast_run runs[RAYS];
            fill(voxels, type, round);
            p.on.count = p.ended.count = 0;
            for (uint32_t r = 0; r < RAYS; r++) {
                runs[r] = run_of(round * RAYS + r, r);
                if (r % 7 == 0)
                    runs[r].count = 1;
                for (int a = 0; a < 3; a++) {
                    for (int w = 0; w < 2; w++) {
                        p.at[a][w][r] = (uint32_t)(runs[r].at[a] >> 32 * w);
                        p.step[a][w][r] = (uint32_t)(runs[r].step[a] >> 32 * w);
                    }
                    p.on.rgb[a][r] = 0.0f;
                }
                p.on.ray[r] = r;
                p.on.depth[r] = p.voxel[r] = 0;
                p.left[r] = runs[r].count;
                p.length_mm[r] = runs[r].length_mm;
            }
            uint64_t looked = 0, most = 0;
            for (p.on.count = RAYS; p.on.count;) {
                const uint32_t before = p.on.count;
                memset(p.left + before, 0, k->lanes * sizeof *p.left);
                p.on.count = 0;
                for (uint32_t i = 0; i < before; i += k->lanes) {
                    looked += k->typed[type].march(&seen, &p, i, &brick, &field, shaded);
                    k->classify(&seen, pieces);
                    if (shaded)
                        k->typed[type].shade(&seen, &brick, &light, field.nonfinite);
                    if (mip)
                        k->largest(&p, i, before, &seen);
                    else
                        k->sum(&p, i, before, &seen, depth_end);
                }
            }
            assert_int_equal(p.ended.count, RAYS);
            for (uint32_t i = 0; i < RAYS; i++) {
                const uint32_t r = p.ended.ray[i];
                const struct sums sums = sums_in_queues(plain, type, &brick, &field, pieces,
                                                        shaded ? &light : NULL, runs[r], depth_end, mip);
                assert_memory_equal(&sums.depth, &p.ended.depth[i], sizeof sums.depth);
                for (int c = 0; c < (mip ? 1 : 3); c++)
                    assert_memory_equal(&sums.rgb[c], &p.ended.rgb[c][i], sizeof *sums.rgb);
                most += runs[r].count;
                early += sums.depth > depth_end;
            }
            assert_in_range(looked, RAYS, most);
            if (isinf(depth_end))
                assert_int_equal(looked, most);
        }
    assert_true(early);
    for (int f = 0; f < FUNCTIONS; f++)
        function_finish(&functions[f]);
}

/* Distances are what comparing each brick with all others finds. */
static void away_is_the_distance(void **state)
{
    (void)state;
    static uint8_t away[16 * 16 * 16 + 18], matters[16 * 16 * 16];
    for (uint64_t round = 0; round < 30; round++) {
        const uint64_t n[3] = {1 + noise64(round, 0) % 16, 1 + noise64(round, 1) % 16,
                               1 + noise64(round, 2) % 16};
        const uint64_t bricks = n[0] * n[1] * n[2], rare = 1 + noise64(round, 3) % 200;
        for (uint64_t b = 0; b < bricks; b++) {
            matters[b] = round && noise64(round, 9 + b) % rare == 0;
            away[b] = matters[b] ? 0 : UINT8_MAX;
        }
        vr_cast_find_away(away, n);
        for (uint64_t b = 0; b < bricks; b++) {
            uint64_t least = UINT8_MAX;
            for (uint64_t c = 0; c < bricks; c++) {
                const int64_t d[3] = {(int64_t)(b % n[0]) - (int64_t)(c % n[0]),
                                      (int64_t)(b / n[0] % n[1]) - (int64_t)(c / n[0] % n[1]),
                                      (int64_t)(b / n[0] / n[1]) - (int64_t)(c / n[0] / n[1])};
                uint64_t far = 0;
                for (int a = 0; a < 3; a++)
                    far = (uint64_t)llabs(d[a]) > far ? (uint64_t)llabs(d[a]) : far;
                least = matters[c] && far < least ? far : least;
            }
            assert_int_equal(away[b], least);
        }
    }
}

/* Depth and colour are the transfer function's to float32, opacity 1 - exp(-depth) to 4 units in the last
 * place. */
static void classification_is_the_function(void **state)
{
    (void)state;
    static struct vr_cast_seen seen;
    struct function functions[FUNCTIONS];
    functions_init(functions);
    for (unsigned t = 0; vr_cast_kernels_table(t); t++)
        for (int f = 0; f < FUNCTIONS; f++) {
            const struct brick_transfer *transfer = functions[f].transfer;
            memset(&seen, 0, sizeof seen);
            seen.count = 500;
            for (uint32_t i = 0; i < seen.count; i++) { /* knots, too */
                seen.value[i] = i < transfer->count ? (float)transfer->knots[i].value
                                                    : (float)(220.0 * uniform(5, i) - 110.0);
                seen.length_mm[i] = (float)exp(20.0 * uniform(6, i) - 15.0);
            }
            vr_cast_kernels_table(t)->classify(&seen, &functions[f].pieces);
            for (uint32_t i = 0; i < seen.count; i++) {
                double rgb[3], sigma, opacity = -expm1(-(double)seen.depth[i]);
                brick_transfer_eval(transfer, (double)seen.value[i], rgb, &sigma);
                /* slope times distance is as large as the largest extinction, 17 a mm, and rounds as such */
                assert_true(fabs((double)seen.depth[i] - sigma * (double)seen.length_mm[i]) <=
                            8 * 0x1p-23 * 17.0 * (double)seen.length_mm[i]);
                assert_true(fabs((double)seen.alpha[i] - opacity) <= 4 * 0x1p-23 * opacity);
                for (int c = 0; c < 3; c++)
                    assert_true(fabs((double)seen.rgb[c][i] - rgb[c]) <= 8 * 0x1p-23);
            }
        }
    for (int f = 0; f < FUNCTIONS; f++)
        function_finish(&functions[f]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(tables_agree), cmocka_unit_test(packets_are_queues),
                                       cmocka_unit_test(away_is_the_distance),
                                       cmocka_unit_test(classification_is_the_function)};
    return cmocka_run_group_tests_name("cast_kernels", tests, NULL, NULL);
}
