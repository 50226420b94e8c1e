/* Pictures of the raycaster against a slow one in double precision that knows the definitions only: voxels in
 * one array, no bricks, no skipping, no fixed point. */
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

struct reference {
    int64_t dims[3];
    const float *voxels; /* stored values */
    const struct brick_grid *grid;
    const struct vr_scene *scene;
    const struct vr_quality *quality;
};

static double field(const struct reference *r, const double p[3])
{
    int64_t at[3][2];
    double t[3], v = 0.0;
    for (int a = 0; a < 3; a++) {
        t[a] = p[a] - floor(p[a]);
        for (int i = 0; i < 2; i++) {
            int64_t c = (int64_t)floor(p[a]) + i;
            at[a][i] = c < 0 ? 0 : c >= r->dims[a] ? r->dims[a] - 1 : c;
        }
    }
    for (int i = 0; i < 8; i++)
        v += (i & 1 ? t[0] : 1 - t[0]) * (i & 2 ? t[1] : 1 - t[1]) * (i & 4 ? t[2] : 1 - t[2]) *
             (double)r->voxels[(at[2][i >> 2] * r->dims[1] + at[1][i >> 1 & 1]) * r->dims[0] + at[0][i & 1]];
    return r->grid->slope * v + r->grid->intercept;
}

static void shade(const struct reference *r, const double p[3], const struct brick_ray *ray, double rgb[3])
{
    double g[3], n[3] = {0, 0, 0}, view[3] = {0, 0, 0}, inverse[3][4], nn = 0, vv = 0, nv = 0;
    for (int a = 0; a < 3; a++) {
        double plus[3] = {p[0], p[1], p[2]}, minus[3] = {p[0], p[1], p[2]};
        plus[a] += 1.0, minus[a] -= 1.0;
        g[a] = 0.5 * (field(r, plus) - field(r, minus));
    }
    brick_affine_invert(r->grid->affine, inverse);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            n[i] += inverse[j][i] * g[j];
            view[i] += r->grid->affine[i][j] * ray->direction[j];
        }
    for (int i = 0; i < 3; i++)
        nn += n[i] * n[i], vv += view[i] * view[i], nv += n[i] * view[i];
    double facing = nn > 0.0 ? fabs(nv) / sqrt(nn * vv) : 0.0;
    double highlight = nn > 0.0 ? r->scene->specular * pow(facing, r->scene->shininess) : 0.0;
    for (int i = 0; i < 3; i++)
        rgb[i] = rgb[i] * (r->scene->ambient + r->scene->diffuse * facing) + highlight;
}

static void position(const struct brick_ray *ray, double t, double p[3])
{
    for (int i = 0; i < 3; i++)
        p[i] = ray->origin[i] + t * ray->direction[i];
}

/* The first pair of samples on different sides, bisected down to nothing. */
static bool find_surface(const struct reference *r, const struct brick_ray *ray, double near, double far,
                         double p[3])
{
    bool above;
    position(ray, near, p);
    above = field(r, p) >= r->scene->isovalue;
    position(ray, far, p);
    if ((field(r, p) >= r->scene->isovalue) == above)
        return false;
    for (int i = 0; i < 60; i++) {
        double middle = 0.5 * (near + far);
        position(ray, middle, p);
        *((field(r, p) >= r->scene->isovalue) == above ? &near : &far) = middle;
    }
    return true;
}

static void reference_pixel(const struct reference *r, uint32_t column, uint32_t row, double out[4])
{
    const struct vr_scene *scene = r->scene;
    double step = r->quality->step_vox * brick_grid_min_spacing_mm(r->grid);
    double enter, leave, depth = 0.0, largest = -INFINITY, p[3], rgb[3], sigma;
    struct brick_view view;
    struct brick_ray ray;
    memset(out, 0, 4 * sizeof *out);
    assert_int_equal(brick_view_init(&view, &scene->camera, r->grid, scene->width, scene->height, NULL), 0);
    brick_view_ray(&view, column, row, &ray);
    if (!brick_ray_span(&ray, r->grid, &enter, &leave))
        return;
    for (uint64_t k = 0; enter + (double)k * step < leave; k++) {
        double a = enter + (double)k * step, b = fmin(a + step, leave), t = 0.5 * (a + b);
        if (scene->mode == BRICK_MODE_ISO) {
            if (find_surface(r, &ray, a, b, p)) {
                brick_transfer_eval(scene->transfer, scene->isovalue, out, &sigma);
                shade(r, p, &ray, out);
                out[3] = 1.0;
                return;
            }
            continue;
        }
        position(&ray, t, p);
        double v = field(r, p), x;
        largest = fmax(largest, v);
        if (scene->mode == BRICK_MODE_MIP)
            continue;
        brick_transfer_eval(scene->transfer, v, rgb, &sigma);
        if (scene->mode == BRICK_MODE_SHADED)
            shade(r, p, &ray, rgb);
        x = sigma * (b - a);
        for (int i = 0; i < 3; i++)
            out[i] += exp(-depth) * -expm1(-x) * rgb[i];
        depth += x;
    }
    if (scene->mode == BRICK_MODE_MIP) {
        brick_transfer_eval(scene->transfer, largest, rgb, &sigma);
        depth = sigma * scene->transfer->unit_mm;
        for (int i = 0; i < 3; i++)
            out[i] = -expm1(-depth) * rgb[i];
    }
    out[3] = scene->mode == BRICK_MODE_ISO ? 0.0 : -expm1(-depth);
}

/* Largest difference of any channel; *outliers counts pixels off by more than `limit`. */
static double compare(const struct reference *r, const struct brick_image *image, double limit, int *outliers)
{
    double worst = 0.0, sum = 0.0;
    *outliers = 0;
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            double want[4], pixel = 0.0;
            reference_pixel(r, x, y, want);
            for (int c = 0; c < 4; c++)
                pixel = fmax(pixel,
                             fabs(want[c] - (double)image->rgba[4 * (y * image->width + x) + (uint32_t)c]));
            worst = fmax(worst, pixel);
            *outliers += pixel > limit;
            sum += want[3];
        }
    assert_true(sum > 0.0);
    return worst;
}

#define NX   37
#define NY   30
#define NZ   41
#define EDGE 48

static const struct brick_transfer_point smooth_points[] = {
    {-1200, 0.2, 0.9, 0.1, 0.05}, {-300, 0.5, 0.1, 1.0, 0.0}, {100, 1, 1, 1, 0.0}, {900, 0.9, 0.5, 0.1, 0.8}};

/* All modes of one smooth volume on oblique axes. limit: float32 rounding; pixels that graze a surface may be
 * decided the other way. */
static void check_modes(enum vr_context_kind kind, enum brick_type type, double slope, double intercept)
{
    static int16_t voxels[NX * NY * NZ];
    static int8_t small[NX * NY * NZ];
    static float values[NX * NY * NZ];
    static const double affine[3][4] = {{0.9, 0.1, 0.0, 5}, {-0.1, 0.8, 0.05, -3}, {0.0, 0.1, -1.4, 100}};
    /* dvr, shaded: sums of rounded terms. iso: the hit is within 2^-20 of a step, where the gradient changes
     * as little. mip: one value. */
    static const double limits[4] = {2e-6, 1e-5, 2e-5, 2e-6};
    struct memory_source source;
    for (int i = 0; i < NX * NY * NZ; i++) {
        int x = i % NX, y = i / NX % NY, z = i / NX / NY;
        voxels[i] = (int16_t)(1000 * sin(0.3 * x) * cos(0.21 * y + 0.4) * sin(0.17 * z + 1.0));
        small[i] = (int8_t)(voxels[i] / 8);
        values[i] = type == BRICK_I8 ? (float)small[i] : (float)voxels[i];
    }
    memory_source_init(&source, type, NX, NY, NZ, type == BRICK_I8 ? (void *)small : (void *)voxels);
    source.base.geometry.slope = slope;
    source.base.geometry.intercept = intercept;
    memcpy(source.base.geometry.affine, affine, sizeof affine);
    struct brick_volume *volume = volume_of(&source, 16);
    struct vr_renderer *renderer = try_renderer(volume, kind);
    struct brick_transfer *transfer = transfer_of(smooth_points, 4);
    struct vr_scene scene = vr_scene_defaults;
    struct vr_quality quality = vr_quality_defaults;
    if (renderer) {
        scene.width = scene.height = EDGE;
        scene.transfer = transfer;
        scene.isovalue = 250.5;
        quality.termination = 0.0;
        quality.step_vox = 0.7;
        quality.refinements = 20;
        brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 30, 20, 0, 0, 1.0);
    }
    /* The last is wider than the target that pictures are drawn through. */
    for (int run = 0; renderer && run < 5; run++) {
        int mode = run % 4;
        if (run == 4) {
            scene.width = 1030, scene.height = 2;
            scene.camera.ortho_height_mm = 0.1;
        }
        const struct reference r = {{NX, NY, NZ}, values, brick_volume_grid(volume), &scene, &quality};
        struct brick_image image;
        int outliers;
        if (kind == VR_CONTEXT_CPU && mode == BRICK_MODE_ISO)
            continue;
        scene.mode = (enum brick_mode)mode;
        render(renderer, &scene, &quality, &image, NULL);
        double worst = compare(&r, &image, limits[mode], &outliers);
        print_message("slope %g, mode %d: worst %.2e, %d pixels above %.0e\n", slope, mode, worst, outliers,
                      limits[mode]);
        brick_image_finish(&image);
        assert_true(outliers <= (mode == BRICK_MODE_ISO ? 2 : 0));
    }
    end_or_skip(&renderer, &transfer, &volume);
}

static void test_modes(void **state)
{
    (void)state;
    check_modes(VR_CONTEXT_AUTO, BRICK_I16, 1.0, 0.0);
    check_modes(VR_CONTEXT_AUTO, BRICK_I8, 8.0, 0.0);
}

static void test_modes_negative_slope(void **state)
{
    (void)state;
    check_modes(VR_CONTEXT_AUTO, BRICK_I16, -0.7, 12.3);
}

static void test_modes_without_opengl(void **state)
{
    (void)state;
    check_modes(VR_CONTEXT_CPU, BRICK_I16, 1.0, 0.0);
    check_modes(VR_CONTEXT_CPU, BRICK_I8, 8.0, 0.0);
    check_modes(VR_CONTEXT_CPU, BRICK_I16, -0.7, 12.3);
}

/* Rays of 140,000 samples through noise: where a sample lies must still be right to 2^-16 voxel, and it
 * shows, since noise has steep slopes. */
static void test_thin(void **state)
{
    (void)state;
    enum { LENGTH = 70000 };
    static float voxels[LENGTH];
    static const struct brick_transfer_point points[] = {{0, 0, 0, 1, 0.0}, {1, 1, 0.5, 0, 2e-5}};
    struct memory_source source;
    for (int i = 0; i < LENGTH; i++)
        voxels[i] = (float)((double)(noise64(11, (uint64_t)i) >> 40) * 0x1p-24);
    memory_source_init(&source, BRICK_F32, 1, 1, LENGTH, voxels);
    struct brick_volume *volume = volume_of(&source, 32);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    struct brick_transfer *transfer = transfer_of(points, 2);
    if (renderer) {
        struct vr_scene scene = vr_scene_defaults;
        struct vr_quality quality = vr_quality_defaults;
        const struct reference r = {{1, 1, LENGTH}, voxels, brick_volume_grid(volume), &scene, &quality};
        struct brick_image image;
        struct vr_report report;
        int outliers;
        scene.width = scene.height = 4;
        scene.transfer = transfer;
        scene.camera = (struct brick_camera){.eye_mm = {0.02, -0.01, -10},
                                             .look_mm = {0.01, 0.0, LENGTH},
                                             .up = {0, 1, 0},
                                             .ortho_height_mm = 0.6};
        quality.termination = 0.0;
        quality.step_vox = 0.4999;
        render(renderer, &scene, &quality, &image, &report);
        assert_true(report.samples > 16 * 140000);
        assert_true(report.passes > 1);
        /* Noise of mean 1/2, slope up to 1 a voxel, wrong by 2^-16 voxel in every sample, would change the
         * depth of about 0.7 by 1e-5 at the worst; float32 sums of 140,000 terms are right to 1e-5 as well.
         */
        double worst = compare(&r, &image, 0.0, &outliers);
        print_message("thin: worst %.2e\n", worst);
        brick_image_finish(&image);
        /* Positions themselves, where a sum would hide them: the largest value, sampled sparsely. */
        scene.mode = BRICK_MODE_MIP;
        quality.step_vox = 1234.567;
        render(renderer, &scene, &quality, &image, &report);
        double position_error = compare(&r, &image, 0.0, &outliers) / 2e-5;
        print_message("thin: value at the largest sample off by %.2e\n", position_error);
        brick_image_finish(&image);
        vr_renderer_destroy(&renderer);
        brick_transfer_destroy(&transfer);
        brick_volume_close(&volume);
        assert_true(worst < 2e-5);
        assert_true(position_error < 0x1p-16);
        return;
    }
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
    skip();
}

/* A constant slab: alpha = 1 - exp(-sigma L), to float32's relative precision, from 1e-12 to 1e3 of depth a
 * step. */
static void test_extremes(void **state)
{
    (void)state;
    enum { N = 16 };
    static uint8_t voxels[N * N * N];
    struct memory_source source;
    memset(voxels, 7, sizeof voxels);
    memory_source_init(&source, BRICK_U8, N, N, N, voxels);
    source.base.geometry.affine[0][0] = source.base.geometry.affine[1][1] =
        source.base.geometry.affine[2][2] = 100.0;
    struct brick_volume *volume = volume_of(&source, 16);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    for (double unit = 1e14; renderer && unit > 0.05; unit /= 10) {
        struct brick_transfer *transfer = NULL;
        struct brick_transfer_point point = {7, 1, 0.5, 0.25, 0.999};
        const struct brick_transfer_spec spec = {&point, 1, unit, BRICK_UNIT_MM, false};
        struct vr_scene scene = vr_scene_defaults;
        struct vr_quality quality = vr_quality_defaults;
        struct brick_image image;
        assert_int_equal(brick_transfer_create(&transfer, &spec, 100.0, (const double[2]){0, 1}, NULL), 0);
        quality.step_vox = 1.0;
        quality.termination = 0.0;
        scene.width = scene.height = 2;
        scene.transfer = transfer;
        brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 0, 0, 0, 200, 1.0);
        render(renderer, &scene, &quality, &image, NULL);
        double want = -expm1(-transfer->knots[0].sigma * 100.0 * N);
        for (int i = 0; i < 4; i++)
            for (int c = 0; c < 4; c++) {
                static const double colour[4] = {1, 0.5, 0.25, 1};
                double got = (double)image.rgba[4 * i + c];
                if (!(fabs(got - want * colour[c]) <= 16 * 0x1p-24 * want * colour[c]))
                    fail_msg("unit %g mm: channel %d is %.9g, not %.9g", unit, c, got, want * colour[c]);
            }
        brick_image_finish(&image);
        brick_transfer_destroy(&transfer);
    }
    end_or_skip(&renderer, NULL, &volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_modes),
        cmocka_unit_test(test_modes_without_opengl),
        cmocka_unit_test(test_modes_negative_slope),
        cmocka_unit_test(test_thin),
        cmocka_unit_test(test_extremes),
    };
    return cmocka_run_group_tests_name("raycast_reference", tests, NULL, NULL);
}
