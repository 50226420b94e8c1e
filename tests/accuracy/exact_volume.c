/* vr_render_exact from file to picture: each pixel against the reference, for every kind of camera, level and
 * affine; the same bytes whatever the bricks, the cache and the threads; and what it refuses. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <renderer/renderer.h>

#include "../support/memory_source.h"
#include "reference_volume.h"

enum { NX = 21, NY = 14, NZ = 19, WIDTH = 7, HEIGHT = 5 };

static const double affines[][3][4] = {
    {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
    {{0.7, 0, 0, 10}, {0, -1.1, 0, 4}, {0, 0, 2.3, -70}},                  /* flipped, anisotropic */
    {{0.8, -0.35, 0.1, -40}, {0.6, 0.75, -0.2, 7}, {0.05, 0.2, 1.6, 300}}, /* oblique and sheared */
};
enum { AFFINES = sizeof affines / sizeof affines[0] };

/* Smooth enough to be seen into, rough enough to cross many knots. */
static void fill(int16_t *voxels)
{
    for (uint64_t i = 0; i < NX * NY * NZ; i++) {
        double x = (double)(i % NX), y = (double)(i / NX % NY), z = (double)(i / (NX * NY));
        double smooth = 300.0 * sin(0.7 * x) * cos(0.5 * y + 0.3 * z) + 15.0 * z;
        voxels[i] = (int16_t)lrint(smooth + (double)(noise64(3, i) % 101));
    }
}

static struct brick_volume *make_volume(int affine, uint32_t edge)
{
    static int16_t voxels[NX * NY * NZ];
    struct memory_source source;
    struct brick_build_params params = brick_build_defaults;
    fill(voxels);
    memory_source_init(&source, BRICK_I16, NX, NY, NZ, voxels);
    memcpy(source.base.geometry.affine, affines[affine], sizeof affines[affine]);
    source.base.geometry.slope = -0.5;
    source.base.geometry.intercept = 20.25;
    params.edge = edge;
    return build_and_open(&source, "exact.brick", &params);
}

static struct brick_transfer *make_transfer(const struct brick_volume *volume)
{
    struct brick_transfer_point points[] = {
        {-180, 0.9, 0.1, 0.0, 0.0}, {-120, 0.2, 0.7, 0.1, 0.15}, {-60, 0.4, 0.4, 0.9, 0.0},
        {10, 0.4, 0.4, 0.9, 0.0},   {10, 1.0, 0.2, 0.2, 0.3},    {40, 0.1, 0.3, 1.0, 0.02},
        {40, 0.0, 0.9, 0.1, 0.0},   {120, 1.0, 1.0, 1.0, 0.6},
    };
    struct brick_transfer_spec spec = {points, sizeof points / sizeof points[0], 1.5, BRICK_UNIT_VOXEL,
                                       false};
    struct brick_transfer *transfer;
    double range[2];
    brick_volume_value_range(volume, range);
    assert_int_equal(brick_transfer_create(&transfer, &spec,
                                           brick_grid_min_spacing_mm(brick_volume_grid(volume)), range, NULL),
                     BRICK_OK);
    return transfer;
}

static void at_index(const struct brick_grid *grid, double x, double y, double z, double mm[3])
{
    for (int i = 0; i < 3; i++)
        mm[i] = grid->affine[i][0] * x + grid->affine[i][1] * y + grid->affine[i][2] * z + grid->affine[i][3];
}

/* From outside and inside, perspective and parallel, oblique and along the axes. */
enum { CAMERAS = 6 };
static struct brick_camera camera_number(const struct brick_grid *grid, int n)
{
    struct brick_camera c;
    double aspect = (double)WIDTH / HEIGHT;
    switch (n) {
    case 0:
        brick_camera_orbit(&c, grid, 35, 20, 0, 0, aspect);
        break;
    case 1:
        brick_camera_orbit(&c, grid, -110, -50, 0, 21, aspect);
        break;
    case 2:
        brick_camera_orbit(&c, grid, 0, 0, 0, 0, aspect);
        break;
    case 3: /* the rays of the middle column and row lie in faces of cells and bricks */
        brick_camera_orbit(&c, grid, 90, 0, 0, 0, aspect);
        at_index(grid, 40, 8, 8, c.eye_mm);
        at_index(grid, 0, 8, 8, c.look_mm);
        c.ortho_height_mm = 10.0;
        break;
    case 4: /* inside, on a voxel */
        brick_camera_orbit(&c, grid, 10, 5, 90, 0, aspect);
        at_index(grid, 8, 8, 8, c.eye_mm);
        at_index(grid, 16, 12, 16, c.look_mm);
        break;
    default: /* inside, between the volume's edge and the outermost voxels */
        brick_camera_orbit(&c, grid, 10, 5, 60, 0, aspect);
        at_index(grid, -0.3, 5, 8, c.eye_mm);
        at_index(grid, 20, 8, 8, c.look_mm);
    }
    return c;
}

static struct vr_scene make_scene(const struct brick_transfer *transfer, struct brick_camera camera,
                                  uint32_t level)
{
    return (struct vr_scene){.mode = BRICK_MODE_DVR,
                             .transfer = transfer,
                             .camera = camera,
                             .width = WIDTH,
                             .height = HEIGHT,
                             .level = level};
}

static double *read_level(const struct brick_volume *volume, uint32_t level, struct reference_volume *v)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_level *l = &grid->level[level];
    size_t count = (size_t)(l->dims[0] * l->dims[1] * l->dims[2]);
    int16_t *stored = malloc(count * sizeof *stored);
    double *physical = malloc(count * sizeof *physical);
    assert_non_null(stored);
    assert_non_null(physical);
    assert_int_equal(brick_volume_read_box(volume, level, (uint64_t[3]){0, 0, 0}, l->dims, stored, NULL),
                     BRICK_OK);
    for (size_t i = 0; i < count; i++)
        physical[i] = grid->slope * stored[i] + grid->intercept;
    for (int i = 0; i < 3; i++) {
        v->dims[i] = (int64_t)l->dims[i];
        v->scale[i] = l->scale[i];
        v->offset[i] = l->offset[i];
    }
    v->voxels = physical;
    free(stored);
    return physical;
}

static void pixels_are_right(void **state)
{
    double worst = 0.0, brightest = 0.0;
    (void)state;
    for (int affine = 0; affine < AFFINES; affine++) {
        struct brick_volume *volume = make_volume(affine, 8);
        struct brick_transfer *transfer = make_transfer(volume);
        const struct brick_grid *grid = brick_volume_grid(volume);
        for (int n = 0; n < CAMERAS; n++) {
            uint32_t level = (uint32_t)((n + affine) % 3 == 2);
            struct vr_scene scene = make_scene(transfer, camera_number(grid, n), level);
            struct vr_report report;
            struct brick_image image;
            struct brick_view view;
            struct brick_error err;
            assert_int_equal(brick_image_init(&image, WIDTH, HEIGHT, NULL), BRICK_OK);
            if (vr_render_exact(volume, &scene, &vr_exact_defaults, &image, &report, &err))
                fail_msg("%s", err.message);
            assert_true(report.bricks_active > 0 && report.bricks_active <= report.bricks_total);
            assert_true(report.samples > 0 && report.seconds_frame > 0.0);
            assert_int_equal(brick_view_init(&view, &scene.camera, grid, WIDTH, HEIGHT, NULL), BRICK_OK);
            struct reference_volume v = {0};
            double *physical = read_level(volume, level, &v);
            for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
                const float *rgba = &image.rgba[4 * i];
                struct reference r = {0};
                struct brick_ray ray;
                double enter, leave;
                brick_view_ray(&view, i % WIDTH, i / WIDTH, &ray);
                if (brick_ray_span(&ray, grid, &enter, &leave))
                    r = reference_ray(&v, transfer, &ray, enter, leave, 20);
                for (int c = 0; c < 3; c++)
                    worst = fmax(worst, fabs((double)(r.rgb[c] - (long double)rgba[c])));
                worst = fmax(worst, fabs((double)(-expm1l(-r.depth) - (long double)rgba[3])));
                brightest = fmax(brightest, (double)rgba[3]);
            }
            free(physical);
            brick_image_finish(&image);
        }
        brick_transfer_destroy(&transfer);
        brick_volume_close(&volume);
    }
    print_message("largest difference from the reference: %.3g\n", worst);
    assert_true(brightest > 0.9);
    assert_true(worst <= 0x1p-25 + 1e-10); /* half a unit in the last place of float32 below 1 */
}

static void same_bytes_for_bricks_cache_and_threads(void **state)
{
    static const uint32_t edges[] = {8, 16, 32};
    static const unsigned threads[] = {1, 2, 5};
    struct brick_image first = {0};
    (void)state;
    for (int e = 0; e < 3; e++)
        for (int t = 0; t < 3; t++) {
            struct brick_volume *volume = make_volume(2, edges[e]);
            struct brick_transfer *transfer = make_transfer(volume);
            const struct brick_grid *grid = brick_volume_grid(volume);
            struct vr_scene scene = make_scene(transfer, camera_number(grid, 0), 0);
            struct vr_exact_params params = vr_exact_defaults;
            struct brick_image image;
            struct brick_error err;
            scene.width = scene.height = 48;
            params.threads = threads[t];
            if (t > 0) /* room for one brick or two: fewer than threads */
                params.host_cache_bytes = (uint64_t)t * brick_grid_max_payload_bytes(grid);
            assert_int_equal(brick_image_init(&image, 48, 48, NULL), BRICK_OK);
            if (vr_render_exact(volume, &scene, &params, &image, NULL, &err))
                fail_msg("%s", err.message);
            if (!first.rgba)
                first = image;
            else {
                assert_memory_equal(first.rgba, image.rgba, 48 * 48 * 4 * sizeof *image.rgba);
                brick_image_finish(&image);
            }
            brick_transfer_destroy(&transfer);
            brick_volume_close(&volume);
        }
    brick_image_finish(&first);
}

/* A slab seen straight on has an answer that needs no reference at all. */
static void slab_from_file(void **state)
{
    static uint8_t voxels[16 * 16 * 16];
    struct memory_source source;
    struct brick_transfer_point point = {0, 0.25, 0.5, 1.0, 0.125};
    struct brick_transfer_spec spec = {&point, 1, 2.0, BRICK_UNIT_MM, false};
    struct brick_transfer *transfer;
    struct brick_image image;
    (void)state;
    memset(voxels, 7, sizeof voxels);
    memory_source_init(&source, BRICK_U8, 16, 16, 16, voxels);
    source.base.geometry.affine[1][1] = 0.5; /* 8 mm thick along y: A = 1/8 each 2 mm */
    struct brick_volume *volume = build_and_open(&source, "slab.brick", NULL);
    assert_int_equal(brick_transfer_create(&transfer, &spec, 0.5, (double[2]){7, 7}, NULL), BRICK_OK);
    struct brick_camera camera;
    brick_camera_orbit(&camera, brick_volume_grid(volume), 0, 0, 0, 10, 1.0);
    struct vr_scene scene = make_scene(transfer, camera, 0);
    assert_int_equal(brick_image_init(&image, WIDTH, HEIGHT, NULL), BRICK_OK);
    assert_int_equal(vr_render_exact(volume, &scene, &vr_exact_defaults, &image, NULL, NULL), BRICK_OK);
    double alpha = 1.0 - pow(0.875, 4.0);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        assert_true(fabs((double)image.rgba[4 * i + 3] - alpha) < 0x1p-24 * alpha + 1e-12);
        assert_true(fabs((double)image.rgba[4 * i] - 0.25 * alpha) < 0x1p-24 * alpha + 1e-12);
        assert_true(image.rgba[4 * i + 1] == 2.0f * image.rgba[4 * i]);
    }
    brick_image_finish(&image);
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
}

static void nothing_finite_is_clear(void **state)
{
    static float voxels[12 * 12 * 12];
    struct memory_source source;
    struct brick_transfer_point point = {0, 1, 1, 1, 0.5};
    struct brick_transfer_spec spec = {&point, 1, 1.0, BRICK_UNIT_MM, false};
    struct brick_transfer *transfer;
    struct brick_image image;
    struct vr_report report;
    (void)state;
    for (int i = 0; i < 12 * 12 * 12; i++)
        voxels[i] = i % 2 ? NAN : INFINITY;
    memory_source_init(&source, BRICK_F32, 12, 12, 12, voxels);
    struct brick_volume *volume = build_and_open(&source, "nan.brick", NULL);
    assert_int_equal(brick_transfer_create(&transfer, &spec, 1.0, (double[2]){0, 0}, NULL), BRICK_OK);
    struct brick_camera camera;
    brick_camera_orbit(&camera, brick_volume_grid(volume), 30, 30, 0, 0, 1.0);
    struct vr_scene scene = make_scene(transfer, camera, 0);
    assert_int_equal(brick_image_init(&image, WIDTH, HEIGHT, NULL), BRICK_OK);
    assert_int_equal(vr_render_exact(volume, &scene, &vr_exact_defaults, &image, &report, NULL), BRICK_OK);
    for (int i = 0; i < WIDTH * HEIGHT * 4; i++)
        assert_true(image.rgba[i] == 0.0f);
    assert_int_equal(report.bricks_active, 0);
    assert_int_equal(report.bricks_loaded, 0);
    brick_image_finish(&image);
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
}

static void bad_requests_are_refused(void **state)
{
    struct brick_volume *volume = make_volume(0, 16);
    struct brick_transfer *transfer = make_transfer(volume);
    struct vr_scene good = make_scene(transfer, camera_number(brick_volume_grid(volume), 0), 0);
    struct brick_image image;
    (void)state;
    assert_int_equal(brick_image_init(&image, WIDTH, HEIGHT, NULL), BRICK_OK);
    for (int kind = 0; kind < 10; kind++) {
        struct vr_exact_params params = vr_exact_defaults;
        struct vr_scene scene = good;
        struct brick_error err = {0};
        switch (kind) {
        case 0: /* a picture of colours has neither surfaces nor largest values */
            scene.mode = BRICK_MODE_ISO;
            params.field = VR_FIELD_PRECLASSIFIED;
            break;
        case 1:
            scene.mode = BRICK_MODE_MIP;
            params.field = VR_FIELD_PRECLASSIFIED;
            break;
        case 2:
            scene.transfer = NULL;
            break;
        case 3:
            scene.level = brick_volume_grid(volume)->levels;
            break;
        case 4:
            scene.width = WIDTH + 1;
            break;
        case 5:
            params.tolerance = 0.0;
            break;
        case 6:
            scene.mode = BRICK_MODE_ISO;
            scene.isovalue = NAN;
            break;
        case 7:
            scene.clip_count = 1; /* its normal is zero */
            break;
        case 8:
            scene.clip_count = VR_MAX_CLIP_PLANES + 1;
            break;
        default:
            params.host_cache_bytes = 100;
        }
        int result = vr_render_exact(volume, &scene, &params, &image, NULL, &err);
        assert_int_equal(result, kind < 2 ? BRICK_ERR_UNSUPPORTED : BRICK_ERR_ARGUMENT);
        assert_int_equal(err.code, result);
        assert_true(strlen(err.message) > 0);
    }
    brick_image_finish(&image);
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_are_right),         cmocka_unit_test(same_bytes_for_bricks_cache_and_threads),
        cmocka_unit_test(slab_from_file),           cmocka_unit_test(nothing_finite_is_clear),
        cmocka_unit_test(bad_requests_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
