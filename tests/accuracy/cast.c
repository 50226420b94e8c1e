/* Rays cast without OpenGL, from file to picture: the same bytes whatever the bricks, the cache, the threads
 * and the skipping, of every stored type, and from frame to frame; and what is refused. (That the picture is
 * right: tests/gl/raycast_reference.c, and raycast_invariance.c: the same bytes as OpenGL's.) */
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

enum { NX = 75, NY = 66, NZ = 70, BODY = NX * NY * NZ, WIDTH = 75, HEIGHT = 50, PIXELS = WIDTH * HEIGHT };

static const struct brick_transfer_point points[] = {
    {40, 0.2, 0.1, 0.1, 0.0}, {60, 0.9, 0.3, 0.1, 0.1}, {60, 0.1, 0.9, 0.1, 0.02}, {100, 1, 1, 0.9, 0.7}};
static const struct brick_transfer_point other_points[] = {{-10, 1, 1, 1, 0.0}, {110, 0.2, 1, 1, 0.4}};

static struct brick_transfer *transfer_of(const struct brick_transfer_point *p, size_t count)
{
    struct brick_transfer *transfer = NULL;
    const struct brick_transfer_spec spec = {
        .points = (struct brick_transfer_point *)p, .count = count, .unit = 1.0, .unit_of = BRICK_UNIT_MM};
    assert_int_equal(brick_transfer_create(&transfer, &spec, 1.0, (const double[2]){0, 100}, NULL), 0);
    return transfer;
}

/* Blobs in empty space, oblique; of floats some voxels are not finite. */
static struct brick_volume *body_of(enum brick_type type, uint32_t edge, uint32_t macrocell)
{
    static float voxels[BODY];
    static const double affine[3][4] = {{0.8, -0.35, 0.1, -40}, {0.6, 0.75, -0.2, 7}, {0.05, 0.2, 1.6, 300}};
    struct memory_source source;
    struct brick_build_params params = brick_build_defaults;
    for (int i = 0; i < BODY; i++) {
        const int x = i % NX, y = i / NX % NY, z = i / NX / NY;
        double v = 130.0 * sin(0.11 * x + 0.3) * sin(0.13 * y) * cos(0.09 * z) - 15.0;
        v = v < 0.0 ? 0.0 : rint(v + (double)(noise64(3, (uint64_t)i) % 4));
        if (type == BRICK_F32 && noise64(2, (uint64_t)i) % 400 == 0)
            v = i % 2 ? NAN : -INFINITY;
        store_voxel(type, voxels, (size_t)i, v);
    }
    memory_source_init(&source, type, NX, NY, NZ, voxels);
    memcpy(source.base.geometry.affine, affine, sizeof affine);
    params.edge = edge;
    params.macrocell = macrocell;
    return build_and_open(&source, "body.brick", &params);
}

static struct vr_renderer *caster_of(const struct brick_volume *volume, unsigned threads, uint64_t bricks)
{
    struct vr_renderer_params params = vr_renderer_defaults;
    struct vr_renderer *renderer = NULL;
    struct brick_error err;
    params.context = VR_CONTEXT_CPU;
    params.threads = threads;
    if (bricks)
        params.host_cache_bytes = bricks * brick_grid_max_payload_bytes(brick_volume_grid(volume));
    if (vr_renderer_create(&renderer, volume, &params, &err))
        fail_msg("%s", err.message);
    return renderer;
}

static void draw(struct vr_renderer *renderer, const struct vr_scene *scene, const struct vr_quality *quality,
                 struct brick_image *image, struct vr_report *report)
{
    struct brick_error err;
    if (vr_render(renderer, scene, quality, image, report, &err))
        fail_msg("%s", err.message);
}

static void same_bytes_whatever_the_memory(void **state)
{
    (void)state;
    static const struct {
        uint32_t edge, macrocell;
        unsigned threads, bricks; /* in the cache; 0: all */
        bool skip;
    } variants[] = {{32, 8, 1, 0, true},   {16, 8, 2, 0, true}, {64, 16, 3, 0, true}, {32, 4, 5, 1, true},
                    {256, 16, 2, 0, true}, {8, 8, 2, 3, true},  {16, 4, 4, 9, false}, {32, 8, 2, 0, false}};
    static const enum brick_mode modes[] = {BRICK_MODE_DVR, BRICK_MODE_SHADED, BRICK_MODE_MIP};
    struct brick_transfer *transfer = transfer_of(points, 4), *other = transfer_of(other_points, 2);
    enum { PICTURES = 9 };
    for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++) {
        struct brick_image first[PICTURES] = {{0}}, again;
        assert_int_equal(brick_image_init(&again, WIDTH, HEIGHT, NULL), 0);
        for (size_t v = 0; v < sizeof variants / sizeof variants[0]; v++) {
            struct brick_volume *volume =
                body_of((enum brick_type)type, variants[v].edge, variants[v].macrocell);
            const struct brick_grid *grid = brick_volume_grid(volume);
            struct vr_renderer *renderer = caster_of(volume, variants[v].threads, variants[v].bricks);
            for (int p = 0; p < PICTURES; p++) {
                const int view = p / 3;
                if (view == 2 && grid->levels < 2)
                    continue;
                struct vr_scene scene = vr_scene_defaults, between;
                struct vr_quality quality = vr_quality_defaults;
                struct vr_report report;
                scene.mode = modes[p % 3];
                scene.transfer = transfer;
                scene.width = WIDTH;
                scene.height = HEIGHT;
                scene.level = view == 2;
                quality.skip = variants[v].skip;
                quality.interleaved = view == 2;
                quality.step_vox = view == 1 ? 1.7 : 0.6;
                /* 1: parallel, along an axis; 2: from inside */
                brick_camera_orbit(&scene.camera, grid, view == 1 ? 0 : 30, view == 1 ? 0 : 20, 0,
                                   view == 1 ? 60 : 0, 1.5);
                for (int a = 0; a < 3 && view == 2; a++)
                    scene.camera.eye_mm[a] = scene.camera.look_mm[a] + (a == 1 ? 12.0 : 0.0);
                between = scene;
                between.transfer = other;
                between.mode = BRICK_MODE_DVR;
                draw(renderer, &scene, &quality, &again, &report);
                assert_true(report.samples > 0 && report.bricks_active > 0);
                if (!first[p].rgba) {
                    double sum = 0.0;
                    assert_int_equal(brick_image_init(&first[p], WIDTH, HEIGHT, NULL), 0);
                    memcpy(first[p].rgba, again.rgba, PIXELS * 4 * sizeof(float));
                    for (int i = 0; i < PIXELS; i++)
                        sum += (double)again.rgba[4 * i + 3];
                    assert_true(isfinite(sum) && sum > 20.0);
                }
                assert_memory_equal(first[p].rgba, again.rgba, PIXELS * 4 * sizeof(float));
                draw(renderer, &between, &quality, &again, NULL);
                assert_memory_not_equal(first[p].rgba, again.rgba, PIXELS * 4 * sizeof(float));
                draw(renderer, &scene, &quality, &again, NULL);
                assert_memory_equal(first[p].rgba, again.rgba, PIXELS * 4 * sizeof(float));
            }
            vr_renderer_destroy(&renderer);
            brick_volume_close(&volume);
        }
        for (int p = 0; p < PICTURES; p++)
            brick_image_finish(&first[p]);
        brick_image_finish(&again);
    }
    brick_transfer_destroy(&transfer);
    brick_transfer_destroy(&other);
}

/* A triangle in the middle of the body, facing the eye at azimuth 0. */
static void triangle_at(struct brick_mesh *mesh, const struct brick_camera *camera, double size)
{
    const uint64_t corners[3] = {0, 1, 2};
    *mesh = (struct brick_mesh){0};
    for (int k = 0; k < 3; k++)
        assert_int_equal(brick_mesh_add_vertex(mesh,
                                               (const double[]){camera->look_mm[0] + (k == 1 ? size : -size),
                                                                camera->look_mm[1],
                                                                camera->look_mm[2] + (k == 2 ? size : -size)},
                                               NULL, NULL, NULL),
                         0);
    assert_int_equal(brick_mesh_add_polygon(mesh, corners, 3, NULL), 0);
}

/* Meshes of another number are others, and those without a number may be. (That they are in their place:
 * tests/gl/meshes.c) */
static void meshes_by_number(void **state)
{
    (void)state;
    struct brick_volume *volume = body_of(BRICK_U8, 32, 8);
    struct brick_transfer *transfer = transfer_of(points, 4);
    struct vr_scene scene = vr_scene_defaults;
    struct brick_image first, again, fresh;
    struct brick_mesh triangles[2];
    scene.transfer = transfer;
    scene.width = WIDTH, scene.height = HEIGHT;
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 0, 0, 0, 0, 1.5);
    triangle_at(&triangles[0], &scene.camera, 20.0);
    triangle_at(&triangles[1], &scene.camera, 35.0);
    assert_int_equal(brick_image_init(&first, WIDTH, HEIGHT, NULL), 0);
    assert_int_equal(brick_image_init(&again, WIDTH, HEIGHT, NULL), 0);
    assert_int_equal(brick_image_init(&fresh, WIDTH, HEIGHT, NULL), 0);
    for (uint64_t number = 0; number < 2; number++) {
        struct vr_renderer *renderer = caster_of(volume, 2, 0), *other = caster_of(volume, 1, 2);
        const struct vr_mesh meshes[2] = {{&triangles[0], {1, 0.5, 0.2}}, {&triangles[1], {1, 0.5, 0.2}}};
        const struct vr_mesh same = meshes[1];
        scene.mesh_count = 1;
        scene.meshes = &meshes[0];
        scene.meshes_number = number;
        draw(renderer, &scene, &vr_quality_defaults, &first, NULL);
        scene.meshes = &meshes[1];
        scene.meshes_number = 2 * number;
        draw(renderer, &scene, &vr_quality_defaults, &again, NULL);
        draw(other, &scene, &vr_quality_defaults, &fresh, NULL);
        assert_memory_equal(again.rgba, fresh.rgba, 4 * PIXELS * sizeof(float));
        assert_true(memcmp(again.rgba, first.rgba, 4 * PIXELS * sizeof(float)));
        scene.mesh_count = 0; /* kept meanwhile */
        draw(renderer, &scene, &vr_quality_defaults, &first, NULL);
        assert_true(memcmp(again.rgba, first.rgba, 4 * PIXELS * sizeof(float)));
        scene.mesh_count = 1;
        scene.meshes = &same;
        draw(renderer, &scene, &vr_quality_defaults, &again, NULL);
        assert_memory_equal(again.rgba, fresh.rgba, 4 * PIXELS * sizeof(float));
        vr_renderer_destroy(&renderer);
        vr_renderer_destroy(&other);
    }
    for (int k = 0; k < 2; k++)
        brick_mesh_finish(&triangles[k]);
    brick_image_finish(&first);
    brick_image_finish(&again);
    brick_image_finish(&fresh);
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
}

/* What is not drawn without OpenGL is said in a line. */
static void refusals(void **state)
{
    (void)state;
    struct brick_volume *volume = body_of(BRICK_U8, 32, 8);
    struct vr_renderer *renderer = caster_of(volume, 2, 0);
    struct brick_transfer *transfer = transfer_of(points, 4), *independent = transfer_of(points, 4);
    struct brick_image image;
    struct brick_error err;
    assert_int_equal(brick_image_init(&image, WIDTH, HEIGHT, NULL), 0);
    brick_transfer_set_emission(independent, BRICK_EMISSION_INDEPENDENT);
    for (int i = 0; i < 7; i++) {
        struct vr_scene scene = vr_scene_defaults;
        struct vr_quality quality = vr_quality_defaults;
        scene.transfer = transfer;
        scene.width = WIDTH, scene.height = HEIGHT;
        brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 0, 0, 0, 0, 1.5);
        if (i == 0)
            scene.mode = BRICK_MODE_ISO;
        if (i == 1)
            quality.method = VR_METHOD_SLICES;
        if (i == 2)
            quality.classification = VR_CLASSIFY_PREINTEGRATED;
        if (i == 3)
            quality.setup = VR_SETUP_GEOMETRY;
        if (i == 4)
            scene.transfer = independent;
        if (i == 5)
            quality.step_vox = 1e-12;
        if (i == 6)
            scene.height = HEIGHT + 1;
        const int want = i < 5 ? BRICK_ERR_UNSUPPORTED : BRICK_ERR_ARGUMENT;
        err.message[0] = '\0';
        assert_int_equal(vr_render(renderer, &scene, &quality, &image, NULL, &err), want);
        assert_true(strlen(err.message) > 10);
    }
    vr_renderer_destroy(&renderer);
    struct vr_renderer_params params = vr_renderer_defaults;
    params.context = VR_CONTEXT_CPU;
    params.filter = VR_FILTER_FAST;
    assert_int_equal(vr_renderer_create(&renderer, volume, &params, &err), BRICK_ERR_UNSUPPORTED);
    params.filter = VR_FILTER_EXACT;
    params.host_cache_bytes = 1000;
    assert_int_equal(vr_renderer_create(&renderer, volume, &params, &err), BRICK_ERR_ARGUMENT);
    assert_null(renderer);
    brick_image_finish(&image);
    brick_transfer_destroy(&transfer);
    brick_transfer_destroy(&independent);
    brick_volume_close(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(same_bytes_whatever_the_memory),
                                       cmocka_unit_test(meshes_by_number), cmocka_unit_test(refusals)};
    return cmocka_run_group_tests_name("cast", tests, NULL, NULL);
}
