/* Conversions with many checkpoints, killed late and early: what little they decode and read again, and that
 * nothing depends on the checkpoints being there, or whole. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "../support/interrupted.h"

enum { ROWS_BETWEEN = 4 }; /* level 0's rows of bricks, in volumes of up to 64 */

/* 40 rows of bricks in a tower: checkpoints are many, and slices small. */
static void tower_init(struct scene *s, enum brick_type type)
{
    scene_init(s, type, (uint64_t[]){24, 20, 315}, 8);
}

/* Killed by and by later: at a fortieth of the calls, two, ... */
static void killed_later_and_later(const struct scene *s, unsigned turns,
                                   void (*check)(const struct scene *s, const struct brick_build_report *r))
{
    struct scene other = *s;
    uint64_t kept = 0;
    for (unsigned turn = 1; turn < turns; turn++) {
        struct rest rest;
        rest_take(&rest, s, s->calls * turn / turns);
        other.params.threads = 1 + turn % 3;
        struct brick_build_report r = scene_resumes(&other, "killed", turn);
        rest_finish(&rest);
        assert_true(r.bricks_kept >= kept);
        kept = r.bricks_kept;
        check(s, &r);
    }
    assert_true(kept > s->report.bricks * 3 / 4);
}

static uint64_t bricks_a_row(const struct scene *s)
{
    const uint64_t *n = s->source.base.geometry.dims, e = s->params.edge;
    return ((n[0] + e - 1) / e) * ((n[1] + e - 1) / e);
}

static void expect_little(const struct scene *s, const struct brick_build_report *r)
{
    uint64_t row = bricks_a_row(s), slice = s->report.input_bytes / s->source.base.geometry.dims[2];
    /* It may have been killed while writing the checkpoint that follows. */
    assert_true(r->bricks_decoded <= (ROWS_BETWEEN + 1) * row);
    uint64_t left = s->report.bricks - r->bricks_kept; /* of level 0, at most */
    uint64_t rows = left / row + 1 + 2 * ROWS_BETWEEN;
    assert_true(r->source_bytes <= (rows * s->params.edge + s->params.border) * slice);
}

/* Of each type, lossless and not: wherever it is killed, no more is decoded than was made since the last
 * checkpoint, and the source is read again from little before that. */
static void little_is_done_again(void **state)
{
    (void)state;
    const struct {
        enum brick_type type;
        enum brick_codec codec;
    } ways[] = {{BRICK_U8, BRICK_CODEC_NONE}, {BRICK_I8, BRICK_CODEC_ZSTD}, {BRICK_U16, BRICK_CODEC_LZ4},
                {BRICK_I16, BRICK_CODEC_LZ4}, {BRICK_F32, BRICK_CODEC_LZ4}, {BRICK_I16, BRICK_CODEC_ZFP},
                {BRICK_F32, BRICK_CODEC_ZFP}};
    for (size_t w = 0; w < sizeof ways / sizeof ways[0]; w++) {
        struct scene s;
        if (!brick_codec_is_built(ways[w].codec))
            continue;
        tower_init(&s, ways[w].type);
        s.params.codec = ways[w].codec;
        s.params.tolerance = brick_codec_is_lossy(ways[w].codec) ? 1.5 : 0.0;
        scene_ready(&s);
        assert_int_equal(s.report.bricks_decoded, 0);
        killed_later_and_later(&s, 40, expect_little);
        scene_finish(&s);
    }
}

static void expect_less_than_all(const struct scene *s, const struct brick_build_report *r)
{
    assert_true(r->bricks_decoded < s->report.bricks);
    if (r->bricks_kept > s->report.bricks * 3 / 4)
        assert_true(r->bricks_decoded <= s->report.bricks / 2);
}

/* Axes that are halved in turn, not together: coarser levels wait for other slices. */
static void axes_halved_in_turn(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++)
        for (int flat = 0; flat < 2; flat++) {
            struct scene s;
            scene_init(&s, BRICK_U8, (uint64_t[]){40, 36, 150}, 8);
            for (int a = 0; a < 3; a++)
                s.source.base.geometry.affine[a][a] = (a == axis) == flat ? 5.0 : 1.0;
            s.params.nearest = axis == 1;
            scene_ready(&s);
            killed_later_and_later(&s, 12, expect_less_than_all);
            scene_finish(&s);
        }
}

/* At every write, while the first few checkpoints are made. */
static void killed_around_checkpoints(void **state)
{
    (void)state;
    struct scene s;
    uint64_t kept, most = 0;
    tower_init(&s, BRICK_U16);
    scene_ready(&s);
    for (unsigned long at = 0; at < s.calls; at += at < s.calls / 3 ? 1 : 7) {
        scene_kill(&s, false, at % 2 ? FAULT_TORN : FAULT_KILL, at, &kept);
        most = kept > most ? kept : most;
    }
    assert_int_equal(most, s.report.bricks);
    scene_finish(&s);
}

/* A run that is killed again and again goes on from its own checkpoints; in the end all is the same. */
static void killed_many_times_over(void **state)
{
    (void)state;
    struct scene s;
    struct brick_error err;
    struct rest rest;
    tower_init(&s, BRICK_I16);
    scene_ready(&s);
    rest_take(&rest, &s, s.calls / 10);
    rest_put(&rest, &s);
    for (unsigned turn = 0; turn < 8; turn++) {
        s.params.threads = 1 + turn % 2;
        faults_arm(FAULT_ONCE, s.calls / 10, 5);
        assert_int_equal(scene_build(&s, true, NULL, &err), BRICK_ERR_IO);
    }
    struct brick_build_report r = scene_resumes(&s, "the last time", 0);
    assert_true(r.bricks_kept > s.report.bricks / 2);
    assert_true(r.bricks_decoded <= (ROWS_BETWEEN + 1) * bricks_a_row(&s));
    rest_finish(&rest);
    scene_finish(&s);
}

/* A byte anywhere in the journal, of every note too: what follows it is made again. */
static void flipped_bytes_in_notes(void **state)
{
    (void)state;
    struct scene s;
    struct rest rest;
    uint64_t decoded = 0, whole;
    tower_init(&s, BRICK_U8);
    scene_ready(&s);
    rest_take(&rest, &s, s.calls * 9 / 10);
    rest_put(&rest, &s);
    whole = scene_resumes(&s, "whole", 0).bricks_kept;
    unsigned char *journal = rest.bytes[SCENE_JOURNAL];
    size_t n = rest.size[SCENE_JOURNAL];
    for (size_t at = n - 1; at > n / 100; at -= n / 150) {
        journal[at] ^= 0x10;
        rest_put(&rest, &s);
        struct brick_build_report r = scene_resumes(&s, "a byte of the journal is another", at);
        assert_true(r.bricks_kept <= whole);
        decoded = r.bricks_decoded > decoded ? r.bricks_decoded : decoded;
        journal[at] ^= 0x10;
    }
    assert_true(decoded <= (ROWS_BETWEEN + 1) * bricks_a_row(&s));
    rest_finish(&rest);
    scene_finish(&s);
}

/* A damaged brick before all checkpoints: none of them counts, and what is there is kept as ever. */
static void damaged_bricks_before_notes(void **state)
{
    (void)state;
    struct scene s;
    struct rest rest;
    tower_init(&s, BRICK_U8);
    s.params.codec = BRICK_CODEC_NONE;
    scene_ready(&s);
    rest_take(&rest, &s, s.calls * 9 / 10);
    for (size_t i = 0; i < SCENE_FILES; i++) {
        unsigned char *bytes = rest.bytes[i];
        size_t n = rest.size[i];
        if (i == SCENE_JOURNAL)
            continue;
        for (unsigned turn = 0; turn < 12; turn++) {
            size_t at = n * (2 * turn + 1) / 24;
            bytes[at] ^= 1;
            rest_put(&rest, &s);
            struct brick_build_report r = scene_resumes(&s, "a brick before it is damaged", turn);
            assert_true(r.bricks_decoded <= (ROWS_BETWEEN + 1) * bricks_a_row(&s));
            bytes[at] ^= 1;
        }
    }
    /* The file of coarser levels is gone: no brick of theirs, nor any that came after the first, is there. */
    free(rest.bytes[SCENE_LEVELS]);
    rest.bytes[SCENE_LEVELS] = calloc(1, 1);
    rest.size[SCENE_LEVELS] = 0;
    rest_put(&rest, &s);
    struct brick_build_report r = scene_resumes(&s, "without coarser levels", 0);
    assert_true(r.bricks_kept > 0 && r.bricks_kept < s.report.bricks / 10);
    rest_finish(&rest);
    scene_finish(&s);
}

/* The last note in a journal, as libbrick/store/journal.h has it: where its block begins. */
static size_t find_last_note(const unsigned char *journal, size_t size)
{
    uint64_t identity, head[3];
    size_t note = 0;
    memcpy(&identity, journal + 8, sizeof identity);
    for (size_t at = 24 + identity; at + sizeof head <= size; at += sizeof head + head[1]) {
        memcpy(head, journal + at, sizeof head);
        if (head[0] == 255)
            note = at;
    }
    assert_true(note > 0);
    return note;
}

/* Notes that no conversion writes, with the right checksum: one line, no more. */
static void forged_notes(void **state)
{
    (void)state;
    struct scene s;
    struct rest rest;
    struct brick_error err;
    tower_init(&s, BRICK_U8);
    scene_ready(&s);
    rest_take(&rest, &s, s.calls * 9 / 10);
    unsigned char *journal = rest.bytes[SCENE_JOURNAL];
    size_t at = find_last_note(journal, rest.size[SCENE_JOURNAL]), first_bin = 24 + 56;
    const struct {
        size_t where;
        uint64_t number;
    } forgeries[] = {{24, 0},          {24, 38},           {24, 40}, {24, 1 << 20}, {24, UINT64_MAX},
                     {32, UINT64_MAX}, {first_bin, 65536}, {24, 36}, {32, 1 << 30}, {first_bin, UINT64_MAX}};
    for (size_t i = 0; i < sizeof forgeries / sizeof forgeries[0]; i++) {
        uint64_t head[3], was, checksum;
        memcpy(head, journal + at, sizeof head);
        memcpy(&was, journal + at + forgeries[i].where, sizeof was);
        memcpy(journal + at + forgeries[i].where, &forgeries[i].number, sizeof was);
        checksum = XXH3_64bits_withSeed(journal + at + sizeof head, head[1], 256 * at + 255);
        memcpy(journal + at + 16, &checksum, sizeof checksum);
        rest_put(&rest, &s);
        assert_int_equal(scene_build(&s, true, NULL, &err), BRICK_ERR_FORMAT);
        assert_null(strchr(err.message, '\n'));
        memcpy(journal + at, head, sizeof head);
        memcpy(journal + at + forgeries[i].where, &was, sizeof was);
    }
    rest_put(&rest, &s);
    assert_true(scene_resumes(&s, "not forged", 0).bricks_decoded <= (ROWS_BETWEEN + 1) * bricks_a_row(&s));
    rest_finish(&rest);
    scene_finish(&s);
}

/* Begun in tiles and with scratch files, gone on with in whole rows and in memory, and the other way round.
 */
static void with_tiles_and_scratch_files(void **state)
{
    (void)state;
    struct scene s;
    uint64_t caps[2] = {UINT64_C(19) << 20, UINT64_C(512) << 20};
    scene_init(&s, BRICK_I16, (uint64_t[]){397, 381, 70}, 8);
    for (unsigned way = 0; way < 2; way++) {
        s.params.memory_bytes = caps[way];
        scene_ready(&s);
        assert_int_equal(s.report.tiled && s.report.spooled_bytes, way == 0);
        for (unsigned turn = 5; turn < 10; turn++) {
            struct rest rest;
            s.params.memory_bytes = caps[way];
            rest_take(&rest, &s, s.calls * turn / 10);
            for (unsigned other = 0; other < 2; other++) {
                rest_put(&rest, &s);
                s.params.memory_bytes = caps[other];
                s.params.threads = 1 + other;
                struct brick_build_report r = scene_resumes(&s, "killed", turn);
                assert_true(r.bricks_kept > s.report.bricks / 3);
                assert_true(r.bricks_decoded <= (ROWS_BETWEEN + 1) * bricks_a_row(&s));
            }
            s.params.threads = 1;
            rest_finish(&rest);
        }
        free(s.good);
        s.good = NULL;
    }
    scene_finish(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(little_is_done_again),
        cmocka_unit_test(axes_halved_in_turn),
        cmocka_unit_test(killed_around_checkpoints),
        cmocka_unit_test(killed_many_times_over),
        cmocka_unit_test(flipped_bytes_in_notes),
        cmocka_unit_test(damaged_bricks_before_notes),
        cmocka_unit_test(forged_notes),
        cmocka_unit_test(with_tiles_and_scratch_files),
    };
    return cmocka_run_group_tests_name("checkpoints", tests, NULL, NULL);
}
