/* Conversions that are interrupted and resumed, for tests that are linked with faults.c. All of it asserts.
 */
#ifndef TESTS_INTERRUPTED_H
#define TESTS_INTERRUPTED_H

#include "faults.h"
#include "memory_source.h"

/* What a killed conversion leaves. */
enum { SCENE_PART, SCENE_JOURNAL, SCENE_LEVELS, SCENE_FILES };

/* A conversion, and what it must come to. */
struct scene {
    struct memory_source source;
    struct brick_build_params params;
    void *voxels, *good;
    size_t good_bytes;
    struct brick_build_report report;
    unsigned long calls; /* of the system, when nothing fails */
    const char *path, *left[SCENE_FILES];
};

/* With air around it, so that some bricks are constant; params may be changed afterwards. */
void scene_init(struct scene *scene, enum brick_type type, const uint64_t n[3], uint32_t edge);
/* Convert without any trouble: what it comes to. */
void scene_ready(struct scene *scene);
void scene_finish(struct scene *scene);
int scene_build(const struct scene *scene, bool resume, struct brick_build_report *report,
                struct brick_error *err);
/* Another file in its place. */
void scene_put_old_target(const struct scene *scene);
bool scene_target_is(const struct scene *scene, const void *data, size_t bytes);
/* when, at: for messages. */
void scene_expect_incomplete(const struct scene *scene, const char *when, unsigned long at);
/* Resume with nothing in the way. */
struct brick_build_report scene_resumes(const struct scene *scene, const char *when, unsigned long at);
/* Kill it at a call of the system (FAULT_KILL, FAULT_TORN), resuming or not; then resume it. *kept: bricks
 * that were not made again. */
void scene_kill(const struct scene *scene, bool resume, enum fault fault, unsigned long at, uint64_t *kept);

/* What a killed conversion leaves, to be put back as often as it is needed. */
struct rest {
    void *bytes[SCENE_FILES];
    size_t size[SCENE_FILES];
};
void rest_take(struct rest *rest, const struct scene *scene, unsigned long at);
void rest_put(const struct rest *rest, const struct scene *scene);
void rest_finish(struct rest *rest);

#endif
