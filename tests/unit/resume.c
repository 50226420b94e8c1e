/* Conversions that are killed, or that the system fails, at every write, sync and rename in turn: what they
 * leave is never taken for complete, and resumed they end with the bytes of one that was left alone. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../support/faults.h"
#include "../support/memory_source.h"

/* A conversion, and what it must come to. */
struct scene {
    struct memory_source source;
    struct brick_build_params params;
    void *voxels, *good;
    size_t good_bytes;
    struct brick_build_report report;
    unsigned long calls; /* of the system, when nothing fails */
    uint64_t level0;     /* bricks */
    const char *path, *part, *journal;
};

static void *read_file(const char *path, size_t *bytes)
{
    FILE *f = fopen(path, "rb");
    *bytes = 0;
    if (!f)
        return NULL;
    fseek(f, 0, SEEK_END);
    *bytes = (size_t)ftell(f);
    rewind(f);
    void *data = malloc(*bytes + 1);
    assert_int_equal(fread(data, 1, *bytes, f), *bytes);
    fclose(f);
    return data;
}

static void write_file(const char *path, const void *data, size_t bytes)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, bytes, f), bytes);
    assert_int_equal(fclose(f), 0);
}

static void put_old_target(const struct scene *s)
{
    write_file(s->path, "keep", 4);
}

static bool target_is(const struct scene *s, const void *data, size_t bytes)
{
    size_t found_bytes;
    void *found = read_file(s->path, &found_bytes);
    bool same = found && found_bytes == bytes && memcmp(found, data, bytes) == 0;
    free(found);
    return same;
}

/* u8 with air around it, so that some bricks are constant. */
static void scene_init(struct scene *s, enum brick_type type, const uint64_t n[3], uint32_t edge)
{
    memset(s, 0, sizeof *s);
    s->voxels = malloc(n[0] * n[1] * n[2] * brick_type_bytes(type));
    for (uint64_t i = 0; i < n[0] * n[1] * n[2]; i++) {
        double v = 0.0;
        for (uint64_t a = 0, rest = i; a < 3; rest /= n[a], a++)
            v += pow(2.0 * ((double)(rest % n[a]) + 0.5) / (double)n[a] - 1.0, 2.0);
        store_voxel(type, s->voxels, i, v > 0.8 ? 0.0 : floor(100.0 * v) + (double)(noise64(3, i) & 3));
    }
    memory_source_init(&s->source, type, n[0], n[1], n[2], s->voxels);
    s->params = brick_build_defaults;
    s->params.edge = edge;
    s->params.threads = 1;
    s->path = strdup(test_path("a.brick"));
    s->part = strdup(test_path("a.brick.part"));
    s->journal = strdup(test_path("a.brick.part.journal"));
}

static int build(const struct scene *s, bool resume, struct brick_build_report *report,
                 struct brick_error *err)
{
    struct memory_source source = s->source;
    struct brick_build_params params = s->params;
    params.resume = resume;
    memset(err, 0, sizeof *err);
    return brick_build(&source.base, s->path, &params, report, err);
}

/* Convert without any trouble. */
static void scene_ready(struct scene *s)
{
    struct brick_error err;
    faults_arm(FAULT_NONE, 0, 0);
    if (build(s, false, &s->report, &err))
        fail_msg("%s", err.message);
    s->calls = faults_calls();
    s->good = read_file(s->path, &s->good_bytes);
    struct brick_volume *v;
    assert_int_equal(brick_volume_open(&v, s->path, &err), 0);
    const struct brick_level *level = brick_volume_grid(v)->level;
    s->level0 = level->bricks[0] * level->bricks[1] * level->bricks[2];
    brick_volume_close(&v);
    assert_int_not_equal(access(s->part, F_OK), 0);
    assert_int_not_equal(access(s->journal, F_OK), 0);
}

static void scene_finish(struct scene *s)
{
    free(s->voxels);
    free(s->good);
    free((void *)s->path);
    free((void *)s->part);
    free((void *)s->journal);
}

static void expect_incomplete(const struct scene *s, const char *when, unsigned long at)
{
    struct brick_error err;
    struct brick_volume *v;
    if (brick_volume_open(&v, s->part, &err) == 0)
        fail_msg("%s at call %lu: what is left opens as complete", when, at);
}

/* Resuming with nothing in the way; how many bricks were kept. */
static uint64_t expect_resumes(const struct scene *s, const char *when, unsigned long at)
{
    struct brick_build_report report = {0};
    struct brick_error err;
    faults_arm(FAULT_NONE, 0, 0);
    if (build(s, true, &report, &err))
        fail_msg("%s at call %lu: resuming fails: %s", when, at, err.message);
    if (!target_is(s, s->good, s->good_bytes))
        fail_msg("%s at call %lu: other bytes", when, at);
    assert_int_not_equal(access(s->part, F_OK), 0);
    assert_int_not_equal(access(s->journal, F_OK), 0);
    return report.bricks_kept;
}

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
    put_old_target(s);
    faults_arm(failures[kind].fault, at, failures[kind].error);
    int code = build(s, resume, NULL, &err);
    faults_arm(FAULT_NONE, 0, 0);
    if (code == 0) {
        /* Nothing failed, or only what comes after the file has its name. */
        if (!target_is(s, s->good, s->good_bytes))
            fail_msg("%s at call %lu: success with other bytes", name, at);
        return;
    }
    if (code != BRICK_ERR_IO || !strstr(err.message, strerror(failures[kind].error)) ||
        strchr(err.message, '\n'))
        fail_msg("%s at call %lu: said '%s'", name, at, err.message);
    if (!target_is(s, "keep", 4))
        fail_msg("%s at call %lu: the target was touched", name, at);
    bool left = access(s->part, F_OK) == 0;
    assert_int_equal(left, access(s->journal, F_OK) == 0);
    expect_incomplete(s, name, at);
    bool said = strstr(err.message, "--resume") != NULL;
    uint64_t kept = expect_resumes(s, name, at);
    if (!resume) {
        assert_int_equal(left, kept > 0);
        assert_int_equal(left, said);
    }
}

/* *kept: bricks that resuming did not make again. */
static void kill_one(const struct scene *s, bool resume, enum fault fault, unsigned long at, uint64_t *kept)
{
    const char *name = fault == FAULT_TORN ? "killed within" : "killed";
    put_old_target(s);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct brick_error err;
        faults_arm(fault, at, 0);
        _exit(build(s, resume, NULL, &err) != 0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    bool killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
    assert_true(killed || (WIFEXITED(status) && WEXITSTATUS(status) == 0));
    bool complete = target_is(s, s->good, s->good_bytes);
    if (!complete && !target_is(s, "keep", 4))
        fail_msg("%s at call %lu: half a target", name, at);
    *kept = expect_resumes(s, name, at);
    if (complete) /* there was nothing left to keep, nor to do */
        *kept = s->level0;
}

static void every_call_fails_in_turn(void **state)
{
    (void)state;
    struct scene s;
    scene_init(&s, BRICK_U8, (uint64_t[]){44, 40, 36}, 8);
    scene_ready(&s);
    assert_true(s.calls > 150 && s.level0 > 2 * 64);
    for (size_t kind = 0; kind < sizeof failures / sizeof failures[0]; kind++)
        for (unsigned long at = 0; at < s.calls; at++)
            fail_one(&s, false, kind, at);
    /* Writes that do half of what they are asked for are no failure. */
    struct brick_error err;
    put_old_target(&s);
    faults_arm(FAULT_SHORT, 0, 0);
    if (build(&s, false, NULL, &err))
        fail_msg("%s", err.message);
    assert_true(faults_calls() > 3 * s.calls);
    assert_true(target_is(&s, s.good, s.good_bytes));
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
        kill_one(&s, false, at % 2 ? FAULT_TORN : FAULT_KILL, at, &kept);
        most = kept > most ? kept : most;
    }
    assert_int_equal(most, s.level0);
    scene_finish(&s);
}

/* What a killed conversion leaves, to be put back as often as it is needed. */
struct rest {
    void *part, *journal;
    size_t part_bytes, journal_bytes;
};

static void rest_take(struct rest *rest, const struct scene *s, unsigned long at)
{
    pid_t child = fork();
    if (child == 0) {
        struct brick_error err;
        faults_arm(FAULT_TORN, at, 0);
        _exit(build(s, false, NULL, &err) != 0);
    }
    assert_int_equal(waitpid(child, NULL, 0), child);
    rest->part = read_file(s->part, &rest->part_bytes);
    rest->journal = read_file(s->journal, &rest->journal_bytes);
    assert_true(rest->part && rest->journal);
}

static void rest_put(const struct rest *rest, const struct scene *s)
{
    write_file(s->part, rest->part, rest->part_bytes);
    write_file(s->journal, rest->journal, rest->journal_bytes);
}

static void rest_finish(struct rest *rest)
{
    free(rest->part);
    free(rest->journal);
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
            first = expect_resumes(&s, "killed", turn);
            rest_put(&rest, &s);
            kill_one(&s, true, FAULT_KILL, 100 + 37 * turn, &kept);
            assert_true(kept >= first);
            if (turn == 9) /* nearly all of level 0's writes are done by then */
                assert_true(kept >= s.level0 * 6 / 10);
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
                kill_one(&s, true, at % 2 ? FAULT_TORN : FAULT_KILL, at, &kept);
            else
                fail_one(&s, true, at % 2, at);
            assert_true(!kind || kept >= 64);
        }
    rest_finish(&rest);
    scene_finish(&s);
}

/* A power cut keeps no order among what was not synced: parts of the files may be missing. */
static void damage_is_made_again(void **state)
{
    (void)state;
    struct scene s;
    struct rest rest;
    scene_init(&s, BRICK_U8, (uint64_t[]){90, 88, 59}, 8);
    scene_ready(&s);
    rest_take(&rest, &s, s.calls * 8 / 10);
    rest_put(&rest, &s);
    uint64_t all = expect_resumes(&s, "whole", 0), least = all;
    assert_true(all > s.level0 / 2);
    for (unsigned turn = 0; turn < 60; turn++) {
        struct rest hurt = rest;
        size_t at = noise64(turn, 0) % rest.part_bytes, n = 1 + noise64(turn, 1) % 5000;
        unsigned char *part = malloc(rest.part_bytes), *journal = malloc(rest.journal_bytes);
        memcpy(part, rest.part, rest.part_bytes);
        memcpy(journal, rest.journal, rest.journal_bytes);
        hurt.part = part;
        hurt.journal = journal;
        if (turn % 3 == 0) {
            hurt.part_bytes = at;
        } else if (turn % 3 == 1) {
            memset(part + at, 0, at + n < rest.part_bytes ? n : rest.part_bytes - at);
        } else {
            at = noise64(turn, 2) % rest.journal_bytes;
            if (turn % 2)
                memset(journal + at, 0, rest.journal_bytes - at);
            else
                hurt.journal_bytes = at;
        }
        rest_put(&hurt, &s);
        s.params.threads = 1 + turn % 3;
        uint64_t kept = expect_resumes(&s, "damaged", turn);
        assert_true(kept <= all);
        least = kept < least ? kept : least;
        free(part);
        free(journal);
    }
    assert_true(least < all);
    rest_finish(&rest);
    scene_finish(&s);
}

static void refuses(const struct scene *s, const struct rest *rest, const char *was, const char *now)
{
    struct brick_error err;
    size_t part_bytes, journal_bytes;
    rest_put(rest, s);
    put_old_target(s);
    assert_int_equal(build(s, true, NULL, &err), BRICK_ERR_ARGUMENT);
    if (!strstr(err.message, was) || !strstr(err.message, now))
        fail_msg("said '%s', not '%s' and '%s'", err.message, was, now);
    assert_true(target_is(s, "keep", 4));
    void *part = read_file(s->part, &part_bytes), *journal = read_file(s->journal, &journal_bytes);
    assert_int_equal(part_bytes, rest->part_bytes);
    assert_memory_equal(part, rest->part, part_bytes);
    assert_int_equal(journal_bytes, rest->journal_bytes);
    assert_memory_equal(journal, rest->journal, journal_bytes);
    free(part);
    free(journal);
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
    expect_resumes(&s, "after refusals", 0);

    /* Without --resume what is there does not count. */
    struct brick_error err;
    struct brick_build_report report;
    rest_put(&rest, &s);
    assert_int_equal(build(&s, false, &report, &err), 0);
    assert_int_equal(report.bricks_kept, 0);
    assert_true(target_is(&s, s.good, s.good_bytes));
    assert_int_not_equal(access(s.part, F_OK), 0);
    assert_int_not_equal(access(s.journal, F_OK), 0);
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
