/* Conversions that are killed, or that the system fails, at every write, sync and rename in turn: what they
 * leave is never taken for complete, and resumed they end with the bytes of one that was left alone. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../support/interrupted.h"

static const struct {
    const char *name;
    enum fault fault;
    int error;
} failures[] = {{"a full disk", FAULT_FULL, ENOSPC}, {"a failing disk", FAULT_ONCE, EIO}};

/* One call fails. In the end the file is complete, or untouched with one line about it. */
static void fail_one(const struct scene *s, bool resume, size_t kind, unsigned long at)
{
    struct brick_error err;
    const char *name = failures[kind].name;
    scene_put_old_target(s);
    faults_arm(failures[kind].fault, at, failures[kind].error);
    int code = scene_build(s, resume, NULL, &err);
    faults_arm(FAULT_NONE, 0, 0);
    if (code == 0) {
        /* Nothing failed, or only what comes after the file has its name. */
        if (!scene_target_is(s, s->good, s->good_bytes))
            fail_msg("%s at call %lu: success with other bytes", name, at);
        return;
    }
    if (code != BRICK_ERR_IO || !strstr(err.message, strerror(failures[kind].error)) ||
        strchr(err.message, '\n'))
        fail_msg("%s at call %lu: said '%s'", name, at, err.message);
    if (!scene_target_is(s, "keep", 4))
        fail_msg("%s at call %lu: the target was touched", name, at);
    bool left = access(s->left[SCENE_PART], F_OK) == 0;
    for (size_t i = 0; i < SCENE_FILES; i++)
        assert_int_equal(left, access(s->left[i], F_OK) == 0);
    scene_expect_incomplete(s, name, at);
    bool said = strstr(err.message, "--resume") != NULL;
    uint64_t kept = scene_resumes(s, name, at).bricks_kept;
    if (!resume) {
        assert_int_equal(left, kept > 0);
        assert_int_equal(left, said);
    }
}

static void every_call_fails_in_turn(void **state)
{
    (void)state;
    struct scene s;
    scene_init(&s, BRICK_U8, (uint64_t[]){44, 40, 36}, 8);
    scene_ready(&s);
    assert_true(s.calls > 150 && s.report.bricks > 2 * 64);
    for (size_t kind = 0; kind < sizeof failures / sizeof failures[0]; kind++)
        for (unsigned long at = 0; at < s.calls; at++)
            fail_one(&s, false, kind, at);
    /* Writes that do half of what they are asked for are no failure. */
    struct brick_error err;
    scene_put_old_target(&s);
    faults_arm(FAULT_SHORT, 0, 0);
    if (scene_build(&s, false, NULL, &err))
        fail_msg("%s", err.message);
    assert_true(faults_calls() > 3 * s.calls);
    assert_true(scene_target_is(&s, s.good, s.good_bytes));
    scene_finish(&s);
}

static void killed_at_every_call_in_turn(void **state)
{
    (void)state;
    struct scene s;
    scene_init(&s, BRICK_U8, (uint64_t[]){44, 40, 36}, 8);
    scene_ready(&s);
    uint64_t kept = 0, most = 0;
    for (unsigned long at = 0; at < s.calls; at++) {
        scene_kill(&s, false, at % 2 ? FAULT_TORN : FAULT_KILL, at, &kept);
        most = kept > most ? kept : most;
    }
    assert_int_equal(most, s.report.bricks);
    scene_finish(&s);
}

/* Of every type and codec, in every way of reading, on other threads; twice interrupted. */
static void all_ways_resume(void **state)
{
    (void)state;
    const struct {
        enum brick_type type;
        enum brick_codec codec;
        uint64_t n[3];
        uint32_t edge;
        uint64_t memory_bytes;
        bool nearest, boxes;
    } ways[] = {
        {BRICK_U8, BRICK_CODEC_NONE, {64, 64, 64}, 8, 80 << 20, false, true},
        {BRICK_I8, BRICK_CODEC_ZSTD_DELTA, {33, 129, 65}, 8, 80 << 20, true, true},
        {BRICK_F32, BRICK_CODEC_LZ4, {64, 64, 64}, 8, 80 << 20, false, false},
        {BRICK_F32, BRICK_CODEC_ZSTD, {64, 64, 64}, 8, 80 << 20, true, true},
        {BRICK_U16, BRICK_CODEC_LZ4, {397, 381, 43}, 16, 19 << 20, false, true},
        {BRICK_I16, BRICK_CODEC_LZ4, {397, 381, 43}, 16, 24 << 20, false, false},
        {BRICK_I16, BRICK_CODEC_ZFP, {64, 64, 64}, 8, 80 << 20, false, true},
        {BRICK_F32, BRICK_CODEC_ZFP, {397, 120, 43}, 16, 32 << 20, false, true},
    };
    bool tiled = false, spooled = false;
    for (size_t w = 0; w < sizeof ways / sizeof ways[0]; w++) {
        if (!brick_codec_is_built(ways[w].codec))
            continue;
        struct scene s;
        scene_init(&s, ways[w].type, ways[w].n, ways[w].edge);
        if (ways[w].type == BRICK_F32) /* NaN of all kinds, in whole bricks and beside values */
            for (size_t i = 0; i < 64 * 64 * 17; i++) {
                uint32_t bits = i % 64 < 20 ? 0x7f800001u : i % 64 == 40 ? 0xffc01234u : 0;
                if (bits)
                    memcpy((uint32_t *)s.voxels + i, &bits, sizeof bits);
            }
        s.params.codec = ways[w].codec;
        s.params.tolerance = brick_codec_is_lossy(ways[w].codec) ? 1.5 : 0.0;
        s.params.memory_bytes = ways[w].memory_bytes;
        s.params.nearest = ways[w].nearest;
        if (!ways[w].boxes)
            s.source.base.read_box = NULL;
        scene_ready(&s);
        tiled = tiled || (s.report.tiled && s.report.spooled_bytes);
        spooled = spooled || (!s.report.tiled && s.report.spooled_bytes);
        for (unsigned turn = 0; turn < 10; turn++) {
            struct rest rest;
            uint64_t first = 0, kept = 0;
            rest_take(&rest, &s, s.calls * (2 * turn + 1) / 21);
            if (turn % 2) { /* more threads and memory, so another plan */
                s.params.threads = 2 + turn % 3;
                s.params.memory_bytes = 128 << 20;
            }
            first = scene_resumes(&s, "killed", turn).bricks_kept;
            rest_put(&rest, &s);
            scene_kill(&s, true, FAULT_KILL, 100 + 37 * turn, &kept);
            assert_true(kept >= first);
            if (turn == 9) /* nearly all writes are done by then */
                assert_true(kept >= s.report.bricks * 6 / 10);
            s.params.threads = 1;
            s.params.memory_bytes = ways[w].memory_bytes;
            rest_finish(&rest);
        }
        scene_finish(&s);
    }
    assert_true(tiled && spooled);
}

/* While resuming, too. */
static void every_call_of_resuming_fails_in_turn(void **state)
{
    (void)state;
    struct scene s;
    struct rest rest;
    scene_init(&s, BRICK_U8, (uint64_t[]){44, 40, 36}, 8);
    scene_ready(&s);
    rest_take(&rest, &s, s.calls * 6 / 10);
    for (unsigned long at = 0; at < s.calls; at++)
        for (size_t kind = 0; kind < 2; kind++) {
            uint64_t kept = 0;
            rest_put(&rest, &s);
            if (kind)
                scene_kill(&s, true, at % 2 ? FAULT_TORN : FAULT_KILL, at, &kept);
            else
                fail_one(&s, true, at % 2, at);
            assert_true(!kind || kept >= 64);
        }
    rest_finish(&rest);
    scene_finish(&s);
}

/* A power cut keeps no order among what was not synced: parts of the files may be missing, or be what was
 * there before. */
static void damage_is_made_again(void **state)
{
    (void)state;
    struct scene s;
    struct rest rest;
    scene_init(&s, BRICK_U8, (uint64_t[]){90, 88, 59}, 8);
    scene_ready(&s);
    rest_take(&rest, &s, s.calls * 8 / 10);
    rest_put(&rest, &s);
    uint64_t all = scene_resumes(&s, "whole", 0).bricks_kept, least[SCENE_FILES] = {all, all, all};
    assert_true(all > s.report.bricks / 2);
    for (unsigned turn = 0; turn < 90; turn++) {
        struct rest hurt = rest;
        size_t which = turn % SCENE_FILES, size = rest.size[which], at = noise64(turn, 0) % size;
        size_t n = 1 + noise64(turn, 1) % 5000;
        unsigned char *bytes = malloc(size);
        memcpy(bytes, rest.bytes[which], size);
        hurt.bytes[which] = bytes;
        if (turn / SCENE_FILES % 3 == 0)
            hurt.size[which] = at;
        else if (turn / SCENE_FILES % 3 == 1)
            memset(bytes + at, 0, at + n < size ? n : size - at);
        else
            bytes[at] ^= (unsigned char)(1 + noise64(turn, 2) % 255);
        rest_put(&hurt, &s);
        s.params.threads = 1 + turn % 3;
        uint64_t kept = scene_resumes(&s, "damaged", turn).bricks_kept;
        assert_true(kept <= all);
        least[which] = kept < least[which] ? kept : least[which];
        free(bytes);
    }
    for (size_t i = 0; i < SCENE_FILES; i++)
        assert_true(least[i] < all);
    rest_finish(&rest);
    scene_finish(&s);
}

static void refuses(const struct scene *s, const struct rest *rest, const char *was, const char *now)
{
    struct brick_error err;
    rest_put(rest, s);
    scene_put_old_target(s);
    assert_int_equal(scene_build(s, true, NULL, &err), BRICK_ERR_ARGUMENT);
    if (!strstr(err.message, was) || !strstr(err.message, now))
        fail_msg("said '%s', not '%s' and '%s'", err.message, was, now);
    assert_true(scene_target_is(s, "keep", 4));
    for (size_t i = 0; i < SCENE_FILES; i++) {
        size_t size;
        void *bytes = read_file(s->left[i], &size);
        assert_int_equal(size, rest->size[i]);
        assert_memory_equal(bytes, rest->bytes[i], size);
        free(bytes);
    }
}

static void changes_are_refused(void **state)
{
    (void)state;
    struct scene s, changed;
    struct rest rest;
    scene_init(&s, BRICK_U8, (uint64_t[]){44, 40, 36}, 8);
    scene_ready(&s);
    rest_take(&rest, &s, s.calls / 2);
    changed = s;
    changed.source.base.state = "other";
    refuses(&changed, &rest, "source: memory", "source: other");
    changed = s;
    changed.params.codec = BRICK_CODEC_ZSTD;
    refuses(&changed, &rest, "codec: lz4", "codec: zstd");
    changed = s;
    changed.params.edge = 16;
    refuses(&changed, &rest, "brick: 8", "brick: 16");
    changed = s;
    changed.params.nearest = true;
    refuses(&changed, &rest, "downsample: mean", "downsample: nearest");
    changed = s;
    changed.source.base.geometry.affine[1][3] = 5;
    refuses(&changed, &rest, "affine", "5");
    changed = s;
    changed.source.base.provenance = "format: other\n";
    refuses(&changed, &rest, "format: memory", "format: other");
    /* Unknown whether it has changed. */
    changed = s;
    changed.source.base.state = NULL;
    refuses(&changed, &rest, "cannot be resumed", "source");
    scene_resumes(&s, "after refusals", 0);

    /* Without --resume what is there does not count. */
    struct brick_error err;
    struct brick_build_report report;
    rest_put(&rest, &s);
    assert_int_equal(scene_build(&s, false, &report, &err), 0);
    assert_int_equal(report.bricks_kept, 0);
    assert_true(scene_target_is(&s, s.good, s.good_bytes));
    for (size_t i = 0; i < SCENE_FILES; i++)
        assert_int_not_equal(access(s.left[i], F_OK), 0);
    rest_finish(&rest);
    scene_finish(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_call_fails_in_turn), cmocka_unit_test(killed_at_every_call_in_turn),
        cmocka_unit_test(all_ways_resume),          cmocka_unit_test(every_call_of_resuming_fails_in_turn),
        cmocka_unit_test(damage_is_made_again),     cmocka_unit_test(changes_are_refused),
    };
    return cmocka_run_group_tests_name("resume", tests, NULL, NULL);
}
