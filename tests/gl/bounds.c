/* Rays that begin and end at the bounding geometry give the bytes of rays that cross the whole box: from many
 * sides, along walls of blocks at grazing angles, in both projections, from inside, with pixels larger than
 * blocks and smaller; before bricks are there, where geometry is bricks, and after, where it is macrocells;
 * and fewer samples are taken. */
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

#define N      96
#define VIEWS  40 /* and 6 along axes */
#define WIDTH  150
#define HEIGHT 110

#define SEEN 30001.0
static const struct brick_transfer_point points[] = {
    {SEEN, 0.9, 0.3, 0.1, 0.0}, {SEEN, 0.9, 0.3, 0.1, 0.2}, {60000, 1, 1, 0.9, 0.5}};
/* No voxel has these values; between two samples, one of them in a block where nothing shows, the field may.
 */
static const struct brick_transfer_point peak[] = {
    {7000, 0.2, 0.3, 0.9, 0.0}, {8000, 0.9, 0.3, 0.1, 0.9}, {9000, 1, 1, 0.9, 0.0}};

static const struct kind {
    enum brick_mode mode;
    enum vr_classification classification;
} kinds[] = {{BRICK_MODE_DVR, VR_CLASSIFY_POST},
             {BRICK_MODE_ISO, VR_CLASSIFY_POST},
             {BRICK_MODE_DVR, VR_CLASSIFY_PREINTEGRATED},
             {BRICK_MODE_SHADED, VR_CLASSIFY_PREINTEGRATED}};

/* A wall, and cubes that fill their block up to 1/30000 of a voxel before its three high faces: the block
 * behind is not active. */
static uint16_t value(int x, int y, int z)
{
    const int at[3] = {x % 32, y % 32, z % 32};
    bool core = true, skin = true;
    if (z >= 40 && z < 48)
        return 60000;
    for (int a = 0; a < 3; a++) {
        core = core && at[a] >= 9 && at[a] < 16;
        skin = skin && at[a] >= 9 && at[a] < 17;
    }
    return z >= 32 ? 0 : core ? 60000 : skin ? 30000 : 0;
}

/* Parallel to faces of blocks, a pixel a voxel, rays a ten thousandth of a voxel inside of them: less than
 * the rasteriser can tell. */
static void camera_along(int direction, struct brick_camera *camera)
{
    const int axis = direction / 2;
    *camera = (struct brick_camera){.ortho_height_mm = HEIGHT};
    for (int a = 0; a < 3; a++)
        camera->look_mm[a] = camera->eye_mm[a] = 0.5 * (N - 1) - 1e-4;
    camera->eye_mm[axis] += direction % 2 ? 200.0 : -200.0;
    camera->up[axis == 2 ? 1 : 2] = 1.0;
}

static void camera_of(int view, const struct brick_grid *grid, struct brick_camera *camera)
{
    static const double flat[] = {0.0, 1e-4, 0.01, 0.1, 0.5, 2.0, -1e-3, -0.3};
    const double middle = 0.5 * (N - 1);
    double elevation = view % 2 ? flat[view / 2 % 8] : 7.3 * view - 80.0;
    brick_camera_orbit(camera, grid, 37.0 * view, elevation, 30.0, view % 3 ? 0.0 : 0.9 * N,
                       (double)WIDTH / HEIGHT);
    if (view % 5 == 4) { /* near or inside, in the wall or beside it */
        for (int a = 0; a < 3; a++)
            camera->eye_mm[a] += 0.9 * (middle - camera->eye_mm[a]);
        camera->eye_mm[2] = view % 2 ? 44.0 : 48.02;
        camera->fov_deg = 100.0;
    }
}

static void check_view(struct vr_renderer *renderer, const struct vr_scene *scene,
                       enum vr_classification classification, bool skip, int view, uint64_t samples[2])
{
    struct vr_quality quality = vr_quality_defaults;
    struct brick_image image[2];
    struct vr_report report;
    char line[80];
    quality.skip = skip;
    quality.classification = classification;
    quality.step_vox = classification == VR_CLASSIFY_PREINTEGRATED && view % 2 ? 1.0 : 0.5;
    for (int setup = 1; setup >= 0; setup--) { /* the first picture has no bricks yet */
        quality.setup = setup ? VR_SETUP_GEOMETRY : VR_SETUP_BOX;
        quality.method = view % 4 == 3 ? VR_METHOD_MULTIPASS : VR_METHOD_RAYCAST;
        render(renderer, scene, &quality, &image[setup], &report);
        samples[setup] += report.samples;
    }
    snprintf(line, sizeof line, "mode %d, classification %d, view %d, skipping %d", (int)scene->mode,
             (int)classification, view, skip);
    assert_same_image(&image[1], &image[0], line);
    brick_image_finish(&image[0]);
    brick_image_finish(&image[1]);
}

static void check(uint32_t edge)
{
    static uint16_t voxels[N * N * N];
    struct memory_source source;
    uint64_t samples[2] = {0};
    bool none = false;
    for (int i = 0; i < N * N * N; i++)
        voxels[i] = value(i % N, i / N % N, i / N / N);
    memory_source_init(&source, BRICK_U16, N, N, N, voxels);
    struct brick_volume *volume = volume_of(&source, edge);
    struct brick_transfer *transfers[2] = {transfer_of(points, sizeof points / sizeof points[0]),
                                           transfer_of(peak, sizeof peak / sizeof peak[0])};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds && !none; k++) {
        struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
        none = !renderer;
        for (int view = 0; renderer && view < VIEWS + 6; view++) {
            struct vr_scene scene = vr_scene_defaults;
            scene.mode = kinds[k].mode;
            scene.transfer = transfers[kinds[k].classification == VR_CLASSIFY_PREINTEGRATED];
            scene.isovalue = SEEN;
            scene.width = WIDTH;
            scene.height = HEIGHT;
            if (view < VIEWS)
                camera_of(view, brick_volume_grid(volume), &scene.camera);
            else
                camera_along(view - VIEWS, &scene.camera);
            check_view(renderer, &scene, kinds[k].classification, view % 7 != 0, view, samples);
        }
        vr_renderer_destroy(&renderer);
    }
    for (int i = 0; i < 2; i++)
        brick_transfer_destroy(&transfers[i]);
    brick_volume_close(&volume);
    if (none)
        skip();
    assert_true(samples[1] < samples[0]);
}

static void test_bricks_16(void **state)
{
    (void)state;
    check(16);
}

static void test_bricks_64(void **state)
{
    (void)state;
    check(64);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bricks_16), cmocka_unit_test(test_bricks_64)};
    return cmocka_run_group_tests_name("bounds", tests, NULL, NULL);
}
