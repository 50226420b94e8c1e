/* Against the exact integral: the error of rays and of slices falls by four as the step halves, down to
 * float32's floor; pre-integrated it falls also where the transfer function has a peak that steps pass over.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_scene.h"

#define N     48
#define STEPS 5

static const struct brick_transfer_point wide[] = {{-400, 0.1, 0.2, 0.9, 0.0},
                                                   {100, 0.9, 0.4, 0.1, 0.02},
                                                   {600, 1, 1, 0.8, 0.25},
                                                   {1000, 0.3, 0.9, 0.4, 0.4}};
/* The field changes by up to 190 a voxel. */
static const struct brick_transfer_point peaks[] = {{-520, 0, 1, 0, 0.0},       {-512, 0, 1, 0.3, 0.9},
                                                    {-504, 0.2, 1, 0, 0.0},     {295, 1, 0.1, 0, 0.0},
                                                    {300, 0.9, 0.9, 0.1, 0.99}, {305, 0.1, 0.2, 1, 0.0}};

/* The longest step: slices that far apart are seen from the eye less than a voxel apart. */
#define LONGEST 0.9

/* RMSE at steps of LONGEST, half of it, ...; false where there is no context. */
static bool measure(const struct brick_transfer_point *points, size_t count, enum vr_method method,
                    enum vr_classification classification, double rmse[STEPS])
{
    static int16_t voxels[N * N * N];
    struct memory_source source;
    struct brick_image exact = {0};
    struct brick_error err = {0};
    for (int i = 0; i < N * N * N; i++)
        voxels[i] =
            (int16_t)(700 * sin(0.25 * (i % N)) * cos(0.2 * (i / N % N)) + 300 * sin(0.31 * (i / N / N)));
    memory_source_init(&source, BRICK_I16, N, N, N, voxels);
    struct brick_volume *volume = volume_of(&source, 32);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    struct brick_transfer *transfer = transfer_of(points, count);
    if (renderer) {
        struct vr_scene scene = vr_scene_defaults;
        struct vr_quality quality = vr_quality_defaults;
        scene.width = scene.height = 48;
        scene.transfer = transfer;
        brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 33, 21, 0, 0, 1.0);
        quality.termination = 0.0;
        quality.method = method;
        quality.slices.planes = 0; /* as the step says */
        quality.classification = classification;
        assert_int_equal(brick_image_init(&exact, 48, 48, &err), 0);
        if (vr_render_exact(volume, &scene, &vr_exact_defaults, &exact, NULL, &err))
            fail_msg("%s", err.message);
        for (int i = 0; i < STEPS; i++) {
            struct brick_image image;
            struct brick_image_difference d;
            quality.step_vox = ldexp(LONGEST, -i);
            render(renderer, &scene, &quality, &image, NULL);
            assert_int_equal(brick_image_compare(&image, &exact, &d, &err), 0);
            brick_image_finish(&image);
            rmse[i] = d.rmse;
            print_message("method %d, step %g/%d: rmse %.3e, max %.3e\n", (int)method, LONGEST, 1 << i,
                          d.rmse, d.max_abs);
        }
        brick_image_finish(&exact);
    }
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
    bool measured = renderer != NULL;
    vr_renderer_destroy(&renderer);
    return measured;
}

/* The field's kinks at cell faces and the transfer function's at control points leave the order at 2 on the
 * average over pixels: from 1/2 on a factor of 4 less what is left of higher orders. */
static void assert_second_order(const double rmse[STEPS])
{
    for (int i = 2; i < STEPS; i++)
        assert_true(rmse[i - 1] / rmse[i] > 3.3 && rmse[i - 1] / rmse[i] < 5.0);
}

/* Where samples fall is another matter for slices than for rays, and chance: errors are as large as each
 * other but for that. */
static void assert_alike(const double slices[STEPS], const double rays[STEPS])
{
    for (int i = 0; i < STEPS; i++)
        assert_true(slices[i] < 1.5 * rays[i] && rays[i] < 1.5 * slices[i]);
}

static void test_order(void **state)
{
    static const enum vr_classification ways[] = {VR_CLASSIFY_POST, VR_CLASSIFY_PREINTEGRATED};
    (void)state;
    for (int i = 0; i < 2; i++) {
        double rays[STEPS], slices[STEPS];
        if (!measure(wide, 4, VR_METHOD_RAYCAST, ways[i], rays) ||
            !measure(wide, 4, VR_METHOD_SLICES, ways[i], slices))
            skip();
        assert_second_order(rays);
        assert_second_order(slices);
        assert_alike(slices, rays);
    }
}

static void test_peaks(void **state)
{
    double post[2][STEPS], preintegrated[2][STEPS];
    (void)state;
    for (int m = 0; m < 2; m++) {
        const enum vr_method method = m ? VR_METHOD_SLICES : VR_METHOD_RAYCAST;
        if (!measure(peaks, 6, method, VR_CLASSIFY_POST, post[m]) ||
            !measure(peaks, 6, method, VR_CLASSIFY_PREINTEGRATED, preintegrated[m]))
            skip();
        /* A step that passes over a peak finds it, but where the field turns inside a step and only just
         * reaches the peak, which is an area of the picture that shrinks with the square of the step, it may
         * not: RMSE has order 1. */
        assert_true(preintegrated[m][0] / preintegrated[m][STEPS - 1] > 16.0);
        for (int i = 0; i < STEPS; i++)
            assert_true(preintegrated[m][i] < post[m][i] / 4.0);
    }
    assert_alike(preintegrated[1], preintegrated[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_order),
        cmocka_unit_test(test_peaks),
    };
    return cmocka_run_group_tests_name("convergence", tests, NULL, NULL);
}
