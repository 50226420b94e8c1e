/* Pictures in steps: whatever the budget, the final one has vr_render's bytes; those before it come nearer
 * and nearer, from what a coarser level shows on; and one picture may begin in the middle of another. */
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
#define EDGE 48

static int16_t voxels[NX * NY * NZ];
static const struct brick_transfer_point points[] = {
    {150, 0.2, 0.1, 0.1, 0.0}, {400, 0.9, 0.3, 0.1, 0.05}, {900, 1, 1, 0.9, 0.3}};

static struct brick_volume *volume_of_blobs(void)
{
    struct memory_source source;
    for (int i = 0; i < NX * NY * NZ; i++) {
        double v =
            1100.0 * sin(0.11 * (i % NX) + 0.3) * sin(0.13 * (i / NX % NY)) * cos(0.09 * (i / NX / NY)) -
            150.0;
        voxels[i] = (int16_t)(v < 0.0 ? 0.0 : v + (double)(noise64(3, (uint64_t)i) % 40));
    }
    memory_source_init(&source, BRICK_I16, NX, NY, NZ, voxels);
    return volume_of(&source, 16);
}

static struct vr_scene scene_of(int mode, double azimuth, const struct brick_transfer *transfer,
                                const struct brick_grid *grid)
{
    struct vr_scene scene = vr_scene_defaults;
    scene.mode = (enum brick_mode)mode;
    scene.transfer = transfer;
    scene.isovalue = 300.0;
    scene.width = scene.height = EDGE;
    brick_camera_orbit(&scene.camera, grid, azimuth, 25, 0, 0, 1.0);
    return scene;
}

static struct vr_renderer *renderer_with(const struct brick_volume *volume, uint64_t bricks)
{
    struct vr_renderer_params params = vr_renderer_defaults;
    if (bricks)
        params.gpu_cache_bytes = slots_bytes(volume, bricks);
    return renderer_of(volume, &params);
}

static void begin(struct vr_renderer *renderer, const struct vr_scene *scene)
{
    struct brick_error err = {0};
    if (vr_render_begin(renderer, scene, &vr_quality_defaults, &err))
        fail_msg("%s", err.message);
}

static bool go_on(struct vr_renderer *renderer, const struct vr_budget *budget, struct brick_image *image,
                  struct vr_report *report)
{
    struct brick_error err = {0};
    bool final;
    if (vr_render_continue(renderer, budget, image, &final, report, &err))
        fail_msg("%s", err.message);
    return final;
}

static void test_final(void **state)
{
    (void)state;
    static const uint64_t caches[] = {0, 1, 2, 8, 20};
    struct brick_volume *volume = volume_of_blobs();
    const uint64_t brick = slots_bytes(volume, 1);
    const struct vr_budget budgets[] = {{0.0, 1},           {0.0, 3 * brick}, {0.0, 25 * brick}, {1e-9, 0},
                                        {0.01, 10 * brick}, {0.0, 0},         {100.0, 0}};
    struct brick_transfer *transfer = transfer_of(points, sizeof points / sizeof points[0]);
    struct vr_renderer *plain = renderer_with(volume, 0);
    struct brick_image image;
    struct brick_error err = {0};
    assert_int_equal(brick_image_init(&image, EDGE, EDGE, &err), 0);
    for (int mode = 0; plain && mode < 4; mode++) {
        const struct vr_scene scene = scene_of(mode, 35, transfer, brick_volume_grid(volume));
        struct brick_image whole;
        struct vr_report report, counted;
        render(plain, &scene, &vr_quality_defaults, &whole, &report);
        for (size_t c = 0; c < sizeof caches / sizeof caches[0]; c++)
            for (size_t b = 0; b < sizeof budgets / sizeof budgets[0]; b++) {
                struct vr_renderer *renderer = renderer_with(volume, caches[c]);
                char line[100];
                int calls = 1;
                begin(renderer, &scene);
                while (!go_on(renderer, &budgets[b], &image, &counted))
                    calls++;
                snprintf(line, sizeof line, "mode %d, %llu bricks, budget %zu", mode,
                         (unsigned long long)caches[c], b);
                assert_same_image(&image, &whole, line);
                assert_true(counted.samples == report.samples);
                assert_true(counted.gpu_cache_peak_bytes <= counted.gpu_cache_bytes);
                if (b == 0) /* a brick a call, but for those that stand in */
                    assert_true((uint64_t)calls + caches[c] / 8 + 16 > counted.bricks_loaded);
                if (b >= 5)
                    assert_int_equal(calls, 1);
                vr_renderer_destroy(&renderer);
            }
        brick_image_finish(&whole);
    }
    brick_image_finish(&image);
    end_or_skip(&plain, &transfer, &volume);
}

static double rmse(const struct brick_image *a, const struct brick_image *b)
{
    struct brick_image_difference d;
    brick_image_compare(a, b, &d, NULL);
    return d.rmse;
}

/* From the coarse levels' picture on towards the final one. Level 2 stands in; a stand-in is sampled at a
 * quarter of the rate, and off its own level's place in the step by up to half of that. */
static void test_on_the_way(void **state)
{
    (void)state;
    struct brick_volume *volume = volume_of_blobs();
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct vr_budget budget = {.upload_bytes = slots_bytes(volume, 6)};
    struct brick_transfer *transfer = transfer_of(points, sizeof points / sizeof points[0]);
    struct vr_renderer *renderer = renderer_with(volume, 0);
    for (int mode = 0; renderer && mode < 4; mode++) {
        struct vr_scene scene = scene_of(mode, 35, transfer, grid);
        struct brick_image final, coarse, image;
        struct vr_report report;
        render(renderer, &scene, &vr_quality_defaults, &final, &report);
        scene.level = 2;
        render(renderer, &scene, &vr_quality_defaults, &coarse, &report);
        scene.level = 0;
        const double bound = rmse(&coarse, &final);
        double best = 1.25 * bound, now = INFINITY;
        int calls = 0;
        vr_renderer_destroy(&renderer);
        renderer = renderer_with(volume, 0); /* with nothing in its caches */
        assert_int_equal(brick_image_init(&image, EDGE, EDGE, &(struct brick_error){0}), 0);
        begin(renderer, &scene);
        for (; !go_on(renderer, &budget, &image, &report); calls++) {
            now = rmse(&image, &final);
            if (now > 1.05 * best)
                fail_msg("mode %d, call %d: off by %g, before by %g, level 2 by %g", mode, calls, now, best,
                         bound);
            best = fmin(best, now);
        }
        assert_true(calls > 10);
        assert_true(now < bound / 4); /* the last before the final one */
        brick_image_finish(&image);
        brick_image_finish(&final);
        brick_image_finish(&coarse);
    }
    end_or_skip(&renderer, &transfer, &volume);
}

/* Another camera, level or picture of several targets in the middle; the fast filter; calls out of turn. */
static void test_restart(void **state)
{
    (void)state;
    struct brick_volume *volume = volume_of_blobs();
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct vr_budget budget = {.upload_bytes = slots_bytes(volume, 4)};
    struct brick_transfer *transfer = transfer_of(points, sizeof points / sizeof points[0]);
    bool none = false;
    for (int filter = 0; filter < 2 && !none; filter++) {
        struct vr_renderer_params params = vr_renderer_defaults;
        params.filter = (enum vr_filter)filter;
        params.gpu_cache_bytes = slots_bytes(volume, 40);
        struct vr_renderer *renderer = renderer_of(volume, &params);
        struct brick_error err = {0};
        struct vr_report report;
        bool final;
        none = !renderer;
        for (int turn = 0; renderer && turn < 6; turn++) {
            struct vr_scene scene = scene_of(BRICK_MODE_SHADED, 35 + 60 * turn, transfer, grid);
            struct brick_image image, whole;
            scene.level = turn % 3 == 2;
            if (turn == 3) {
                scene.width = 1100; /* two targets */
                scene.height = 30;
                brick_camera_orbit(&scene.camera, grid, 20, 10, 0, 0, 1100.0 / 30.0);
                scene.camera.fov_deg = 5;
            }
            assert_int_equal(brick_image_init(&image, scene.width, scene.height, &err), 0);
            begin(renderer, &scene);
            for (int calls = 0; calls < 2; calls++)
                assert_false(go_on(renderer, &budget, &image, &report));
            if (turn % 2 == 0) { /* another camera, and back */
                struct vr_scene other = scene;
                brick_camera_orbit(&other.camera, grid, 200, -20, 0, 0, 1.0);
                begin(renderer, &other);
                assert_false(go_on(renderer, &budget, &image, &report));
                begin(renderer, &scene);
            }
            while (!go_on(renderer, &budget, &image, &report))
                if (turn == 3) {
                    double sum[2] = {0.0, 0.0};
                    for (uint32_t i = 0; i < scene.width * scene.height; i++)
                        sum[i % scene.width >= 1024] += (double)image.rgba[4 * i + 3];
                    assert_true(sum[0] > 0.0);
                }
            assert_int_equal(vr_render_continue(renderer, &budget, &image, &final, &report, &err),
                             BRICK_ERR_ARGUMENT);
            render(renderer, &scene, &vr_quality_defaults, &whole, &report);
            assert_same_image(&image, &whole, "after a restart");
            brick_image_finish(&whole);
            begin(renderer, &scene);
            image.width--;
            assert_int_equal(vr_render_continue(renderer, NULL, &image, &final, NULL, &err),
                             BRICK_ERR_ARGUMENT);
            image.width++;
            /* A picture that cannot begin ends the one before it all the same. */
            struct vr_scene bad = scene;
            memcpy(bad.camera.look_mm, bad.camera.eye_mm, sizeof bad.camera.look_mm);
            assert_int_equal(vr_render_begin(renderer, &bad, &vr_quality_defaults, &err), BRICK_ERR_ARGUMENT);
            assert_int_equal(vr_render_continue(renderer, NULL, &image, &final, NULL, &err),
                             BRICK_ERR_ARGUMENT);
            brick_image_finish(&image);
        }
        vr_renderer_destroy(&renderer);
    }
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
    if (none)
        skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_on_the_way),
        cmocka_unit_test(test_restart),
        cmocka_unit_test(test_final),
    };
    return cmocka_run_group_tests_name("progress", tests, NULL, NULL);
}
