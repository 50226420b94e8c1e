/* Hits on a ball against the exact method's: bisection leaves at most the step halved so many times, the
 * cubic only what rounding leaves, and a step of five voxels with refinement gives the exact picture but for
 * the ball's rim. And interleaved samples, of which each pixel's lie where the definition puts them. */
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

#define N      64
#define EDGE   72
#define CENTRE (0.5 * (N - 1) + 0.2)
#define RADIUS 24.0

static uint16_t voxels[N * N * N];

static void fill_ball(void)
{
    for (int i = 0; i < N * N * N; i++) {
        double x = i % N - CENTRE, y = i / N % N - CENTRE, z = i / N / N - CENTRE;
        voxels[i] = (uint16_t)fmax(0.0, 1000.0 * (RADIUS + 6.0 - sqrt(x * x + y * y + z * z)));
    }
}

/* How far from the centre the pixel's ray passes, of the radius. */
static double impact(const struct brick_view *view, uint32_t pixel)
{
    struct brick_ray ray;
    double along = 0.0, squared = 0.0;
    brick_view_ray(view, pixel % EDGE, pixel / EDGE, &ray);
    for (int a = 0; a < 3; a++)
        along += (CENTRE - ray.origin[a]) * ray.direction[a];
    for (int a = 0; a < 3; a++)
        squared += pow(ray.origin[a] + along * ray.direction[a] - CENTRE, 2.0);
    return sqrt(squared) / RADIUS;
}

static void test_hits(void **state)
{
    (void)state;
    static double hit_mm[EDGE * EDGE];
    static const double steps[] = {0.37, 1.0, 5.0};
    static const uint32_t bisections[] = {0, 6, 12};
    struct memory_source source;
    struct brick_error err = {0};
    struct brick_image exact = {0}, image;
    struct brick_view view;
    struct vr_report report;
    fill_ball();
    memory_source_init(&source, BRICK_U16, N, N, N, voxels);
    struct brick_volume *volume = volume_of(&source, 16);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    struct vr_scene scene = vr_scene_defaults;
    struct vr_exact_params params = vr_exact_defaults;
    scene.mode = BRICK_MODE_ISO;
    scene.isovalue = 6000.5;
    scene.width = scene.height = EDGE;
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 28, 17, 0, 0, 1.0);
    params.hit_mm = hit_mm;
    assert_int_equal(brick_view_init(&view, &scene.camera, brick_volume_grid(volume), EDGE, EDGE, &err), 0);
    assert_int_equal(brick_image_init(&exact, EDGE, EDGE, &err), 0);
    assert_int_equal(vr_render_exact(volume, &scene, &params, &exact, NULL, &err), 0);
    for (int run = 0; renderer && run < 3 * 4; run++) {
        const int s = run % 3, way = run / 3;
        struct vr_quality quality = vr_quality_defaults;
        int hits = 0;
        quality.step_vox = steps[s];
        quality.cubic = way == 3;
        quality.refinements = way < 3 ? bisections[way] : 0;
        quality.interleaved = run % 2;
        quality.distances = true;
        /* 2^-32 of the values' range of 2^15, and float32's rounding of it, over a slope of 400 a voxel:
         * 1e-5. */
        double bound = way == 3 ? 2e-5 : steps[s] * exp2(-(double)quality.refinements) + 2e-5;
        render(renderer, &scene, &quality, &image, &report);
        for (uint32_t i = 0; i < EDGE * EDGE; i++) {
            const float *p = image.rgba + 4 * i;
            if (p[3] > 0.0f)
                assert_true(isfinite(hit_mm[i]));
            if (impact(&view, i) > 0.9)
                continue;
            hits++;
            double error = fabs((double)p[0] + (double)p[1] - hit_mm[i]);
            if (!(p[3] > 0.0f) || !(error <= bound))
                fail_msg("step %g, way %d: pixel %u is off by %g voxels, bound %g", steps[s], way, i, error,
                         bound);
        }
        assert_true(hits > 500);
        brick_image_finish(&image);
        if (way < 2)
            continue;
        quality.distances = false;
        render(renderer, &scene, &quality, &image, &report);
        for (uint32_t i = 0; i < EDGE * EDGE; i++)
            for (int c = 0; c < 4 && impact(&view, i) <= 0.9; c++)
                if (!(fabs((double)image.rgba[4 * i + (uint32_t)c] -
                           (double)exact.rgba[4 * i + (uint32_t)c]) <= 2e-3))
                    fail_msg("step %g, way %d: pixel %u has another colour", steps[s], way, i);
        brick_image_finish(&image);
    }
    brick_image_finish(&exact);
    end_or_skip(&renderer, NULL, &volume);
}

/* A ramp along the view, and a step longer than the volume: mip says how deep a ray's last sample is, and
 * that its offset. */
static void test_pattern(void **state)
{
    (void)state;
    static const struct brick_transfer_point points[] = {{0, 1, 1, 1, 0.0}, {1000, 1, 1, 1, 0.9}};
    static const int bayer[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    enum { DEEP = 16 };
    static uint16_t ramp[8 * 8 * DEEP];
    struct memory_source source;
    struct brick_image image;
    struct vr_report report;
    for (int i = 0; i < 8 * 8 * DEEP; i++)
        ramp[i] = (uint16_t)(50 * (i / 64));
    memory_source_init(&source, BRICK_U16, 8, 8, DEEP, ramp);
    struct brick_volume *volume = volume_of(&source, 16);
    struct brick_transfer *transfer = transfer_of(points, 2);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    struct vr_scene scene = vr_scene_defaults;
    struct vr_quality quality = vr_quality_defaults;
    scene.transfer = transfer;
    scene.mode = BRICK_MODE_MIP;
    scene.width = scene.height = 8;
    scene.camera = (struct brick_camera){
        .eye_mm = {3.5, 3.5, -20}, .look_mm = {3.5, 3.5, 0}, .up = {0, -1, 0}, .ortho_height_mm = 6};
    quality.step_vox = 32.0; /* one piece, or two where it begins more than half a step before */
    quality.interleaved = true;
    if (renderer) {
        render(renderer, &scene, &quality, &image, &report);
        for (uint32_t i = 0; i < 64; i++) {
            /* The span is 16 voxels: pieces [-32 o, 32 - 32 o) and the next, cut to [0, 16). */
            double o = bayer[i / 8 % 4][i % 8 % 4] / 16.0, end = 32.0 * (1.0 - o);
            double deepest = end >= 16.0 ? 8.0 : 0.5 * (end + 16.0);
            double value = 50.0 * fmin(fmax(deepest - 0.5, 0.0), DEEP - 1.0);
            double alpha = (double)image.rgba[4 * i + 3], sigma, rgb[3];
            brick_transfer_eval(transfer, value, rgb, &sigma);
            if (!(fabs(alpha + expm1(-sigma * transfer->unit_mm)) <= 1e-5))
                fail_msg("pixel %u: alpha %g, not %g", i, alpha, -expm1(-sigma * transfer->unit_mm));
        }
        brick_image_finish(&image);
    }
    end_or_skip(&renderer, &transfer, &volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_hits), cmocka_unit_test(test_pattern)};
    return cmocka_run_group_tests_name("refinement", tests, NULL, NULL);
}
