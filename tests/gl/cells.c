/* Projected cells against the exact integral of the same field, and against themselves: for every type,
 * through the volume's rim, cut, at coarser levels, with voxels that are not finite, and from small caches;
 * in parallel views and in perspective (cells_scene.h says how right they are). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "cells_scene.h"

static void test_types(void **state)
{
    static float voxels[NX * NY * NZ];
    static const struct {
        enum brick_type type;
        double slope, intercept;
        int azimuth, elevation;
    } cases[] = {{BRICK_U8, 8, -1024, 37, 24},   {BRICK_I8, 8, 0, 0, 0},     {BRICK_U16, 1, -1024, 215, -40},
                 {BRICK_I16, -0.7, 12.3, 90, 0}, {BRICK_F32, 1, 0, 45, 35},  {BRICK_I16, 1, 0, 0, 90},
                 {BRICK_U16, -1, 2000, 300, 5},  {BRICK_F32, 1, 0, 180, -90}};
    bool skipped = false;
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases && !skipped; i++) {
        struct memory_source source;
        struct vr_scene scene = vr_scene_defaults;
        struct brick_volume *volume =
            wave_volume(&source, cases[i].type, NX, NY, NZ, voxels, cases[i].slope, cases[i].intercept, 16);
        struct brick_transfer *transfer = transfer_of(cells_points, 4);
        struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
        scene.transfer = transfer;
        for (int perspective = 0; perspective < 2 && renderer; perspective++) {
            look(&scene, volume, cases[i].azimuth, cases[i].elevation, perspective);
            against_exact(renderer, volume, &scene, brick_type_name(cases[i].type));
        }
        skipped = !renderer;
        vr_renderer_destroy(&renderer);
        brick_transfer_destroy(&transfer);
        brick_volume_close(&volume);
    }
    if (skipped)
        skip();
}

/* Volumes of one voxel on an axis are all rim; coarser levels of odd sizes stick out of level 0's box. */
static void test_thin_and_levels(void **state)
{
    static float voxels[NX * NY * NZ];
    static const int sizes[][3] = {{1, NY, NZ}, {NX, 1, NZ}, {NX, NY, 1}, {NX, NY, NZ}};
    bool skipped = false;
    (void)state;
    for (int i = 0; i < 4 && !skipped; i++) {
        struct memory_source source;
        struct vr_scene scene = vr_scene_defaults;
        struct brick_volume *volume =
            wave_volume(&source, BRICK_I16, sizes[i][0], sizes[i][1], sizes[i][2], voxels, 1, 0, 8);
        struct brick_transfer *transfer = transfer_of(cells_points, 4);
        struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
        scene.transfer = transfer;
        const uint32_t levels = brick_volume_grid(volume)->levels;
        for (int perspective = 0; perspective < 2 && renderer; perspective++) {
            look(&scene, volume, 25, 15, perspective);
            scene.level = 0;
            if (i < 3)
                against_exact(renderer, volume, &scene, "thin");
            for (scene.level = 1; i == 3 && scene.level < levels; scene.level++)
                against_exact(renderer, volume, &scene, "coarser level");
        }
        skipped = !renderer;
        vr_renderer_destroy(&renderer);
        brick_transfer_destroy(&transfer);
        brick_volume_close(&volume);
    }
    if (skipped)
        skip();
}

/* A box with a corner cut off, planes that rays run along, the eye inside. */
static void test_clip(void **state)
{
    static float voxels[NX * NY * NZ];
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    for (int perspective = 0; perspective < 2 && f.renderer; perspective++) {
        const double *centre = f.scene.camera.look_mm;
        look(&f.scene, f.volume, 37, 24, perspective);
        for (int i = 0; i < 6; i++) {
            double sign = i < 3 ? 1.0 : -1.0;
            f.scene.clip[i].normal[i % 3] = sign;
            f.scene.clip[i].offset_mm = sign * centre[i % 3] - 7.3;
        }
        f.scene.clip[5] =
            (struct vr_plane){{-1, 0.7, 0.4}, -centre[0] + 0.7 * centre[1] + 0.4 * centre[2] - 3};
        f.scene.clip_count = 6;
        against_exact(f.renderer, f.volume, &f.scene, "clip planes");
        look(&f.scene, f.volume, 0, 0, perspective);
        against_exact(f.renderer, f.volume, &f.scene, "clip planes along rays");
        f.scene.clip_count = 0;
        look(&f.scene, f.volume, 37, 24, perspective);
        for (int i = 0; i < 3; i++)
            f.scene.camera.eye_mm[i] = 0.02 * f.scene.camera.eye_mm[i] + 0.98 * centre[i];
        against_exact(f.renderer, f.volume, &f.scene, "eye inside");
    }
    fixture_finish(&f);
}

static void test_nonfinite(void **state)
{
    static float voxels[NX * NY * NZ];
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_F32, voxels);
    brick_volume_close(&f.volume);
    vr_renderer_destroy(&f.renderer);
    for (uint64_t i = 0; i < 200; i++)
        voxels[noise64(3, i) % (NX * NY * NZ)] = i % 3 ? (i % 3 == 1 ? NAN : INFINITY) : 1e4f;
    f.volume = volume_of(&f.source, 16);
    f.renderer = try_renderer(f.volume, VR_CONTEXT_AUTO);
    for (int perspective = 0; perspective < 2 && f.renderer; perspective++) {
        struct brick_image image, all;
        look(&f.scene, f.volume, 37, 24, perspective);
        f.quality.skip = true;
        against_exact(f.renderer, f.volume, &f.scene, "not finite");
        render(f.renderer, &f.scene, &f.quality, &image, NULL);
        f.quality.skip = false;
        render(f.renderer, &f.scene, &f.quality, &all, NULL);
        assert_same_image(&image, &all, "no skipping, not finite");
        brick_image_finish(&image);
        brick_image_finish(&all);
    }
    fixture_finish(&f);
}

/* The same bytes from a cache of two bricks, in parts, and with nothing skipped. For other bricks as well in
 * perspective; of parallel rays the same but for tetrahedra that one passes within 1/256 pixel, whose order
 * is not determined. */
static void check_memory(const struct fixture *f, struct fixture *other_bricks)
{
    struct vr_renderer_params params = vr_renderer_defaults;
    struct vr_quality all = f->quality;
    struct vr_renderer *small = NULL;
    struct brick_image image, other;
    struct vr_report report, few;
    struct brick_image_difference d;
    render(f->renderer, &f->scene, &f->quality, &image, &report);
    params.gpu_cache_bytes = params.host_cache_bytes = 2 * 20 * 20 * 20 * sizeof(int16_t);
    assert_int_equal(vr_renderer_create(&small, f->volume, &params, NULL), 0);
    render(small, &f->scene, &f->quality, &other, &few);
    assert_same_image(&image, &other, "a cache of two bricks");
    assert_true(few.passes > report.passes && few.gpu_cache_bytes <= params.gpu_cache_bytes);
    assert_int_equal(few.samples, report.samples);
    brick_image_finish(&other);
    vr_renderer_destroy(&small);

    all.skip = false;
    render(f->renderer, &f->scene, &all, &other, &few);
    assert_same_image(&image, &other, "no skipping");
    assert_true(few.samples > report.samples);
    brick_image_finish(&other);

    render(other_bricks->renderer, &f->scene, &f->quality, &other, &few);
    assert_int_equal(brick_image_compare(&image, &other, &d, NULL), 0);
    print_message("bricks of 32: %g\n", d.max_abs);
    assert_true(d.max_abs <= (f->scene.camera.ortho_height_mm > 0.0 ? 1e-5 : 0.0));
    assert_int_equal(few.samples, report.samples);
    brick_image_finish(&image);
    brick_image_finish(&other);
}

static void test_memory(void **state)
{
    static float voxels[NX * NY * NZ];
    struct fixture f, other;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    other = f;
    other.volume = volume_of(&f.source, 32);
    other.renderer = try_renderer(other.volume, VR_CONTEXT_AUTO);
    for (int perspective = 0; perspective < 2 && f.renderer; perspective++) {
        look(&f.scene, f.volume, 37, 24, perspective);
        f.scene.width = 1030; /* more than one part */
        f.scene.height = 40;
        check_memory(&f, &other);
    }
    vr_renderer_destroy(&other.renderer);
    brick_volume_close(&other.volume);
    fixture_finish(&f);
}

/* Where the transfer function has no knot between a tetrahedron's ends partial pre-integration is exact but
 * for its table, and the ends' mean scalar has the mean colour; exponentials by table are off by 2e-6 each.
 */
static void test_integrations(void **state)
{
    static float voxels[NX * NY * NZ];
    static const struct brick_transfer_point straight[] = {{-1100, 0.1, 0.9, 0.2, 0.0},
                                                           {1100, 0.9, 0.2, 0.6, 0.01}};
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    for (int perspective = 0; perspective < 2 && f.renderer; perspective++) {
        struct brick_transfer *transfer = transfer_of(straight, 2);
        struct brick_image image[VR_CELLS_INTEGRATIONS];
        struct brick_image_difference d;
        look(&f.scene, f.volume, 37, 24, perspective);
        f.scene.transfer = transfer;
        assert_int_equal(transfer->count, 2);
        for (int i = 0; i < VR_CELLS_INTEGRATIONS; i++) {
            f.quality.cells_integration = (enum vr_cells_integration)i;
            render(f.renderer, &f.scene, &f.quality, &image[i], NULL);
        }
        static const struct {
            int a, b;
            double limit;
        } pairs[] = {
            {VR_CELLS_PREFIX, VR_CELLS_EXACT, 2e-6},   /* rounding: depths are far below 0.1 */
            {VR_CELLS_PSI, VR_CELLS_EXACT, 2e-5},      /* some 100 times the table's error, times colour */
            {VR_CELLS_SCALAR, VR_CELLS_AVERAGE, 4e-6}, /* rounding */
            {VR_CELLS_EXP, VR_CELLS_AVERAGE, 3e-4},    /* some 150 times 1.9e-6 */
            {VR_CELLS_AVERAGE, VR_CELLS_EXACT, 2e-4}}; /* depth^2 / 12 of the colour's change, summed */
        for (int i = 0; i < 5; i++) {
            assert_int_equal(brick_image_compare(&image[pairs[i].a], &image[pairs[i].b], &d, NULL), 0);
            print_message("integration %d and %d: %.2g\n", pairs[i].a, pairs[i].b, d.max_abs);
            assert_true(d.max_abs < pairs[i].limit && d.max_abs > 0.0);
        }
        for (int i = 0; i < VR_CELLS_INTEGRATIONS; i++)
            brick_image_finish(&image[i]);
        brick_transfer_destroy(&transfer);
    }
    fixture_finish(&f);
}

static void refuse(const struct fixture *f, int code, const char *mention)
{
    struct brick_error err = {0};
    struct brick_image image;
    assert_int_equal(brick_image_init(&image, f->scene.width, f->scene.height, &err), 0);
    assert_int_equal(vr_render(f->renderer, &f->scene, &f->quality, &image, NULL, &err), code);
    assert_non_null(strstr(err.message, mention));
    brick_image_finish(&image);
}

static void test_refusals(void **state)
{
    static float voxels[NX * NY * NZ];
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    if (f.renderer) {
        f.scene.mode = BRICK_MODE_SHADED;
        refuse(&f, BRICK_ERR_UNSUPPORTED, "dvr only");
        f.scene.mode = BRICK_MODE_DVR;
        f.quality.cells_integration = VR_CELLS_INTEGRATIONS;
        refuse(&f, BRICK_ERR_ARGUMENT, "integration");
    }
    fixture_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types),    cmocka_unit_test(test_thin_and_levels),
        cmocka_unit_test(test_clip),     cmocka_unit_test(test_nonfinite),
        cmocka_unit_test(test_memory),   cmocka_unit_test(test_integrations),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests_name("cells", tests, NULL, NULL);
}
