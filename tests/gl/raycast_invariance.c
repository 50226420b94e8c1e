/* The picture depends on the volume and the scene only: the same bytes for every brick edge, with and without
 * skipping, by raycast and by multipass, through EGL and OSMesa, and without OpenGL; rays along brick faces,
 * edges and through corners, and from inside, included. */
#include <float.h>
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

#define NX   70
#define NY   61
#define NZ   83
#define EDGE 64

static const uint32_t edges[] = {16, 32, 256};
static const struct brick_transfer_point points[] = {
    {150, 0.2, 0.1, 0.1, 0.0}, {300, 0.9, 0.3, 0.1, 0.1}, {300, 0.1, 0.9, 0.1, 0.02}, {900, 1, 1, 0.9, 0.7}};
/* Peaks between transparent values, narrower than what a voxel's way changes. */
static const struct brick_transfer_point peaks[] = {
    {205, 1, 0, 0, 0.0},   {211, 0.9, 0.3, 0.1, 0.6}, {214, 0, 0, 1, 0.0}, {500.5, 0, 1, 0, 0.0},
    {500.5, 0, 1, 0, 0.8}, {503, 1, 1, 0, 0.2},       {503, 1, 1, 0, 0.0}};

/* Blobs in empty space, with some noise: much to skip, and ranges that touch thresholds. */
static double blobs(int x, int y, int z)
{
    double v = 1100.0 * sin(0.11 * x + 0.3) * sin(0.13 * y) * cos(0.09 * z) - 150.0;
    return v < 0.0 ? 0.0 : v + (double)(noise64(3, (uint64_t)((z * NY + y) * NX + x)) % 40);
}

static void camera_of(int view, const struct brick_grid *grid, struct brick_camera *camera)
{
    /* Parallel, a pixel a voxel, pixel centres at whole voxels: rays in the planes x = n, z = m, where cells
     * and bricks meet. */
    static const double look[3] = {32.5, 30.0, 32.5};
    brick_camera_orbit(camera, grid, 35, 25, 0, 0, 1.0);
    switch (view) {
    case 0: /* oblique */
        break;
    case 1: /* along the bricks' edges, each way */
    case 2:
        brick_camera_orbit(camera, grid, view == 1 ? 0 : 90, 0, 0, EDGE, 1.0);
        for (int a = 0; a < 3; a++) {
            camera->eye_mm[a] = look[a] + (a == (view == 1 ? 1 : 0) ? -200.0 : 0.0);
            camera->look_mm[a] = look[a];
        }
        break;
    case 3: /* in faces and through corners, diagonally */
        for (int a = 0; a < 3; a++) {
            camera->eye_mm[a] = 32.0 + (a < 2 ? -100.0 : 0.0);
            camera->look_mm[a] = 32.0;
        }
        camera->ortho_height_mm = EDGE;
        camera->up[0] = camera->up[1] = 0.0, camera->up[2] = 1.0;
        break;
    case 4: /* the space diagonal through the corners */
        for (int a = 0; a < 3; a++) {
            camera->eye_mm[a] = -100.0;
            camera->look_mm[a] = 32.0;
        }
        camera->ortho_height_mm = 1.4 * EDGE;
        break;
    default: /* inside, at a brick's corner */
        for (int a = 0; a < 3; a++) {
            camera->eye_mm[a] = 32.0;
            camera->look_mm[a] = a == 1 ? 0.0 : 32.0;
        }
        camera->fov_deg = 110.0;
    }
}

#define VIEWS 6

/* Does OpenGL round as IEEE 754 says? Only then are its bytes those of the CPU. */
static bool rounds_well(const struct vr_report *report)
{
    return strstr(report->gl_renderer, "llvmpipe");
}

static bool on_cpu(int way)
{
    return way < 4 && way != BRICK_MODE_ISO;
}

/* Images of every mode and view, in one renderer, against those of the first. hand: raycast without skipping
 * and with, multipass without and with. True if the CPU's must be the same. */
static bool compare_all(struct vr_renderer *renderer, const struct brick_grid *grid,
                        struct brick_transfer *const transfers[2], double isovalue, double step, int hand,
                        bool cpu, struct brick_image *images, bool first, const char *what)
{
    bool well = false;
    for (int way = 0; way < (step <= 1.0 ? WAYS : 4); way++)
        for (int view = 0; view < VIEWS; view++) {
            struct vr_scene scene = vr_scene_defaults;
            struct vr_quality quality = vr_quality_defaults;
            struct brick_image image;
            struct vr_report report;
            char line[160];
            if (cpu && !on_cpu(way))
                continue;
            set_way(way, &scene, &quality);
            scene.transfer = transfers[way >= 4];
            scene.isovalue = isovalue;
            scene.width = scene.height = EDGE;
            quality.step_vox = step;
            quality.skip = hand % 2;
            quality.method = hand < 2 ? VR_METHOD_RAYCAST : VR_METHOD_MULTIPASS;
            quality.pass_steps = hand % 2 ? 13 : 64;
            camera_of(view, grid, &scene.camera);
            render(renderer, &scene, &quality, &image, &report);
            assert_true(report.bricks_active <= report.bricks_total);
            well = rounds_well(&report);
            if (first) {
                double sum = 0.0;
                for (int i = 0; i < EDGE * EDGE; i++)
                    sum += (double)image.rgba[4 * i + 3];
                if (!(sum > 5.0) || !isfinite(sum))
                    fail_msg("%s, way %d, view %d: nothing in the picture", what, way, view);
                images[way * VIEWS + view] = image;
                continue;
            }
            snprintf(line, sizeof line, "%s, way %d, view %d, step %g", what, way, view, step);
            assert_same_image(&image, &images[way * VIEWS + view], line);
            brick_image_finish(&image);
        }
    return well;
}

/* Rays too long for one pass: where a pass ends depends on bricks and skipping, the picture does not. */
static void test_passes(void **state)
{
    (void)state;
    enum { LENGTH = 9001 };
    static uint16_t voxels[3 * 2 * LENGTH];
    struct memory_source source;
    struct brick_transfer *transfer = transfer_of(points, sizeof points / sizeof points[0]);
    struct brick_image images[WAYS] = {{0}};
    bool first = true;
    for (int i = 0; i < 3 * 2 * LENGTH; i++) {
        double v = i / 6 < 7000 ? 0.0 : 400.0 * sin(i / 6 * 0.013) + (double)(noise64(9, (uint64_t)i) % 64);
        voxels[i] = (uint16_t)(v < 0.0 ? 0.0 : v);
    }
    memory_source_init(&source, BRICK_U16, 3, 2, LENGTH, voxels);
    for (size_t e = 0; e < sizeof edges / sizeof edges[0]; e++) {
        struct brick_volume *volume = volume_of(&source, edges[e]);
        struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
        struct vr_renderer *cpu = renderer ? try_renderer(volume, VR_CONTEXT_CPU) : NULL;
        for (int run = 0; renderer && run < 3 * WAYS; run++) {
            int way = run / 3, hand = run % 3;
            struct vr_scene scene = vr_scene_defaults;
            struct vr_quality quality = vr_quality_defaults;
            struct brick_image image;
            struct vr_report report;
            char line[120];
            set_way(way, &scene, &quality);
            scene.transfer = transfer;
            scene.isovalue = 350.25;
            scene.width = scene.height = 5;
            scene.camera = (struct brick_camera){.eye_mm = {1.02, 0.51, -10},
                                                 .look_mm = {1.0, 0.5, LENGTH},
                                                 .up = {0, 1, 0},
                                                 .ortho_height_mm = 1.5};
            quality.step_vox = 0.37;
            quality.skip = hand > 0;
            quality.method = hand < 2 ? VR_METHOD_RAYCAST : VR_METHOD_MULTIPASS;
            render(renderer, &scene, &quality, &image, &report);
            assert_true(report.passes > 10);
            snprintf(line, sizeof line, "long rays, bricks of %u, way %d, hand %d", edges[e], way, hand);
            if (first && hand == 0) {
                assert_true(image.rgba[4 * 12 + 3] > 0.1f);
                images[way] = image;
                continue;
            }
            assert_same_image(&image, &images[way], line);
            brick_image_finish(&image);
            if (!rounds_well(&report) || !on_cpu(way) || hand == 2)
                continue;
            render(cpu, &scene, &quality, &image, &report);
            snprintf(line, sizeof line, "long rays without OpenGL, bricks of %u, way %d", edges[e], way);
            assert_same_image(&image, &images[way], line);
            brick_image_finish(&image);
        }
        first = first && !renderer;
        vr_renderer_destroy(&cpu);
        vr_renderer_destroy(&renderer);
        brick_volume_close(&volume);
    }
    for (int i = 0; i < WAYS; i++)
        brick_image_finish(&images[i]);
    brick_transfer_destroy(&transfer);
    if (first)
        skip();
}

static void check(enum brick_type type, const void *voxels, double isovalue, double step)
{
    struct memory_source source;
    struct brick_transfer *transfers[2] = {transfer_of(points, sizeof points / sizeof points[0]),
                                           transfer_of(peaks, sizeof peaks / sizeof peaks[0])};
    struct brick_image images[WAYS * VIEWS] = {{0}};
    bool first = true;
    static const enum vr_context_kind kinds[] = {VR_CONTEXT_EGL, VR_CONTEXT_OSMESA, VR_CONTEXT_CPU};
    static const char *const names[] = {"EGL", "OSMesa", "no OpenGL"};
    bool well = false;
    memory_source_init(&source, type, NX, NY, NZ, voxels);
    for (size_t e = 0; e < sizeof edges / sizeof edges[0]; e++) {
        struct brick_volume *volume = volume_of(&source, edges[e]);
        for (int c = 0; c < 3; c++) {
            const bool cpu = kinds[c] == VR_CONTEXT_CPU, wanted = cpu ? well : c == 0 || e == 0;
            struct vr_renderer *renderer = wanted ? try_renderer(volume, kinds[c]) : NULL;
            for (int hand = 0; renderer && hand < (e == 1 && !cpu ? 4 : 2); hand++) {
                char what[80];
                snprintf(what, sizeof what, "%s, bricks of %u, hand %d", names[c], edges[e], hand);
                well = compare_all(renderer, brick_volume_grid(volume), transfers, isovalue, step, hand, cpu,
                                   images, first, what) ||
                       cpu;
                first = false;
            }
            vr_renderer_destroy(&renderer);
        }
        brick_volume_close(&volume);
    }
    for (int i = 0; i < WAYS * VIEWS; i++)
        brick_image_finish(&images[i]);
    for (int i = 0; i < 2; i++)
        brick_transfer_destroy(&transfers[i]);
    if (first)
        skip();
}

static void test_i16(void **state)
{
    (void)state;
    static int16_t voxels[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; i++)
        voxels[i] = (int16_t)blobs(i % NX, i / NX % NY, i / NX / NY);
    check(BRICK_I16, voxels, 300.0, 0.5);
    check(BRICK_I16, voxels, 300.5, 2.7);
}

static void test_u8(void **state)
{
    (void)state;
    static uint8_t voxels[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; i++)
        voxels[i] = (uint8_t)(blobs(i % NX, i / NX % NY, i / NX / NY) / 4.0);
    check(BRICK_U8, voxels, 180.0, 1.0);
}

static void test_f32(void **state)
{
    (void)state;
    static float voxels[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; i++)
        voxels[i] = (float)(blobs(i % NX, i / NX % NY, i / NX / NY) * 1.234567);
    check(BRICK_F32, voxels, 300.123, 0.5);
}

/* Boxes from face to face of bricks of 16, their neighbours empty: what shows between two values shows where
 * a step leads out of the box, or into it. */
static void test_boxes(void **state)
{
    (void)state;
    static uint16_t voxels[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; i++) {
        const int at[3] = {i % NX, i / NX % NY, i / NX / NY};
        bool inside = true;
        for (int a = 0; a < 3; a++)
            inside = inside && at[a] / 16 % 2 == 0 && at[a] % 16 != 0;
        voxels[i] = inside ? (uint16_t)(900 + noise64(11, (uint64_t)i) % 100) : 0;
    }
    check(BRICK_U16, voxels, 300.0, 1.0);
}

/* Single voxels, a whole brick and a plane that are not finite. */
static void test_nonfinite(void **state)
{
    (void)state;
    static float voxels[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; i++) {
        int x = i % NX, y = i / NX % NY, z = i / NX / NY;
        voxels[i] = (float)blobs(x, y, z);
        if (noise64(5, (uint64_t)i) % 300 == 0 || z == 31 || (x < 20 && y < 20 && z < 20))
            voxels[i] = i % 3 == 0 ? NAN : i % 3 == 1 ? INFINITY : -INFINITY;
    }
    check(BRICK_F32, voxels, 300.0, 0.5);
    /* Columns that end a voxel before a brick's face, and a plane of NaN behind it in bricks that are
     * otherwise wholly below: a step leads from above straight into it. */
    for (int i = 0; i < NX * NY * NZ; i++) {
        int x = i % NX, y = i / NX % NY, z = i / NX / NY;
        voxels[i] = x == 33 ? NAN : x < 31 && ((y >> 3) + (z >> 3)) % 2 ? 1000.0f : 0.0f;
    }
    check(BRICK_F32, voxels, 300.0, 2.7);
}

/* The lowest float where there is nothing, as some programs write it: differences overflow. */
static void test_huge(void **state)
{
    (void)state;
    static float voxels[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; i++) {
        const double v = blobs(i % NX, i / NX % NY, i / NX / NY);
        voxels[i] = v > 0.0 ? (float)v : noise64(4, (uint64_t)i) % 50 ? -FLT_MAX : FLT_MAX;
    }
    check(BRICK_F32, voxels, 300.0, 0.7);
}

/* Beside numbers that a float holds well, some so small that colours or voxels themselves are denormal. */
static void test_tiny(void **state)
{
    (void)state;
    static float voxels[NX * NY * NZ];
    const struct brick_transfer_point ramp[] = {{0, 0, 0.1, 1, 0.0}, {1, 1, 1, 0.5, 0.3}};
    struct memory_source source;
    struct brick_transfer *transfer = transfer_of(ramp, 2);
    for (int i = 0; i < NX * NY * NZ; i++) {
        const double v = blobs(i % NX, i / NX % NY, i / NX / NY) / 1100.0;
        voxels[i] = (float)(i / NX % NY < 25 ? v : v * pow(10.0, -5.0 * (i / NX / NY % 9)));
    }
    memory_source_init(&source, BRICK_F32, NX, NY, NZ, voxels);
    struct brick_volume *volume = volume_of(&source, 32);
    struct vr_renderer *gl = try_renderer(volume, VR_CONTEXT_EGL),
                       *cpu = try_renderer(volume, VR_CONTEXT_CPU);
    bool small = false;
    for (int mode = BRICK_MODE_DVR; gl && mode <= BRICK_MODE_MIP; mode++) {
        struct vr_scene scene = vr_scene_defaults;
        struct brick_image images[2];
        struct vr_report report;
        if (mode == BRICK_MODE_ISO)
            continue;
        scene.transfer = transfer;
        scene.mode = mode;
        scene.width = scene.height = 200;
        brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 90, 5, 0, 90, 1.0);
        render(gl, &scene, &vr_quality_defaults, &images[0], &report);
        render(cpu, &scene, &vr_quality_defaults, &images[1], NULL);
        for (size_t i = 0; i < 4 * 200 * 200; i++)
            small = small || (images[0].rgba[i] > 0.0f && images[0].rgba[i] < 1e-30f);
        if (rounds_well(&report))
            assert_same_image(&images[0], &images[1], "tiny values");
        brick_image_finish(&images[0]);
        brick_image_finish(&images[1]);
    }
    const bool none = !gl;
    assert_true(none || small);
    vr_renderer_destroy(&gl);
    vr_renderer_destroy(&cpu);
    brick_volume_close(&volume);
    brick_transfer_destroy(&transfer);
    if (none)
        skip();
}

/* From so far away that a ray's place depends on the last bits of its sums; with and without clip planes. */
static void test_far(void **state)
{
    (void)state;
    static int16_t voxels[NX * NY * NZ];
    struct memory_source source;
    struct brick_transfer *transfer = transfer_of(points, sizeof points / sizeof points[0]);
    for (int i = 0; i < NX * NY * NZ; i++)
        voxels[i] = (int16_t)blobs(i % NX, i / NX % NY, i / NX / NY);
    memory_source_init(&source, BRICK_I16, NX, NY, NZ, voxels);
    source.base.geometry.affine[0][1] = 0.3, source.base.geometry.affine[2][0] = -0.2;
    struct brick_volume *volume = volume_of(&source, 32);
    struct vr_renderer *gl = try_renderer(volume, VR_CONTEXT_AUTO),
                       *cpu = try_renderer(volume, VR_CONTEXT_CPU);
    for (int run = 0; gl && run < 6; run++) {
        struct vr_scene scene = vr_scene_defaults;
        struct vr_quality quality = vr_quality_defaults;
        struct brick_image images[2];
        struct vr_report report;
        char line[80];
        scene.transfer = transfer;
        scene.mode = run % 2 ? BRICK_MODE_SHADED : BRICK_MODE_DVR;
        scene.width = scene.height = 256;
        brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 33, 21, 0, run < 4 ? 90 : 0, 1.0);
        for (int a = 0; a < 3; a++)
            scene.camera.eye_mm[a] += 3000.0 * (scene.camera.eye_mm[a] - scene.camera.look_mm[a]);
        scene.camera.fov_deg = 0.01;
        scene.clip_count = run >= 2;
        scene.clip[0] = (struct vr_plane){{0.3, -0.7, 0.2}, 3.3};
        quality.interleaved = run == 3;
        render(gl, &scene, &quality, &images[0], &report);
        render(cpu, &scene, &quality, &images[1], NULL);
        snprintf(line, sizeof line, "far away, run %d", run);
        if (rounds_well(&report))
            assert_same_image(&images[0], &images[1], line);
        brick_image_finish(&images[0]);
        brick_image_finish(&images[1]);
    }
    vr_renderer_destroy(&cpu);
    end_or_skip(&gl, &transfer, &volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_i16),   cmocka_unit_test(test_u8),        cmocka_unit_test(test_f32),
        cmocka_unit_test(test_boxes), cmocka_unit_test(test_nonfinite), cmocka_unit_test(test_passes),
        cmocka_unit_test(test_huge),  cmocka_unit_test(test_far),       cmocka_unit_test(test_tiny),
    };
    return cmocka_run_group_tests_name("raycast_invariance", tests, NULL, NULL);
}
