#include "interrupted.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

void scene_put_old_target(const struct scene *s)
{
    write_file(s->path, "keep", 4);
}

bool scene_target_is(const struct scene *s, const void *data, size_t bytes)
{
    size_t found_bytes;
    void *found = read_file(s->path, &found_bytes);
    bool same = found && found_bytes == bytes && memcmp(found, data, bytes) == 0;
    free(found);
    return same;
}

void scene_init(struct scene *s, enum brick_type type, const uint64_t n[3], uint32_t edge)
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
    s->left[SCENE_PART] = strdup(test_path("a.brick.part"));
    s->left[SCENE_JOURNAL] = strdup(test_path("a.brick.part.journal"));
    s->left[SCENE_LEVELS] = strdup(test_path("a.brick.part.levels"));
}

int scene_build(const struct scene *s, bool resume, struct brick_build_report *report,
                struct brick_error *err)
{
    struct memory_source source = s->source;
    struct brick_build_params params = s->params;
    params.resume = resume;
    memset(err, 0, sizeof *err);
    return brick_build(&source.base, s->path, &params, report, err);
}

void scene_ready(struct scene *s)
{
    struct brick_error err;
    faults_arm(FAULT_NONE, 0, 0);
    if (scene_build(s, false, &s->report, &err))
        fail_msg("%s", err.message);
    s->calls = faults_calls();
    s->good = read_file(s->path, &s->good_bytes);
    for (size_t i = 0; i < SCENE_FILES; i++)
        assert_int_not_equal(access(s->left[i], F_OK), 0);
}

void scene_finish(struct scene *s)
{
    free(s->voxels);
    free(s->good);
    free((void *)s->path);
    for (size_t i = 0; i < SCENE_FILES; i++)
        free((void *)s->left[i]);
}

void scene_expect_incomplete(const struct scene *s, const char *when, unsigned long at)
{
    struct brick_error err;
    struct brick_volume *v;
    if (brick_volume_open(&v, s->left[SCENE_PART], &err) == 0)
        fail_msg("%s at call %lu: what is left opens as complete", when, at);
}

struct brick_build_report scene_resumes(const struct scene *s, const char *when, unsigned long at)
{
    struct brick_build_report report = {0};
    struct brick_error err;
    faults_arm(FAULT_NONE, 0, 0);
    if (scene_build(s, true, &report, &err))
        fail_msg("%s at call %lu: resuming fails: %s", when, at, err.message);
    if (!scene_target_is(s, s->good, s->good_bytes))
        fail_msg("%s at call %lu: other bytes", when, at);
    for (size_t i = 0; i < SCENE_FILES; i++)
        assert_int_not_equal(access(s->left[i], F_OK), 0);
    return report;
}

void scene_kill(const struct scene *s, bool resume, enum fault fault, unsigned long at, uint64_t *kept)
{
    const char *name = fault == FAULT_TORN ? "killed within" : "killed";
    scene_put_old_target(s);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct brick_error err;
        faults_arm(fault, at, 0);
        _exit(scene_build(s, resume, NULL, &err) != 0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    bool killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
    assert_true(killed || (WIFEXITED(status) && WEXITSTATUS(status) == 0));
    bool complete = scene_target_is(s, s->good, s->good_bytes);
    if (!complete && !scene_target_is(s, "keep", 4))
        fail_msg("%s at call %lu: half a target", name, at);
    *kept = scene_resumes(s, name, at).bricks_kept;
    if (complete) /* there was nothing left to keep, nor to do */
        *kept = s->report.bricks;
}

void rest_take(struct rest *rest, const struct scene *s, unsigned long at)
{
    pid_t child = fork();
    if (child == 0) {
        struct brick_error err;
        faults_arm(FAULT_TORN, at, 0);
        _exit(scene_build(s, false, NULL, &err) != 0);
    }
    assert_int_equal(waitpid(child, NULL, 0), child);
    for (size_t i = 0; i < SCENE_FILES; i++)
        assert_non_null(rest->bytes[i] = read_file(s->left[i], &rest->size[i]));
}

void rest_put(const struct rest *rest, const struct scene *s)
{
    for (size_t i = 0; i < SCENE_FILES; i++)
        write_file(s->left[i], rest->bytes[i], rest->size[i]);
}

void rest_finish(struct rest *rest)
{
    for (size_t i = 0; i < SCENE_FILES; i++)
        free(rest->bytes[i]);
}
