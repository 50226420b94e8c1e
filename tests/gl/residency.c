/* The atlas and its upkeep: any arrangement of slots gives the same picture, bricks stay for later pictures,
 * and what does not fit is said with the size that would. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "atlas.h"
#include "gl_scene.h"

#define N 80

static uint8_t voxels[N * N * N];

static const struct brick_transfer_point low[] = {{20, 1, 0, 0, 0}, {60, 1, 1, 0, 0.2}, {90, 1, 1, 1, 0}};
static const struct brick_transfer_point high[] = {{150, 0, 0, 1, 0}, {200, 0, 1, 1, 0.6}};

/* A ball of growing values around a corner region: low and high ask for different bricks. */
static void fill(void)
{
    for (int i = 0; i < N * N * N; i++) {
        int x = i % N - 50, y = i / N % N - 30, z = i / N / N - 40, r = 255 - (x * x + y * y + z * z) / 8;
        voxels[i] = (uint8_t)(r < 0 ? 0 : r);
    }
}

static void test_arrange(void **state)
{
    (void)state;
    static const int limit[3] = {56, 56, 56};
    for (uint64_t want = 1; want < 3000; want += 37)
        for (uint64_t most = 1; most < 4000; most += 173) {
            int slots[3];
            assert_true(vr_atlas_arrange(want, most, limit, slots));
            uint64_t n = (uint64_t)slots[0] * (uint64_t)slots[1] * (uint64_t)slots[2];
            assert_true(n <= most);
            /* Enough, or nearly all that is allowed. */
            assert_true(n >= want || n * 10 >= most * 9 || most < 10);
            for (int a = 0; a < 3; a++)
                assert_in_range(slots[a], 1, limit[a]);
        }
    int slots[3];
    assert_false(vr_atlas_arrange(5, 0, limit, slots));
    assert_true(vr_atlas_arrange(1000000, 2000000, limit, slots));
    assert_int_equal(slots[0] * slots[1] * slots[2], 56 * 56 * 56);
}

static void test_arrange_powers(void **state)
{
    (void)state;
    static const int slot[3] = {36, 20, 68}, limit[3] = {2048, 2048, 30};
    int size[2], slots[3];
    for (uint64_t want = 1; want < 3000; want += 37)
        for (uint64_t most = 3; most < 4000; most += 173) {
            const uint64_t texels = most * 36 * 20 * 68;
            assert_true(vr_atlas_arrange_powers(want, texels, slot, limit, size, slots));
            const uint64_t n = (uint64_t)slots[0] * (uint64_t)slots[1] * (uint64_t)slots[2];
            assert_true((uint64_t)size[0] * (uint64_t)size[1] * (uint64_t)(slots[2] * slot[2]) <= texels);
            for (int a = 0; a < 2; a++)
                assert_true(slots[a] * slot[a] <= size[a] && size[a] <= 2048 && !(size[a] & (size[a] - 1)));
            assert_in_range(slots[2], 1, limit[2]);
            /* 7 x 51 of 256 x 1024 texels, times the depth, are within a twentieth of all. */
            assert_true(n >= want || n * 2 >= most || most < 8);
            assert_true(n >= want || n * 20 >= most * 17 || most < 1000);
        }
    assert_false(vr_atlas_arrange_powers(1, 64 * 32 * 68 - 1, slot, limit, size, slots));
    assert_true(vr_atlas_arrange_powers(1, 64 * 32 * 68, slot, limit, size, slots));
    assert_false(vr_atlas_arrange_powers(1, UINT64_C(1) << 40, slot, (int[]){32, 64, 4}, size, slots));
}

static struct vr_renderer *renderer_with(const struct brick_volume *volume, uint64_t bytes)
{
    struct vr_renderer_params params = vr_renderer_defaults;
    params.gpu_cache_bytes = bytes;
    params.threads = 3;
    return renderer_of(volume, &params);
}

static void test_upkeep(void **state)
{
    (void)state;
    struct memory_source source;
    struct brick_error err = {0};
    struct vr_report report;
    struct brick_image first = {0}, second = {0}, image = {0};
    struct vr_scene scene = vr_scene_defaults;
    fill();
    memory_source_init(&source, BRICK_U8, N, N, N, voxels);
    struct brick_volume *volume = volume_of(&source, 16);
    struct brick_transfer *a = transfer_of(low, 3), *b = transfer_of(high, 2);
    struct vr_renderer *large = renderer_with(volume, UINT64_C(64) << 20), *small = NULL;
    uint64_t loaded[2], active[2];
    if (!large)
        goto none;
    scene.width = scene.height = 40;
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 20, 30, 0, 0, 1);

    scene.transfer = a;
    render(large, &scene, &vr_quality_defaults, &first, &report);
    loaded[0] = report.bricks_loaded, active[0] = report.bricks_active;
    assert_true(loaded[0] > 0 && loaded[0] <= active[0]);
    assert_int_equal(report.bricks_read, loaded[0]);
    assert_int_equal(report.bricks_total, 125);
    assert_true(report.bytes_read > 0 && report.samples > 0);
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 200, -30, 0, 0, 1);
    render(large, &scene, &vr_quality_defaults, &image, &report);
    assert_true(loaded[0] + report.bricks_loaded <= active[0]); /* what is there stays */
    brick_image_finish(&image);
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 20, 30, 0, 0, 1);
    render(large, &scene, &vr_quality_defaults, &image, &report);
    assert_int_equal(report.bricks_loaded, 0);
    assert_int_equal(report.passes, 1);
    brick_image_finish(&image);
    scene.transfer = b;
    render(large, &scene, &vr_quality_defaults, &second, &report);
    loaded[1] = report.bricks_loaded, active[1] = report.bricks_active;
    assert_true(loaded[1] < active[1]); /* some were there */

    /* Room for the larger set only: the two take each other's slots, and the pictures stay the same. */
    uint64_t most = active[0] > active[1] ? active[0] : active[1];
    assert_true(most < 125);
    small = renderer_with(volume, (most + 4) * 20 * 20 * 20);
    for (int turn = 0; turn < 6; turn++) {
        scene.transfer = turn % 2 ? b : a;
        render(small, &scene, &vr_quality_defaults, &image, &report);
        assert_same_image(&image, turn % 2 ? &second : &first, "bricks that changed slots");
        assert_true(report.gpu_cache_peak_bytes <= report.gpu_cache_bytes);
        assert_true(report.gpu_cache_bytes <= (most + 4) * 20 * 20 * 20);
        brick_image_finish(&image);
    }
    vr_renderer_destroy(&small);

    struct vr_renderer *nothing = NULL;
    struct vr_renderer_params params = vr_renderer_defaults;
    params.gpu_cache_bytes = 100;
    assert_int_equal(vr_renderer_create(&nothing, volume, &params, &err), BRICK_ERR_MEMORY);
    assert_null(nothing);
none:
    vr_renderer_destroy(&small);
    brick_image_finish(&first);
    brick_image_finish(&second);
    brick_transfer_destroy(&a);
    end_or_skip(&large, &b, &volume);
}

/* Scenes that make no sense are refused, and the renderer goes on working. */
static void test_bad_scenes(void **state)
{
    (void)state;
    struct memory_source source;
    struct brick_error err = {0};
    struct brick_image image = {0};
    struct vr_scene scene = vr_scene_defaults;
    struct vr_quality quality = vr_quality_defaults;
    fill();
    memory_source_init(&source, BRICK_U8, N, N, N, voxels);
    struct brick_volume *volume = volume_of(&source, 32);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    struct brick_transfer *transfer = transfer_of(low, 3);
    if (!renderer) {
        brick_transfer_destroy(&transfer);
        brick_volume_close(&volume);
        skip();
    }
    assert_int_equal(brick_image_init(&image, 16, 16, &err), 0);
    scene.width = scene.height = 16;
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 0, 0, 0, 0, 1);
    assert_int_equal(vr_render(renderer, &scene, &quality, &image, NULL, &err), BRICK_ERR_ARGUMENT);
    scene.transfer = transfer;
    scene.level = 40;
    assert_int_equal(vr_render(renderer, &scene, &quality, &image, NULL, &err), BRICK_ERR_ARGUMENT);
    scene.level = 0;
    quality.step_vox = 0.0;
    assert_int_equal(vr_render(renderer, &scene, &quality, &image, NULL, &err), BRICK_ERR_ARGUMENT);
    quality.step_vox = 1e-12;
    assert_int_equal(vr_render(renderer, &scene, &quality, &image, NULL, &err), BRICK_ERR_ARGUMENT);
    quality.step_vox = 1.0;
    scene.width = 17;
    assert_int_equal(vr_render(renderer, &scene, &quality, &image, NULL, &err), BRICK_ERR_ARGUMENT);
    scene.width = 16;
    for (scene.level = 0; scene.level < brick_volume_grid(volume)->levels; scene.level++)
        if (vr_render(renderer, &scene, &quality, &image, NULL, &err))
            fail_msg("%s", err.message);
    brick_image_finish(&image);
    vr_renderer_destroy(&renderer);
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arrange),
        cmocka_unit_test(test_arrange_powers),
        cmocka_unit_test(test_upkeep),
        cmocka_unit_test(test_bad_scenes),
    };
    return cmocka_run_group_tests_name("residency", tests, NULL, NULL);
}
