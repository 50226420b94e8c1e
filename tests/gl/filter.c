/* The fast filter: one picture for every brick edge, cache, slot and driver of the same sampler, with and
 * without skipping; as far from the exact filter's as rounded fractions allow; and never a value outside its
 * cell's corners. */
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

#define N    61
#define EDGE 48 /* of pictures */

/* White, and opacity a mm linear in the value: both pictures depend on the value everywhere, and no more than
 * the ramp is steep. */
static const struct brick_transfer_point ramp[] = {{20, 1, 1, 1, 0.0}, {230, 1, 1, 1, 0.2}};
#define RAMP_SLOPE (0.2 / 210.0 / 0.8) /* of the extinction: dA / (1 - A) */
/* With jumps and colours: what a wrong bit shows in. */
static const struct brick_transfer_point steps[] = {
    {20, 0.2, 0.1, 0.1, 0.0}, {60, 0.9, 0.3, 0.1, 0.1}, {60, 0.1, 0.9, 0.1, 0.02}, {180, 1, 1, 0.9, 0.7}};

static const enum brick_type types[] = {BRICK_U8, BRICK_I8, BRICK_U16, BRICK_I16, BRICK_F32};
#define TYPES (int)(sizeof types / sizeof types[0])

static double blob(size_t i)
{
    size_t x = i % N, y = i / N % N, z = i / N / N;
    double v = 240.0 * sin(0.11 * (double)x + 0.3) * sin(0.13 * (double)y) * cos(0.09 * (double)z) - 30.0;
    return v < 0.0 ? 0.0 : floor(v) + (double)(noise64(3, i) % 10);
}

/* The greatest difference between neighbours: of the field's slope along an axis. */
static double steepest(void)
{
    static const size_t stride[3] = {1, N, N * N};
    double most = 0.0;
    for (size_t i = 0; i < N * N * N; i++)
        for (int a = 0; a < 3; a++)
            if (i / stride[a] % N + 1 < N)
                most = fmax(most, fabs(blob(i + stride[a]) - blob(i)));
    return most;
}

static struct brick_volume *volume_with(enum brick_type type, uint32_t edge, double first, bool constant,
                                        bool holes)
{
    static float voxels[N * N * N]; /* of any type */
    struct memory_source source;
    for (size_t i = 0; i < N * N * N; i++)
        store_voxel(type, voxels, i,
                    holes && noise64(5, i) % 300 == 0 ? (i % 2 ? NAN : INFINITY)
                                                      : first + (constant ? -(i == 0) : blob(i)));
    memory_source_init(&source, type, N, N, N, voxels);
    source.base.geometry.intercept = -first;
    return volume_of(&source, edge);
}

/* Stored values begin somewhere inside the type's range, physical ones at 0. */
static struct brick_volume *blobs_of(enum brick_type type, uint32_t edge, bool holes)
{
    static const double first[BRICK_TYPE_STORED_COUNT] = {
        [BRICK_I8] = -100, [BRICK_U16] = 40000, [BRICK_I16] = -80, [BRICK_F32] = 0.5};
    return volume_with(type, edge, first[type], false, holes);
}

static struct vr_scene scene_of(int mode, const struct brick_transfer *transfer,
                                const struct brick_grid *grid)
{
    struct vr_scene scene = vr_scene_defaults;
    scene.mode = (enum brick_mode)mode;
    scene.transfer = transfer;
    scene.isovalue = 90.0;
    scene.width = scene.height = EDGE;
    brick_camera_orbit(&scene.camera, grid, 35, 25, 0, 0, 1.0);
    return scene;
}

static struct vr_renderer *filtering(const struct brick_volume *volume, enum vr_context_kind kind,
                                     enum vr_filter filter, uint64_t bricks)
{
    struct vr_renderer_params params = vr_renderer_defaults;
    params.context = kind;
    params.filter = filter;
    if (bricks) /* filtered integers take 16 bits */
        params.gpu_cache_bytes =
            slots_bytes(volume, bricks) * (brick_type_bytes(brick_volume_grid(volume)->type) == 1 ? 2 : 1);
    return renderer_of(volume, &params);
}

/* Cameras, caches, edges, skipping and drivers change no bit. */
static void test_invariance(void **state)
{
    (void)state;
    static const struct {
        uint32_t edge;
        enum vr_context_kind kind;
        uint64_t bricks;
        bool skip;
    } runs[] = {{16, VR_CONTEXT_EGL, 0, true}, {16, VR_CONTEXT_EGL, 0, false},
                {16, VR_CONTEXT_EGL, 8, true}, {16, VR_CONTEXT_OSMESA, 30, true},
                {32, VR_CONTEXT_EGL, 0, true}, {32, VR_CONTEXT_EGL, 8, false},
                {64, VR_CONTEXT_EGL, 0, true}};
    struct brick_transfer *transfer = transfer_of(steps, sizeof steps / sizeof steps[0]);
    bool any = false;
    for (int t = 0; t < TYPES; t++) {
        struct brick_image images[4] = {{0}};
        for (size_t r = 0; r < sizeof runs / sizeof runs[0]; r++) {
            struct brick_volume *volume = blobs_of(types[t], runs[r].edge, false);
            struct vr_renderer *renderer = filtering(volume, runs[r].kind, VR_FILTER_FAST, runs[r].bricks);
            for (int mode = 0; renderer && mode < 4; mode++) {
                const struct vr_scene scene = scene_of(mode, transfer, brick_volume_grid(volume));
                struct vr_quality quality = vr_quality_defaults;
                struct brick_image image;
                struct vr_report report;
                char line[120];
                quality.skip = runs[r].skip;
                render(renderer, &scene, &quality, &image, &report);
                any = true;
                assert_true(report.gpu_cache_peak_bytes <= report.gpu_cache_bytes);
                if (runs[r].bricks) {
                    assert_true(report.passes > 1);
                    assert_true(report.gpu_cache_bytes <= slots_bytes(volume, runs[r].bricks) * 2);
                }
                snprintf(line, sizeof line, "type %d, run %zu, mode %d", (int)types[t], r, mode);
                if (!images[mode].rgba) {
                    assert_true(image.rgba[4 * (EDGE / 2 * EDGE + EDGE / 2) + 3] > 0.1f);
                    images[mode] = image;
                    continue;
                }
                assert_same_image(&image, &images[mode], line);
                brick_image_finish(&image);
            }
            vr_renderer_destroy(&renderer);
            brick_volume_close(&volume);
        }
        for (int mode = 0; mode < 4; mode++)
            brick_image_finish(&images[mode]);
    }
    brick_transfer_destroy(&transfer);
    if (!any)
        skip();
}

/* A fraction is off by 2^-12 at most (2^-13 but just below 1), the field by that times its slope along each
 * axis, and half a grain. Opacity of a picture: mip by the ramp's slope, dvr by that times the ray's length.
 */
static void test_error(void **state)
{
    (void)state;
    const double field = 3 * 0x1p-12 * steepest() + 0x1p-5;
    const double bounds[2] = {field * RAMP_SLOPE, field * RAMP_SLOPE * N * sqrt(3.0)};
    static const int modes[2] = {BRICK_MODE_MIP, BRICK_MODE_DVR};
    struct brick_transfer *transfer = transfer_of(ramp, sizeof ramp / sizeof ramp[0]);
    bool any = false;
    for (int t = 0; t < TYPES; t++) {
        struct brick_volume *volume = blobs_of(types[t], 32, false);
        struct vr_renderer *fast = filtering(volume, VR_CONTEXT_AUTO, VR_FILTER_FAST, 0);
        struct vr_renderer *exact = filtering(volume, VR_CONTEXT_AUTO, VR_FILTER_EXACT, 0);
        for (int m = 0; fast && exact && m < 2; m++) {
            const struct vr_scene scene = scene_of(modes[m], transfer, brick_volume_grid(volume));
            struct vr_quality quality = vr_quality_defaults;
            struct brick_image a, b;
            struct vr_report report;
            struct brick_image_difference d;
            quality.termination = 0.0;
            render(fast, &scene, &quality, &a, &report);
            render(exact, &scene, &quality, &b, &report);
            brick_image_compare(&a, &b, &d, NULL);
            print_message("type %d, mode %d: differs by %.2e, allowed %.2e\n", (int)types[t], modes[m],
                          d.max_abs, bounds[m]);
            assert_true(d.max_abs < bounds[m]);
            assert_true(d.max_abs > 0.0); /* it is another filter */
            brick_image_finish(&a);
            brick_image_finish(&b);
            any = true;
        }
        vr_renderer_destroy(&fast);
        vr_renderer_destroy(&exact);
        brick_volume_close(&volume);
    }
    brick_transfer_destroy(&transfer);
    if (!any)
        skip();
}

/* Volumes that are constant but for a corner's voxel, and a transfer function that jumps from opaque to
 * nothing at the constant: where values are looked at, one that falls short of it by a bit shows; where
 * macrocells are skipped, none does. */
static void test_stays_in_range(void **state)
{
    (void)state;
    static const struct brick_transfer_point below[] = {
        {-1, 1, 1, 1, 0.9}, {0, 1, 1, 1, 0.9}, {0, 1, 1, 1, 0.0}};
    struct brick_transfer *transfer = transfer_of(below, sizeof below / sizeof below[0]);
    bool any = false;
    for (int t = 0; t < TYPES; t++)
        for (int k = 1; k < 100; k += 7) {
            const double first = types[t] == BRICK_U16   ? 555.0 * k
                                 : types[t] == BRICK_I16 ? 555.0 * k - 27000.0
                                 : types[t] == BRICK_I8  ? k - 50.0
                                                         : k;
            struct brick_volume *volume = volume_with(types[t], 64, first, true, false);
            struct vr_renderer *renderer = filtering(volume, VR_CONTEXT_AUTO, VR_FILTER_FAST, 0);
            if (renderer) {
                const struct vr_scene scene = scene_of(BRICK_MODE_DVR, transfer, brick_volume_grid(volume));
                struct vr_quality quality = vr_quality_defaults;
                struct brick_image skipped, looked;
                struct vr_report report;
                char line[80];
                render(renderer, &scene, &quality, &skipped, &report);
                assert_true(report.bricks_active == 1);
                quality.skip = false;
                render(renderer, &scene, &quality, &looked, &report);
                snprintf(line, sizeof line, "type %d, constant %g", (int)types[t], first);
                assert_same_image(&skipped, &looked, line);
                brick_image_finish(&skipped);
                brick_image_finish(&looked);
                any = true;
            }
            vr_renderer_destroy(&renderer);
            brick_volume_close(&volume);
        }
    brick_transfer_destroy(&transfer);
    if (!any)
        skip();
}

/* No standard says what a sampler makes of NaN: such volumes have the exact filter's picture. */
static void test_nonfinite(void **state)
{
    (void)state;
    struct brick_transfer *transfer = transfer_of(steps, sizeof steps / sizeof steps[0]);
    struct brick_volume *volume = blobs_of(BRICK_F32, 32, true);
    struct vr_renderer *fast = filtering(volume, VR_CONTEXT_AUTO, VR_FILTER_FAST, 0);
    struct vr_renderer *exact = filtering(volume, VR_CONTEXT_AUTO, VR_FILTER_EXACT, 0);
    const bool none = !fast || !exact;
    if (!none) {
        const struct vr_scene scene = scene_of(BRICK_MODE_DVR, transfer, brick_volume_grid(volume));
        struct brick_image a, b;
        struct vr_report report;
        render(fast, &scene, &vr_quality_defaults, &a, &report);
        render(exact, &scene, &vr_quality_defaults, &b, &report);
        assert_same_image(&a, &b, "a volume with NaN");
        brick_image_finish(&a);
        brick_image_finish(&b);
    }
    vr_renderer_destroy(&fast);
    vr_renderer_destroy(&exact);
    brick_volume_close(&volume);
    brick_transfer_destroy(&transfer);
    if (none)
        skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_invariance),
        cmocka_unit_test(test_error),
        cmocka_unit_test(test_stays_in_range),
        cmocka_unit_test(test_nonfinite),
    };
    return cmocka_run_group_tests_name("filter", tests, NULL, NULL);
}
