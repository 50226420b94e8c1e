/* Beyond video memory: the picture is the same bytes for every cache that holds a brick, in every mode, by
 * both methods that march rays, whatever the length of their passes and the rays' set-up; each brick is read
 * once while the host cache holds it; what an opaque wall hides is not read; and a damaged brick is an error
 * that leaves the renderer whole. */
#include <fcntl.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "gl_scene.h"

#define NX   70
#define NY   61
#define NZ   83
#define EDGE 40 /* of pictures */

static int16_t voxels[NX * NY * NZ];
static const struct brick_transfer_point points[] = {
    {150, 0.2, 0.1, 0.1, 0.0}, {300, 0.9, 0.3, 0.1, 0.1}, {300, 0.1, 0.9, 0.1, 0.02}, {900, 1, 1, 0.9, 0.7}};
/* Peaks between transparent values, narrower than what a voxel's way changes. */
static const struct brick_transfer_point peaks[] = {
    {205, 1, 0, 0, 0.0},   {211, 0.9, 0.3, 0.1, 0.6}, {214, 0, 0, 1, 0.0}, {500.5, 0, 1, 0, 0.0},
    {500.5, 0, 1, 0, 0.8}, {503, 1, 1, 0, 0.2},       {503, 1, 1, 0, 0.0}};

static void fill_blobs(void)
{
    for (int i = 0; i < NX * NY * NZ; i++) {
        double v =
            1100.0 * sin(0.11 * (i % NX) + 0.3) * sin(0.13 * (i / NX % NY)) * cos(0.09 * (i / NX / NY)) -
            150.0;
        voxels[i] = (int16_t)(v < 0.0 ? 0.0 : v + (double)(noise64(3, (uint64_t)i) % 40));
    }
}

/* From face to face of bricks of 16, nothing in those beside them. */
static void fill_boxes(void)
{
    for (int i = 0; i < NX * NY * NZ; i++) {
        const int at[3] = {i % NX, i / NX % NY, i / NX / NY};
        bool inside = true;
        for (int a = 0; a < 3; a++)
            inside = inside && at[a] / 16 % 2 == 0 && at[a] % 16 != 0;
        voxels[i] = inside ? (int16_t)(900 + noise64(11, (uint64_t)i) % 100) : 0;
    }
}

struct caches {
    uint64_t gpu_bricks, host_bricks; /* 0: all */
    unsigned threads;
};

static struct vr_renderer *renderer_with(const struct brick_volume *volume, const struct caches *caches)
{
    struct vr_renderer_params params = vr_renderer_defaults;
    if (caches->gpu_bricks)
        params.gpu_cache_bytes = slots_bytes(volume, caches->gpu_bricks);
    if (caches->host_bricks)
        params.host_cache_bytes =
            caches->host_bricks * brick_grid_max_payload_bytes(brick_volume_grid(volume));
    params.threads = caches->threads;
    return renderer_of(volume, &params);
}

static void camera_of(int view, const struct brick_grid *grid, struct brick_camera *camera)
{
    brick_camera_orbit(camera, grid, 35, 25, 0, 0, 1.0);
    if (view == 1) { /* parallel, in the faces of bricks */
        brick_camera_orbit(camera, grid, 90, 0, 0, EDGE, 1.0);
        for (int a = 0; a < 3; a++) {
            camera->look_mm[a] = 32.0;
            camera->eye_mm[a] = a == 0 ? 232.0 : 32.0;
        }
    } else if (view == 2) { /* inside */
        for (int a = 0; a < 3; a++) {
            camera->eye_mm[a] = 33.0;
            camera->look_mm[a] = a == 1 ? 0.0 : 30.0;
        }
        camera->fov_deg = 110.0;
    }
}

static struct vr_scene scene_of(int mode, int view, uint32_t level, const struct brick_transfer *transfer,
                                const struct brick_grid *grid)
{
    struct vr_scene scene = vr_scene_defaults;
    scene.mode = (enum brick_mode)mode;
    scene.transfer = transfer;
    scene.isovalue = 300.0;
    scene.width = scene.height = EDGE;
    scene.level = level;
    camera_of(view, grid, &scene.camera);
    return scene;
}

#define VIEWS  3
#define LEVELS 2

static void check_edge(uint32_t edge, void (*fill)(void))
{
    static const struct caches caches[] = {{0, 0, 0}, {1, 0, 1}, {2, 1, 2}, {3, 40, 1},
                                           {8, 9, 2}, {8, 1, 1}, {20, 0, 2}};
    static const uint32_t pass_steps[] = {0, 5,  0, VR_MAX_PASS_STEPS,
                                          0, 17, 0}; /* where there is multipass */
    struct memory_source source;
    struct brick_image images[WAYS][VIEWS][LEVELS] = {{{{0}}}};
    bool none = false;
    fill();
    memory_source_init(&source, BRICK_I16, NX, NY, NZ, voxels);
    struct brick_volume *volume = volume_of(&source, edge);
    const struct brick_grid *grid = brick_volume_grid(volume);
    struct brick_transfer *transfer = transfer_of(points, sizeof points / sizeof points[0]);
    struct brick_transfer *peaked = transfer_of(peaks, sizeof peaks / sizeof peaks[0]);
    for (size_t c = 0; c < sizeof caches / sizeof caches[0] && !none; c++) {
        struct vr_renderer *renderer = renderer_with(volume, &caches[c]);
        none = !renderer;
        for (int run = 0; renderer && run < WAYS * VIEWS * LEVELS * 4; run++) {
            int way = run % WAYS, view = run / WAYS % VIEWS, level = run / WAYS / VIEWS % LEVELS;
            int hand =
                run / WAYS / VIEWS / LEVELS; /* raycast, without skipping, multipass, bounding geometry */
            if (hand >= 2 && (c % 2 == 0 || level > 0))
                continue;
            struct vr_scene scene = scene_of(0, view, (uint32_t)level, way < 4 ? transfer : peaked, grid);
            struct vr_quality quality = vr_quality_defaults;
            struct brick_image image;
            struct vr_report report;
            char line[160];
            set_way(way, &scene, &quality);
            quality.skip = hand != 1;
            quality.method = hand == 2 ? VR_METHOD_MULTIPASS : VR_METHOD_RAYCAST;
            quality.setup = hand == 3 ? VR_SETUP_GEOMETRY : VR_SETUP_BOX;
            quality.pass_steps = pass_steps[c];
            quality.cubic = view == 1;
            quality.interleaved = view == 2;
            quality.step_vox = view != 1 ? 0.5 : way < 4 ? 2.7 : 1.0;
            render(renderer, &scene, &quality, &image, &report);
            snprintf(line, sizeof line,
                     "bricks of %u, %llu and %llu of them, way %d, view %d, level %d, hand %d", edge,
                     (unsigned long long)caches[c].gpu_bricks, (unsigned long long)caches[c].host_bricks, way,
                     view, level, hand);
            if (report.gpu_cache_peak_bytes > report.gpu_cache_bytes)
                fail_msg("%s: the cache is larger than its limit", line);
            if (caches[c].host_bricks &&
                report.host_cache_peak_bytes > caches[c].host_bricks * brick_grid_max_payload_bytes(grid))
                fail_msg("%s: the host cache is larger than its limit", line);
            /* Light may need a brick in which nothing is visible. */
            bool more =
                scene.mode == BRICK_MODE_SHADED && quality.classification == VR_CLASSIFY_PREINTEGRATED;
            if (!caches[c].host_bricks && report.bricks_read > report.bricks_active && !more)
                fail_msg("%s: bricks read twice", line);
            if (level == 0 && caches[c].gpu_bricks == 1 && fill == fill_blobs)
                assert_true(report.passes > 2 && report.bricks_loaded >= 2);
            struct brick_image *first = &images[way][view][level];
            if (!first->rgba) {
                *first = image;
                continue;
            }
            assert_same_image(&image, first, line);
            brick_image_finish(&image);
        }
        vr_renderer_destroy(&renderer);
    }
    for (int i = 0; i < WAYS * VIEWS * LEVELS; i++)
        brick_image_finish(&images[i % WAYS][i / WAYS % VIEWS][i / WAYS / VIEWS]);
    brick_transfer_destroy(&transfer);
    brick_transfer_destroy(&peaked);
    brick_volume_close(&volume);
    if (none)
        skip();
}

static void test_invariance_16(void **state)
{
    (void)state;
    check_edge(16, fill_blobs);
}

static void test_boxes(void **state)
{
    (void)state;
    check_edge(16, fill_boxes);
}

static void test_invariance_32(void **state)
{
    (void)state;
    check_edge(32, fill_blobs);
}

/* 4 x 4 x 10 bricks, all active, behind an opaque wall: the wall and what is one brick behind it. */
static void test_hidden(void **state)
{
    (void)state;
    enum { X = 64, Z = 160, FRONT = 16 };
    static uint8_t wall[X * X * Z];
    static const struct brick_transfer_point solid[] = {
        {50, 1, 1, 1, 0.0}, {100, 1, 1, 1, 0.1}, {200, 1, 0, 0, 1.0}};
    static const struct caches caches[] = {{0, 0, 2}, {160, 0, 1}, {40, 0, 2}, {8, 0, 1}};
    struct memory_source source;
    struct brick_transfer *transfer = transfer_of(solid, 3);
    bool none = false;
    for (int i = 0; i < X * X * Z; i++)
        wall[i] = i / X / X < 12 ? 220 : (uint8_t)(80 + noise64(1, (uint64_t)i) % 30);
    memory_source_init(&source, BRICK_U8, X, X, Z, wall);
    struct brick_volume *volume = volume_of(&source, 16);
    for (size_t c = 0; c < sizeof caches / sizeof caches[0] && !none; c++) {
        struct vr_renderer *renderer = renderer_with(volume, &caches[c]);
        struct vr_scene scene = vr_scene_defaults;
        struct brick_image image;
        struct vr_report report;
        if ((none = !renderer))
            break;
        scene.transfer = transfer;
        scene.width = scene.height = EDGE;
        scene.camera = (struct brick_camera){
            .eye_mm = {31, 33, -500}, .look_mm = {31, 33, 0}, .up = {0, 1, 0}, .fov_deg = 12};
        render(renderer, &scene, &vr_quality_defaults, &image, &report);
        assert_int_equal(report.bricks_active, 160);
        assert_in_range(report.bricks_read, FRONT, 2 * FRONT);
        assert_true(image.rgba[4 * (EDGE / 2 * EDGE + EDGE / 2) + 3] > 0.999f);
        brick_image_finish(&image);
        /* From behind everything is seen. */
        scene.camera.eye_mm[2] = 500;
        scene.camera.look_mm[2] = 100;
        render(renderer, &scene, &vr_quality_defaults, &image, &report);
        brick_image_finish(&image);
        vr_renderer_destroy(&renderer);
    }
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
    if (none)
        skip();
}

static void flip(const char *path, uint64_t offset)
{
    unsigned char byte;
    int file = open(path, O_RDWR);
    assert_true(file >= 0 && pread(file, &byte, 1, (off_t)offset) == 1);
    byte ^= 16;
    assert_true(pwrite(file, &byte, 1, (off_t)offset) == 1);
    close(file);
}

static void test_damage(void **state)
{
    (void)state;
    static const struct caches caches = {8, 8, 2};
    struct memory_source source;
    struct brick_error err = {0};
    struct brick_image good = {0}, image = {0};
    struct vr_report report;
    char name[40];
    fill_blobs();
    memory_source_init(&source, BRICK_I16, NX, NY, NZ, voxels);
    struct brick_volume *volume = volume_of(&source, 16);
    struct brick_transfer *transfer = transfer_of(points, sizeof points / sizeof points[0]);
    struct vr_renderer *renderer = renderer_with(volume, &caches);
    if (renderer) {
        struct vr_scene scene = scene_of(BRICK_MODE_MIP, 0, 0, transfer, brick_volume_grid(volume));
        render(renderer, &scene, &vr_quality_defaults, &good, &report);
        assert_int_equal(brick_image_init(&image, EDGE, EDGE, &err), 0);
        /* The caches hold few: every brick is read again for the next picture. */
        uint64_t damaged = 0;
        double most = -1.0;
        for (uint64_t b = 0; b < report.bricks_total; b++)
            if ((double)brick_volume_entry(volume, b)->max > most)
                most = (double)brick_volume_entry(volume, damaged = b)->max;
        const struct brick_entry *entry = brick_volume_entry(volume, damaged);
        flip(brick_volume_path(volume), entry->offset + entry->bytes / 2);
        vr_renderer_destroy(&renderer);
        renderer = renderer_with(volume, &caches);
        for (int turn = 0; turn < 2; turn++) {
            assert_int_equal(vr_render(renderer, &scene, &vr_quality_defaults, &image, &report, &err),
                             BRICK_ERR_CHECKSUM);
            assert_true(err.brick == damaged);
            snprintf(name, sizeof name, "brick %llu", (unsigned long long)damaged);
            assert_non_null(strstr(err.message, name));
        }
        flip(brick_volume_path(volume), entry->offset + entry->bytes / 2);
        if (vr_render(renderer, &scene, &vr_quality_defaults, &image, &report, &err))
            fail_msg("%s", err.message);
        assert_same_image(&image, &good, "after a damaged brick was mended");
    }
    brick_image_finish(&good);
    brick_image_finish(&image);
    end_or_skip(&renderer, &transfer, &volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_invariance_16), cmocka_unit_test(test_invariance_32),
        cmocka_unit_test(test_boxes),         cmocka_unit_test(test_hidden),
        cmocka_unit_test(test_damage),
    };
    return cmocka_run_group_tests_name("paging", tests, NULL, NULL);
}
