/* A damaged file becomes the file that it was where no brick of level 0 is lost, whatever part of it is
 * damaged; where one is, the others stay as they were, and what fills the gap is what the header says. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include <brick/repair.h>

#include "../support/memory_source.h"

enum { NX = 41, NY = 36, NZ = 30 };

struct bytes {
    unsigned char *data;
    size_t n;
};

static struct bytes bytes_of(const char *path)
{
    struct bytes b;
    b.data = read_file(path, &b.n);
    assert_non_null(b.data);
    return b;
}

/* A ball with texture in constant air: bricks of both kinds, and of a flat core with something in the border.
 */
static void *ball(enum brick_type type)
{
    void *voxels = malloc((size_t)NX * NY * NZ * brick_type_bytes(type));
    size_t i = 0;
    for (int z = 0; z < NZ; z++)
        for (int y = 0; y < NY; y++)
            for (int x = 0; x < NX; x++, i++) {
                int d = (x - 20) * (x - 20) + (y - 17) * (y - 17) + (z - 16) * (z - 16);
                store_voxel(type, voxels, i, d < 170 ? 30.0 + (double)(noise64(4, i) % 60) : 7.0);
            }
    return voxels;
}

static struct bytes make(enum brick_type type, const struct brick_build_params *params)
{
    void *voxels = ball(type);
    struct memory_source source;
    memory_source_init(&source, type, NX, NY, NZ, voxels);
    source.base.geometry.affine[0][3] = 3.25;
    source.base.geometry.slope = 2.0;
    struct brick_volume *v = build_and_open(&source, "good.brick", params);
    brick_volume_close(&v);
    free(voxels);
    return bytes_of(test_path("good.brick"));
}

static struct brick_build_params small_bricks(void)
{
    struct brick_build_params params = brick_build_defaults;
    params.edge = 8;
    params.macrocell = 4;
    params.threads = 2;
    return params;
}

static struct brick_repair_params repair_defaults(void)
{
    return (struct brick_repair_params){.memory_bytes = (uint64_t)256 << 20, .threads = 2};
}

/* Offset and bytes of table i: levels, index, statistics, provenance. */
static void table(const struct bytes *file, int i, uint64_t *at, uint64_t *bytes)
{
    memcpy(at, file->data + 192 + 24 * i, 8);
    memcpy(bytes, file->data + 192 + 24 * i + 8, 8);
}

/* Repair these bytes. The result passes brick_check, always; the caller frees it. */
static struct bytes repaired(const unsigned char *bad, size_t n, const struct brick_repair_params *params,
                             struct brick_repair_report *report)
{
    struct brick_error err = {0};
    struct brick_repair_params defaults = repair_defaults();
    const char *from = test_path("bad.brick"), *to = test_path("whole.brick");
    write_file(from, bad, n);
    unlink(to);
    if (brick_repair(from, to, params ? params : &defaults, report, &err))
        fail_msg("%s", err.message);
    struct brick_volume *v;
    if (brick_volume_open(&v, to, &err) || brick_check(v, 2, NULL, NULL, &err))
        fail_msg("%s", err.message);
    brick_volume_close(&v);
    return bytes_of(to);
}

static bool same(const struct bytes *a, const struct bytes *b)
{
    return a->n == b->n && memcmp(a->data, b->data, a->n) == 0;
}

/* Any damage of the header, the level table, the index and the statistics; of payloads above level 0. */
static void tables_and_coarser_levels_come_back(void **state)
{
    (void)state;
    static const struct {
        enum brick_type type;
        enum brick_codec codec;
        int level;
        bool nearest;
    } kinds[] = {{BRICK_U16, BRICK_CODEC_LZ4, 1, false},
                 {BRICK_U8, BRICK_CODEC_ZSTD_DELTA, 3, false},
                 {BRICK_I16, BRICK_CODEC_NONE, 1, false},
                 {BRICK_U8, BRICK_CODEC_ZSTD, 5, true},
                 {BRICK_F32, BRICK_CODEC_LZ4_BITSHUFFLE, 9, false}};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        struct brick_build_params params = small_bricks();
        params.codec = kinds[k].codec;
        params.codec_level = kinds[k].level;
        params.nearest = kinds[k].nearest;
        /* Payloads that are not compressed do not tell their lengths: not every place can be found. */
        const bool tells = params.codec != BRICK_CODEC_NONE;
        struct bytes good = make(kinds[k].type, &params), out;
        unsigned char *bad = malloc(good.n);
        struct brick_repair_report report;
        uint64_t at, bytes, levels_at, prov_at, prov_bytes, first_coarse = 0;
        table(&good, 0, &levels_at, &bytes);
        table(&good, 3, &prov_at, &prov_bytes);
        struct brick_error err;
        struct brick_volume *v;
        assert_int_equal(brick_volume_open(&v, test_path("good.brick"), &err), 0);
        const struct brick_grid *g = brick_volume_grid(v);
        for (uint64_t id = g->level[1].first_brick; id < g->bricks && !first_coarse; id++)
            first_coarse = brick_volume_entry(v, id)->offset;
        uint64_t constant = 0;
        for (uint64_t id = 0; id < g->level[1].first_brick; id++)
            constant += brick_volume_entry(v, id)->flags & BRICK_FLAG_CONSTANT;
        assert_true(constant > 10 && constant < g->level[1].first_brick - 10);
        brick_volume_close(&v);
        /* A flipped bit: the header, then from the first coarser payload to the provenance. */
        for (size_t i = 0; i < prov_at; i += 1 + noise64(7, i) % (k ? 199 : 41)) {
            if (i >= 512 && i < first_coarse)
                i = first_coarse;
            memcpy(bad, good.data, good.n);
            bad[i] ^= (unsigned char)(1u << (noise64(8, i) & 7));
            out = repaired(bad, good.n, NULL, &report);
            if (report.lost || report.damage.provenance || !same(&good, &out))
                fail_msg("kind %zu: a flipped bit in byte %zu of %zu is not put right", k, i, good.n);
            free(out.data);
        }
        /* A whole table; then a sector of the index, wherever it begins. */
        for (int t = 0; t < 3; t++) {
            if (t == 1 && !tells)
                continue;
            table(&good, t, &at, &bytes);
            memcpy(bad, good.data, good.n);
            memset(bad + at, 0, bytes);
            out = repaired(bad, good.n, NULL, &report);
            if (report.lost || !same(&good, &out))
                fail_msg("kind %zu: table %d does not come back", k, t);
            free(out.data);
        }
        table(&good, 1, &at, &bytes);
        for (uint64_t i = 0; tells && i + 512 < bytes; i += 1301) {
            memcpy(bad, good.data, good.n);
            memset(bad + at + i, 0xff, 512);
            out = repaired(bad, good.n, NULL, &report);
            if (report.lost || !same(&good, &out))
                fail_msg("kind %zu: a sector at %llu of the index does not come back", k,
                         (unsigned long long)i);
            free(out.data);
        }
        /* A tail that is gone up to anywhere in the tables: the provenance cannot come back, all else does.
         */
        for (uint64_t n = tells ? levels_at : at + bytes; n < prov_at + prov_bytes; n += 1 + bytes / 4) {
            out = repaired(good.data, n, NULL, &report);
            assert_true(report.damage.provenance);
            if (report.lost || out.n != good.n - prov_bytes ||
                memcmp(out.data + 512, good.data + 512, out.n - 512) != 0)
                fail_msg("kind %zu: cut to %llu bytes, it does not come back", k, (unsigned long long)n);
            free(out.data);
        }
        /* Something appended. */
        struct bytes longer = {malloc(good.n + 9), good.n + 9};
        memcpy(longer.data, good.data, good.n);
        memset(longer.data + good.n, 1, 9);
        out = repaired(longer.data, longer.n, NULL, &report);
        assert_true(same(&good, &out));
        free(out.data);
        free(longer.data);
        free(bad);
        free(good.data);
    }
}

struct losses {
    struct brick_loss list[64];
    int n;
};

static void note_loss(void *context, const struct brick_loss *loss)
{
    struct losses *losses = context;
    assert_true(losses->n < 64);
    losses->list[losses->n++] = *loss;
}

/* One payload of level 0 after the other: it is named, every other voxel is as it was, its outermost ones
 * too, and the others are what level 1 has there. */
static void a_lost_brick_is_named_and_filled(void **state)
{
    (void)state;
    struct brick_build_params params = small_bricks();
    struct bytes good = make(BRICK_U16, &params);
    struct brick_volume *v, *w;
    struct brick_error err;
    size_t n = (size_t)NX * NY * NZ;
    uint16_t *was = malloc(n * 2), *is = malloc(n * 2), *coarse = NULL;
    unsigned char *bad = malloc(good.n);
    assert_int_equal(brick_volume_open(&v, test_path("good.brick"), &err), 0);
    const struct brick_grid *g = brick_volume_grid(v);
    const uint64_t zero[3] = {0, 0, 0}, *size1 = g->level[1].dims;
    coarse = malloc(size1[0] * size1[1] * size1[2] * 2);
    assert_int_equal(brick_volume_read_box(v, 0, zero, g->dims, was, &err), 0);
    assert_int_equal(brick_volume_read_box(v, 1, zero, size1, coarse, &err), 0);
    for (uint64_t id = 0; id < g->level[1].first_brick; id++) {
        const struct brick_entry *e = brick_volume_entry(v, id);
        if (e->flags & BRICK_FLAG_CONSTANT)
            continue;
        struct losses losses = {.n = 0};
        struct brick_repair_params how = repair_defaults();
        struct brick_repair_report report;
        how.lost = note_loss;
        how.lost_context = &losses;
        memcpy(bad, good.data, good.n);
        bad[e->offset + noise64(9, id) % e->bytes] ^= 4;
        struct bytes out = repaired(bad, good.n, &how, &report);
        assert_int_equal(report.lost, 1);
        assert_int_equal(losses.n, 1);
        assert_int_equal(losses.list[0].brick, id);
        free(out.data);
        struct brick_place place;
        brick_grid_place(g, id, &place);
        assert_int_equal(brick_volume_open(&w, test_path("whole.brick"), &err), 0);
        assert_int_equal(brick_volume_read_box(w, 0, zero, g->dims, is, &err), 0);
        brick_volume_close(&w);
        uint32_t right = 0;
        for (uint64_t z = 0, i = 0; z < NZ; z++)
            for (uint64_t y = 0; y < NY; y++)
                for (uint64_t x = 0; x < NX; x++, i++) {
                    const uint64_t at[3] = {x, y, z};
                    bool inside = true, deep = true;
                    for (int a = 0; a < 3; a++) {
                        uint64_t lo = place.at[a] * 8, hi = lo + place.core[a];
                        inside = inside && at[a] >= lo && at[a] < hi;
                        deep = deep && (at[a] >= lo + 2 || lo == 0) && (at[a] + 2 < hi || hi == g->dims[a]);
                    }
                    right += inside && !deep;
                    uint16_t now =
                        inside && deep ? coarse[(z / 2 * size1[1] + y / 2) * size1[0] + x / 2] : was[i];
                    if (is[i] != now)
                        fail_msg("brick %llu lost: voxel %llu,%llu,%llu is %u, not %u",
                                 (unsigned long long)id, (unsigned long long)x, (unsigned long long)y,
                                 (unsigned long long)z, is[i], now);
                }
        assert_int_equal(losses.list[0].from_neighbours, right);
        assert_int_equal(losses.list[0].from_level, 1);
    }
    brick_volume_close(&v);
    free(was);
    free(is);
    free(coarse);
    free(bad);
    free(good.data);
}

/* A lossy file's payloads are kept as they are; what is made again keeps a tolerance that the header tells.
 */
static void lossy_files(void **state)
{
    (void)state;
    if (!brick_codec_is_built(BRICK_CODEC_ZFP))
        skip();
    struct brick_build_params params = small_bricks();
    params.codec = BRICK_CODEC_ZFP;
    params.tolerance = 9.0; /* four stored values */
    struct bytes good = make(BRICK_U16, &params), out;
    unsigned char *bad = malloc(good.n);
    struct brick_repair_report report;
    uint64_t at, bytes;
    for (int t = 0; t < 3; t += 2) {
        table(&good, t, &at, &bytes);
        memcpy(bad, good.data, good.n);
        memset(bad + at, 0, bytes);
        out = repaired(bad, good.n, NULL, &report);
        assert_true(same(&good, &out));
        free(out.data);
    }
    table(&good, 0, &at, &bytes);
    bool doubled = false;
    for (size_t i = 512; i < at; i += 1 + noise64(12, i) % 400) {
        memcpy(bad, good.data, good.n);
        bad[i] ^= 1;
        out = repaired(bad, good.n, NULL, &report);
        assert_true(report.lost + report.rebuilt > 0);
        assert_true(report.tolerance == (report.rebuilt ? 18.0 : 9.0));
        doubled = doubled || (report.rebuilt && !report.lost);
        free(out.data);
    }
    assert_true(doubled);
    free(bad);
    free(good.data);
}

/* Whatever the bytes, repair ends in a file that is whole or in one line; under the address sanitizer. */
static void any_damage_ends_in_a_result(void **state)
{
    (void)state;
    struct brick_build_params params = small_bricks();
    struct bytes good = make(BRICK_U8, &params);
    unsigned char *bad = malloc(good.n);
    struct brick_error err;
    struct brick_repair_params how = repair_defaults();
    for (uint64_t round = 0; round < 60; round++) {
        size_t n = good.n;
        memcpy(bad, good.data, n);
        for (uint64_t t = 0; t <= noise64(20, round) % 4; t++) {
            uint64_t r = noise64(21 + t, round);
            size_t at = 512 + r % (n - 512), length = (r >> 32) % 700;
            if (length > n - at)
                length = n - at;
            if (r >> 62 == 0 && at > 600)
                n = at;
            else
                for (size_t i = 0; i < length; i++)
                    bad[at + i] = r >> 62 == 1 ? 0 : (unsigned char)noise64(r, i);
        }
        struct brick_repair_report report;
        struct bytes out = repaired(bad, n, NULL, &report);
        free(out.data);
    }
    /* Entries and header that lie under right checksums. */
    struct brick_repair_report report;
    uint64_t at, bytes, sum;
    table(&good, 1, &at, &bytes);
    const char *from = test_path("bad.brick"), *to = test_path("whole.brick");
    for (size_t i = 0; i < 48 * 40; i += 23) {
        memcpy(bad, good.data, good.n);
        bad[at + i] ^= (unsigned char)(1u << i % 8);
        sum = XXH3_64bits(bad + at, bytes);
        memcpy(bad + 192 + 40, &sum, 8);
        sum = XXH3_64bits(bad, 504);
        memcpy(bad + 504, &sum, 8);
        write_file(from, bad, good.n);
        (void)brick_repair(from, to, &how, &report, &err);
    }
    const uint64_t values[] = {0, 3, UINT32_MAX, UINT64_C(1) << 40, UINT64_MAX};
    for (size_t i = 16; i < 288; i += 8)
        for (size_t k = 0; k < sizeof values / sizeof *values; k++) {
            memcpy(bad, good.data, good.n);
            memcpy(bad + i, &values[k], 8);
            sum = XXH3_64bits(bad, 504);
            memcpy(bad + 504, &sum, 8);
            write_file(from, bad, good.n);
            int code = brick_repair(from, to, &how, &report, &err);
            assert_true(code <= 0 && (!code || !strchr(err.message, '\n')));
        }
    free(bad);
    free(good.data);
}

static void what_cannot_be_repaired_is_said(void **state)
{
    (void)state;
    struct brick_build_params params = small_bricks();
    struct bytes good = make(BRICK_U8, &params);
    struct brick_repair_params how = repair_defaults();
    struct brick_repair_report report;
    struct brick_error err;
    const char *from = test_path("bad.brick"), *to = test_path("none.brick");
    write_file(from, good.data, 511);
    assert_int_equal(brick_repair(from, to, &how, &report, &err), BRICK_ERR_FORMAT);
    assert_non_null(strstr(err.message, "header"));
    memset(good.data + 60, 0x55, 20); /* more than one byte of the header */
    write_file(from, good.data, good.n);
    assert_int_equal(brick_repair(from, to, &how, &report, &err), BRICK_ERR_CHECKSUM);
    memset(good.data, 0, 512);
    write_file(from, good.data, good.n);
    assert_int_equal(brick_repair(from, to, &how, &report, &err), BRICK_ERR_FORMAT);
    assert_non_null(strstr(err.message, "unfinished"));
    free(good.data);
    good = make(BRICK_U8, &params);
    write_file(from, good.data, good.n);
    how.memory_bytes = 20000;
    assert_int_equal(brick_repair(from, to, &how, &report, &err), BRICK_ERR_MEMORY);
    assert_int_not_equal(access(to, F_OK), 0);
    free(good.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_and_coarser_levels_come_back),
        cmocka_unit_test(a_lost_brick_is_named_and_filled),
        cmocka_unit_test(lossy_files),
        cmocka_unit_test(any_damage_ends_in_a_result),
        cmocka_unit_test(what_cannot_be_repaired_is_said),
    };
    return cmocka_run_group_tests_name("repair", tests, NULL, NULL);
}
