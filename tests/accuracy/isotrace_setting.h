/* What tests of isotrace's pictures share. */
#ifndef TESTS_ACCURACY_ISOTRACE_SETTING_H
#define TESTS_ACCURACY_ISOTRACE_SETTING_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <renderer/renderer.h>

#include "../support/memory_source.h"

/* Twice: the second frame knows where in the bricks surfaces are, and a frame of other surfaces in between
 * leaves nothing behind. */
static inline void render(const struct brick_volume *volume, const struct vr_isotracer_params *tracer_params,
                          const struct vr_scene *scene, const struct vr_isotrace_params *params,
                          struct brick_image *image, struct vr_report *report)
{
    struct vr_isotracer *tracer;
    struct brick_error err;
    struct vr_scene other = *scene;
    struct vr_isotrace_params one = *params;
    struct brick_image again;
    other.isovalue += 1.5;
    one.surface_count = 0;
    assert_int_equal(brick_image_init(image, scene->width, scene->height, NULL), BRICK_OK);
    assert_int_equal(brick_image_init(&again, scene->width, scene->height, NULL), BRICK_OK);
    if (vr_isotracer_create(&tracer, volume, tracer_params, &err) ||
        vr_render_isotrace(tracer, scene, params, image, report, &err))
        fail_msg("%s", err.message);
    for (int frame = 0; frame < 4; frame++) {
        if (vr_render_isotrace(tracer, frame == 1 ? &other : scene, frame == 1 ? &one : params, &again, NULL,
                               &err))
            fail_msg("%s", err.message);
        if (frame != 1)
            assert_memory_equal(image->rgba, again.rgba,
                                (size_t)scene->width * scene->height * 4 * sizeof(float));
    }
    brick_image_finish(&again);
    vr_isotracer_destroy(&tracer);
}

/* Keep what lies from a point on in a direction. */
static inline void clip_through(struct vr_scene *scene, const double point[3], double x, double y, double z)
{
    scene->clip[scene->clip_count++] =
        (struct vr_plane){{x, y, z}, x * point[0] + y * point[1] + z * point[2]};
}

static inline void add_square(struct brick_mesh *mesh, double x, double y, double z, double half)
{
    const uint64_t first = mesh->vertices, corners[4] = {first, first + 1, first + 2, first + 3};
    for (int k = 0; k < 4; k++)
        assert_int_equal(brick_mesh_add_vertex(mesh,
                                               (const double[]){x + (k == 1 || k == 2 ? half : -half),
                                                                y + (k > 1 ? half : -half), z},
                                               NULL, NULL, NULL),
                         0);
    assert_int_equal(brick_mesh_add_polygon(mesh, corners, 4, NULL), 0);
}

#endif
