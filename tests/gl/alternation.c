/* What one picture leaves in a renderer, caches and OpenGL's state, changes no other: every way of drawing,
 * after every other one, with the bytes that a renderer of its own draws. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "gl_scene.h"

#define N    44
#define SIZE 24

enum {
    CLIP = 1,
    MESH = 2,
    COARSE = 4,
    GEOMETRY = 8,
    STEPS = 16, /* drawn in steps, with coarser bricks standing in */
    BACK_TO_FRONT = 32,
    INDEPENDENT = 64,
    PERSPECTIVE = 128,
    OTHER_TRANSFER = 256
};

struct way {
    enum vr_method method;
    enum brick_mode mode;
    enum vr_classification classification;
    int what;
};

static const struct way ways[] = {
    {VR_METHOD_RAYCAST, BRICK_MODE_DVR, VR_CLASSIFY_POST, 0},
    {VR_METHOD_RAYCAST, BRICK_MODE_SHADED, VR_CLASSIFY_PREINTEGRATED, 0},
    {VR_METHOD_RAYCAST, BRICK_MODE_ISO, VR_CLASSIFY_POST, CLIP | GEOMETRY | PERSPECTIVE},
    {VR_METHOD_RAYCAST, BRICK_MODE_MIP, VR_CLASSIFY_POST, COARSE},
    {VR_METHOD_RAYCAST, BRICK_MODE_DVR, VR_CLASSIFY_POST, MESH | STEPS | PERSPECTIVE},
    {VR_METHOD_MULTIPASS, BRICK_MODE_SHADED, VR_CLASSIFY_POST, MESH | GEOMETRY},
    {VR_METHOD_MULTIPASS, BRICK_MODE_DVR, VR_CLASSIFY_POST, MESH | STEPS | CLIP},
    {VR_METHOD_MULTIPASS, BRICK_MODE_ISO, VR_CLASSIFY_POST, COARSE},
    {VR_METHOD_SLICES, BRICK_MODE_DVR, VR_CLASSIFY_POST, CLIP | PERSPECTIVE},
    {VR_METHOD_SLICES, BRICK_MODE_DVR, VR_CLASSIFY_PRE, 0},
    {VR_METHOD_SLICES, BRICK_MODE_DVR, VR_CLASSIFY_PRE, OTHER_TRANSFER},
    {VR_METHOD_SLICES, BRICK_MODE_SHADED, VR_CLASSIFY_POST, BACK_TO_FRONT},
    {VR_METHOD_SLICES, BRICK_MODE_MIP, VR_CLASSIFY_POST, 0},
    {VR_METHOD_SLICES, BRICK_MODE_DVR, VR_CLASSIFY_POST, INDEPENDENT | COARSE},
    {VR_METHOD_CELLS, BRICK_MODE_DVR, VR_CLASSIFY_POST, 0},
    {VR_METHOD_CELLS, BRICK_MODE_DVR, VR_CLASSIFY_POST, CLIP | COARSE | OTHER_TRANSFER},
};
#define WAYS_ALTERNATED (sizeof ways / sizeof *ways)

static const struct brick_transfer_point points[] = {
    {150, 0.2, 0.1, 0.1, 0.0}, {300, 0.9, 0.3, 0.1, 0.1}, {500, 0.1, 0.9, 0.1, 0.02}, {900, 1, 1, 0.9, 0.7}};
static const struct brick_transfer_point other_points[] = {
    {400, 0.1, 0.2, 0.9, 0.0}, {500, 0.1, 0.9, 0.9, 0.3}, {600, 0.9, 0.2, 0.1, 0.0}};

struct setting {
    struct brick_volume *volume;
    struct brick_transfer *transfer, *other, *independent;
    struct brick_mesh mesh;
    struct vr_mesh meshes[1];
};

static int16_t voxels[N * N * N];

static void make(struct setting *s)
{
    static const uint64_t faces[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    static const double corners[4][3] = {{4, 5, 6}, {41, 9, 11}, {19, 40, 8}, {21, 17, 39}};
    struct memory_source source;
    for (int i = 0; i < N * N * N; i++) {
        double x = i % N, y = i / N % N, z = i / N / N;
        double v = 1100.0 * sin(0.11 * x + 0.3) * sin(0.13 * y) * cos(0.09 * z) - 150.0;
        voxels[i] = (int16_t)(v < 0.0 ? 0.0 : v);
    }
    memory_source_init(&source, BRICK_I16, N, N, N, voxels);
    *s = (struct setting){.volume = volume_of(&source, 16),
                          .transfer = transfer_of(points, 4),
                          .other = transfer_of(other_points, 3),
                          .independent = transfer_of(points, 4)};
    brick_transfer_set_emission(s->independent, BRICK_EMISSION_INDEPENDENT);
    for (int v = 0; v < 4; v++)
        assert_int_equal(brick_mesh_add_vertex(&s->mesh, corners[v], NULL, NULL, NULL), 0);
    for (int f = 0; f < 4; f++)
        assert_int_equal(brick_mesh_add_polygon(&s->mesh, faces[f], 3, NULL), 0);
    s->meshes[0] = (struct vr_mesh){&s->mesh, {0.9, 0.8, 0.2}};
}

static void finish(struct setting *s)
{
    brick_transfer_destroy(&s->transfer);
    brick_transfer_destroy(&s->other);
    brick_transfer_destroy(&s->independent);
    brick_mesh_finish(&s->mesh);
    brick_volume_close(&s->volume);
}

static void set(const struct setting *s, const struct way *way, struct vr_scene *scene,
                struct vr_quality *quality)
{
    *scene = vr_scene_defaults;
    *quality = vr_quality_defaults;
    quality->method = way->method;
    quality->step_vox = 0.7;
    quality->classification = way->classification;
    quality->setup = way->what & GEOMETRY ? VR_SETUP_GEOMETRY : VR_SETUP_BOX;
    quality->slices.back_to_front = way->what & BACK_TO_FRONT;
    scene->mode = way->mode;
    scene->isovalue = 420.0;
    scene->transfer = way->what & OTHER_TRANSFER ? s->other
                      : way->what & INDEPENDENT  ? s->independent
                                                 : s->transfer;
    scene->level = way->what & COARSE ? 1 : 0;
    scene->width = scene->height = SIZE;
    brick_camera_orbit(&scene->camera, brick_volume_grid(s->volume), 35, 25, 60,
                       way->what & PERSPECTIVE ? 0 : 60, 1.0);
    if (way->what & CLIP) {
        scene->clip[0] = (struct vr_plane){{1, 0.5, -0.3}, 12.0};
        scene->clip_count = 1;
    }
    if (way->what & MESH) {
        scene->meshes = s->meshes;
        scene->mesh_count = 1;
    }
}

static void draw(struct vr_renderer *renderer, const struct setting *s, const struct way *way, bool in_steps,
                 struct brick_image *image)
{
    const struct vr_budget budget = {.upload_bytes = in_steps && way->what & STEPS ? 1 : 0};
    struct brick_error err = {0};
    struct vr_scene scene;
    struct vr_quality quality;
    bool final = false;
    set(s, way, &scene, &quality);
    assert_int_equal(brick_image_init(image, SIZE, SIZE, &err), 0);
    if (vr_render_begin(renderer, &scene, &quality, &err))
        fail_msg("%s", err.message);
    while (!final)
        if (vr_render_continue(renderer, &budget, image, &final, NULL, &err))
            fail_msg("%s", err.message);
}

/* Each way after each: i, i, then i and j in turns for every j above i. */
static void alternate(const struct setting *s, const struct vr_renderer_params *params, bool cells)
{
    static struct brick_image alone[WAYS_ALTERNATED];
    struct vr_renderer *shared = renderer_of(s->volume, params);
    size_t last = WAYS_ALTERNATED;
    const size_t count = cells ? WAYS_ALTERNATED : WAYS_ALTERNATED - 2;
    if (!shared)
        skip();
    for (size_t i = 0; i < count; i++) {
        struct vr_renderer_params own = *params;
        own.gpu_cache_bytes = vr_renderer_defaults.gpu_cache_bytes;
        struct vr_renderer *renderer = renderer_of(s->volume, &own);
        draw(renderer, s, &ways[i], false, &alone[i]);
        vr_renderer_destroy(&renderer);
    }
    for (size_t i = 0; i < count; i++)
        for (size_t turn = 0; turn < 2 * (count - i); turn++) {
            const size_t now = turn % 2 ? i + turn / 2 : i;
            struct brick_image image;
            char line[80];
            draw(shared, s, &ways[now], true, &image);
            snprintf(line, sizeof line, "way %zu after %zu", now, last);
            assert_same_image(&image, &alone[now], line);
            brick_image_finish(&image);
            last = now;
        }
    for (size_t i = 0; i < count; i++)
        brick_image_finish(&alone[i]);
    vr_renderer_destroy(&shared);
}

static void exact_filter(void **state)
{
    struct setting s;
    struct vr_renderer_params params = vr_renderer_defaults;
    (void)state;
    make(&s);
    params.gpu_cache_bytes = slots_bytes(s.volume, 12); /* of 27 bricks; of 6, where they hold colours */
    alternate(&s, &params, true);
    finish(&s);
}

static void fast_filter(void **state)
{
    struct setting s;
    struct vr_renderer_params params = vr_renderer_defaults;
    (void)state;
    make(&s);
    params.filter = VR_FILTER_FAST;
    alternate(&s, &params, false);
    finish(&s);
}

/* A brick that shows nothing comes for the gradients of samples at its edge, and stays on the list of bricks
 * that methods draw one after the other. */
static void bricks_of_gradients(void **state)
{
    /* Cells from voxel 15 to 16 of x show, which are the last ones of the first bricks. */
    static const struct brick_transfer_point last_cell[] = {
        {1500, 0.1, 0.2, 0.9, 0.0}, {1560, 0.1, 0.9, 0.9, 0.9}, {1590, 0.9, 0.2, 0.1, 0.0}};
    const struct way with_gradients = {VR_METHOD_RAYCAST, BRICK_MODE_SHADED, VR_CLASSIFY_PREINTEGRATED, 0};
    const struct way slices = {VR_METHOD_SLICES, BRICK_MODE_SHADED, VR_CLASSIFY_POST, 0};
    struct setting s = {.transfer = transfer_of(last_cell, 3)};
    struct memory_source source;
    struct brick_image image, alone;
    (void)state;
    for (int i = 0; i < N * N * N; i++)
        voxels[i] = (int16_t)(i % N * 100);
    memory_source_init(&source, BRICK_I16, N, N, N, voxels);
    s.volume = volume_of(&source, 16);
    struct vr_renderer *shared = renderer_of(s.volume, &vr_renderer_defaults);
    struct vr_renderer *own = renderer_of(s.volume, &vr_renderer_defaults);
    if (!shared || !own)
        skip();
    draw(own, &s, &slices, false, &alone);
    draw(shared, &s, &with_gradients, false, &image);
    brick_image_finish(&image);
    draw(shared, &s, &slices, false, &image);
    assert_same_image(&image, &alone, "slices after gradients");
    brick_image_finish(&image);
    brick_image_finish(&alone);
    vr_renderer_destroy(&shared);
    vr_renderer_destroy(&own);
    finish(&s);
}

/* What a method refuses it refuses whatever the cache holds. */
static void refusals(void **state)
{
    const struct way pre = {VR_METHOD_SLICES, BRICK_MODE_DVR, VR_CLASSIFY_PRE, 0};
    const struct way cells = {VR_METHOD_CELLS, BRICK_MODE_DVR, VR_CLASSIFY_POST, 0};
    struct vr_renderer_params params = vr_renderer_defaults;
    struct setting s;
    struct brick_image image;
    struct vr_scene scene;
    struct vr_quality quality;
    (void)state;
    make(&s);
    params.filter = VR_FILTER_FAST;
    struct vr_renderer *renderer = renderer_of(s.volume, &params);
    if (!renderer)
        skip();
    set(&s, &cells, &scene, &quality);
    assert_int_equal(vr_render_begin(renderer, &scene, &quality, NULL), BRICK_ERR_UNSUPPORTED);
    draw(renderer, &s, &pre, false, &image);
    brick_image_finish(&image);
    assert_int_equal(vr_render_begin(renderer, &scene, &quality, NULL), BRICK_ERR_UNSUPPORTED);
    vr_renderer_destroy(&renderer);
    finish(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_filter),
        cmocka_unit_test(fast_filter),
        cmocka_unit_test(bricks_of_gradients),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
