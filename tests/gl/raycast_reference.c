/* Pictures of the raycaster against a slow one in double precision that knows the definitions only: voxels in
 * one array, no bricks, no skipping. */
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

#define NX   37
#define NY   30
#define NZ   41
#define EDGE 48

static int16_t voxels[NX * NY * NZ];

static double voxel(int64_t x, int64_t y, int64_t z)
{
    x = x < 0 ? 0 : x >= NX ? NX - 1 : x;
    y = y < 0 ? 0 : y >= NY ? NY - 1 : y;
    z = z < 0 ? 0 : z >= NZ ? NZ - 1 : z;
    return voxels[(z * NY + y) * NX + x];
}

static double field(const double p[3])
{
    double c[3], t[3], v = 0.0;
    for (int a = 0; a < 3; a++) {
        c[a] = floor(p[a]);
        t[a] = p[a] - c[a];
    }
    for (int i = 0; i < 8; i++)
        v += (i & 1 ? t[0] : 1 - t[0]) * (i & 2 ? t[1] : 1 - t[1]) * (i & 4 ? t[2] : 1 - t[2]) *
             voxel((int64_t)c[0] + (i & 1), (int64_t)c[1] + (i >> 1 & 1), (int64_t)c[2] + (i >> 2));
    return v;
}

static void reference_dvr(const struct brick_grid *grid, const struct vr_scene *scene, double step_mm,
                          uint32_t column, uint32_t row, double out[4])
{
    struct brick_view view;
    struct brick_ray ray;
    double enter, leave, depth = 0.0;
    memset(out, 0, 4 * sizeof *out);
    assert_int_equal(brick_view_init(&view, &scene->camera, grid, scene->width, scene->height, NULL), 0);
    brick_view_ray(&view, column, row, &ray);
    if (!brick_ray_span(&ray, grid, &enter, &leave))
        return;
    for (uint64_t k = 0; enter + (double)k * step_mm < leave; k++) {
        double a = enter + (double)k * step_mm, b = fmin(a + step_mm, leave), t = 0.5 * (a + b), p[3], rgb[3],
               sigma;
        for (int i = 0; i < 3; i++)
            p[i] = ray.origin[i] + t * ray.direction[i];
        brick_transfer_eval(scene->transfer, grid->slope * field(p) + grid->intercept, rgb, &sigma);
        double x = sigma * (b - a);
        for (int i = 0; i < 3; i++)
            out[i] += exp(-depth) * -expm1(-x) * rgb[i];
        depth += x;
    }
    out[3] = -expm1(-depth);
}

static void fill(void)
{
    for (int z = 0; z < NZ; z++)
        for (int y = 0; y < NY; y++)
            for (int x = 0; x < NX; x++)
                voxels[(z * NY + y) * NX + x] =
                    (int16_t)(1000 * sin(0.3 * x) * cos(0.21 * y + 0.4) * sin(0.17 * z + 1.0));
}

static void check_dvr(double slope, double intercept)
{
    static const struct brick_transfer_point points[] = {{-1200, 0.2, 0.9, 0.1, 0.05},
                                                         {-300, 0.5, 0.1, 1.0, 0.0},
                                                         {100, 1, 1, 1, 0.0},
                                                         {900, 0.9, 0.5, 0.1, 0.8}};
    struct memory_source source;
    fill();
    memory_source_init(&source, BRICK_I16, NX, NY, NZ, voxels);
    source.base.geometry.slope = slope;
    source.base.geometry.intercept = intercept;
    const double affine[3][4] = {{0.9, 0.1, 0.0, 5}, {-0.1, 0.8, 0.05, -3}, {0.0, 0.1, -1.4, 100}};
    memcpy(source.base.geometry.affine, affine, sizeof affine);
    struct brick_volume *volume = volume_of(&source, 16);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    struct brick_transfer *transfer = transfer_of(points, 4);
    const struct brick_grid *grid = brick_volume_grid(volume);
    struct vr_scene scene = vr_scene_defaults;
    struct vr_quality quality = vr_quality_defaults;
    struct brick_image image = {0};
    double worst = 0.0;
    uint32_t worst_x = 0, worst_y = 0;
    if (!renderer) {
        brick_transfer_destroy(&transfer);
        brick_volume_close(&volume);
        skip();
    }
    scene.width = scene.height = EDGE;
    scene.transfer = transfer;
    quality.termination = 0.0;
    quality.step_vox = 0.7;
    brick_camera_orbit(&scene.camera, grid, 30, 20, 0, 0, 1.0);
    render(renderer, &scene, &quality, &image, NULL);
    for (uint32_t y = 0; y < EDGE; y++)
        for (uint32_t x = 0; x < EDGE; x++) {
            double want[4];
            reference_dvr(grid, &scene, quality.step_vox * brick_grid_min_spacing_mm(grid), x, y, want);
            for (int c = 0; c < 4; c++) {
                double d = fabs(want[c] - (double)image.rgba[4 * (y * EDGE + x) + (uint32_t)c]);
                if (d > worst)
                    worst = d, worst_x = x, worst_y = y;
            }
        }
    print_message("slope %g: worst difference %.2e at %u,%u\n", slope, worst, worst_x, worst_y);
    brick_image_finish(&image);
    vr_renderer_destroy(&renderer);
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
    assert_true(worst < 1e-5);
}

static void test_dvr(void **state)
{
    (void)state;
    check_dvr(1.0, 0.0);
}

static void test_dvr_negative_slope(void **state)
{
    (void)state;
    check_dvr(-0.7, 12.3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_dvr),
        cmocka_unit_test(test_dvr_negative_slope),
    };
    return cmocka_run_group_tests_name("raycast_reference", tests, NULL, NULL);
}
