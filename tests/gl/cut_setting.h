/* What tests of clip planes and of meshes share: a volume, a scene of it, and its picture by the raycaster
 * and by the exact method. */
#ifndef TESTS_GL_CUT_SETTING_H
#define TESTS_GL_CUT_SETTING_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_scene.h"

#define N    48
#define SIZE 64

struct setting {
    struct brick_volume *volume;
    struct vr_renderer *renderer; /* NULL: this machine has no context */
    struct brick_transfer *transfer;
    struct vr_scene scene;
    struct vr_quality quality;
};

/* Brighter towards the middle; nothing is visible farther than 18 from it. */
static inline double ball(int x, int y, int z)
{
    double dx = x - 23.5, dy = y - 23.5, dz = z - 23.5;
    return 1000.0 - 50.0 * sqrt(dx * dx + dy * dy + dz * dz);
}

static inline double same(int x, int y, int z)
{
    (void)x, (void)y, (void)z;
    return 500.0;
}

static inline void begin(struct setting *s, double (*field)(int, int, int), double start)
{
    static float voxels[N * N * N];
    const struct brick_transfer_point points[] = {{start, 0.9, 0.3, 0.1, 0.0}, {1000, 0.2, 0.9, 0.8, 0.2}};
    struct memory_source source;
    for (int i = 0; i < N * N * N; i++)
        voxels[i] = (float)field(i % N, i / N % N, i / N / N);
    memory_source_init(&source, BRICK_F32, N, N, N, voxels);
    *s = (struct setting){.scene = vr_scene_defaults, .quality = vr_quality_defaults};
    s->volume = volume_of(&source, 16);
    s->renderer = try_renderer(s->volume, VR_CONTEXT_AUTO);
    s->transfer = transfer_of(points, 2);
    s->scene.transfer = s->transfer;
    s->scene.width = s->scene.height = SIZE;
    s->scene.isovalue = 600.0;
    s->quality.termination = 0.0;
    brick_camera_orbit(&s->scene.camera, brick_volume_grid(s->volume), 25, 15, 0, 0, 1.0);
}

static inline void end(struct setting *s)
{
    bool drawn = s->renderer;
    vr_renderer_destroy(&s->renderer);
    brick_transfer_destroy(&s->transfer);
    brick_volume_close(&s->volume);
    if (!drawn)
        skip();
}

static inline void draw(struct setting *s, struct brick_image *image)
{
    render(s->renderer, &s->scene, &s->quality, image, NULL);
}

static inline void draw_exact(struct setting *s, struct brick_image *image, double *hit_mm)
{
    struct vr_exact_params params = vr_exact_defaults;
    struct brick_error err;
    params.hit_mm = hit_mm;
    assert_int_equal(brick_image_init(image, s->scene.width, s->scene.height, NULL), 0);
    if (vr_render_exact(s->volume, &s->scene, &params, image, NULL, &err))
        fail_msg("%s", err.message);
}

static inline struct vr_plane plane_at(double nx, double ny, double nz, double distance)
{
    /* keeps the middle, `distance` from the plane */
    double length = sqrt(nx * nx + ny * ny + nz * nz);
    return (struct vr_plane){{nx, ny, nz}, 23.5 * (nx + ny + nz) - distance * length};
}

#endif
