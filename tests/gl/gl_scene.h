/* What the renderer's tests share: volumes, transfer functions, and one picture in a line. */
#ifndef TESTS_GL_SCENE_H
#define TESTS_GL_SCENE_H

#include <renderer/renderer.h>

#include "memory_source.h"

/* NULL (and a line that says why) when this machine has no such context. */
struct vr_renderer *renderer_of(const struct brick_volume *volume, const struct vr_renderer_params *params);
struct vr_renderer *try_renderer(const struct brick_volume *volume, enum vr_context_kind kind);

/* A GPU cache of so many bricks as they are stored. */
uint64_t slots_bytes(const struct brick_volume *volume, uint64_t bricks);
/* Every mode with post-classification, dvr and shaded pre-integrated. */
#define WAYS 6
void set_way(int way, struct vr_scene *scene, struct vr_quality *quality);

/* Default parameters but for the brick's edge. */
struct brick_volume *volume_of(struct memory_source *source, uint32_t edge);

/* Points (value, r, g, b, A) in physical values, A per mm. Asserts success. */
struct brick_transfer *transfer_of(const struct brick_transfer_point *points, size_t count);

/* vr_render into a new image, asserting success. */
void render(struct vr_renderer *renderer, const struct vr_scene *scene, const struct vr_quality *quality,
            struct brick_image *image, struct vr_report *report);

/* Destroy them, transfer may be NULL; without a renderer there was nothing to test. */
void end_or_skip(struct vr_renderer **renderer, struct brick_transfer **transfer,
                 struct brick_volume **volume);

/* Both have the same bytes. */
void assert_same_image(const struct brick_image *a, const struct brick_image *b, const char *what);

#endif
