/* Slices against the same sum written plainly in double precision: every pixel, every slice, no bricks. The
 * places of samples, their lengths, interpolation, classification before or after it in any precision, and
 * what is emitted are all the paper's (Wilson et al. 1994, section 2); only rounding in float32 may differ.
 * Pre-integrated slices: the transfer function along a field linear between planes, which leaves opacity to
 * rounding, and to colour what shaders/preintegrated.glsl says. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "gl_scene.h"

#define N    40
#define SIZE 23

static int16_t voxels[N * N * N];
static const struct brick_transfer_point points[] = {{-500, 0.1, 0.3, 0.9, 0.0},
                                                     {0, 0.9, 0.2, 0.1, 0.05},
                                                     {600, 1, 0.9, 0.5, 0.3},
                                                     {1500, 0.3, 0.9, 0.4, 0.9}};

static double voxel_at(const int64_t at[3])
{
    int64_t in[3];
    for (int a = 0; a < 3; a++)
        in[a] = at[a] < 0 ? 0 : at[a] > N - 1 ? N - 1 : at[a];
    return voxels[(in[2] * N + in[1]) * N + in[0]];
}

struct plain {
    const struct brick_transfer *transfer;
    const struct vr_quality *quality;
    double spacing_mm;
};

static double stored(double v, uint32_t bits)
{
    double most = bits == 8 ? 255.0 : 65535.0;
    return bits == 32 ? v : rint(fmin(v, 1.0) * most) / most;
}

/* Colour and opacity of a length of the transfer function at a value. */
static void integrate(const struct plain *p, double value, double length_mm, double rgba[4])
{
    double sigma;
    brick_transfer_eval(p->transfer, value, rgba, &sigma);
    double x = sigma * length_mm, fraction = x > 0.0 ? -expm1(-x) / x : 1.0;
    rgba[3] = -expm1(-x);
    for (int c = 0; c < 3; c++)
        rgba[c] *= p->transfer->emission == BRICK_EMISSION_INDEPENDENT
                       ? length_mm / p->transfer->unit_mm * fraction
                       : rgba[3];
}

/* A field linear from one value to another, in small steps. */
#define PARTS 64
static void integrate_linear(const struct plain *p, double front, double back, double length_mm,
                             double rgba[4])
{
    for (int c = 0; c < 4; c++)
        rgba[c] = 0.0;
    for (int i = 0; i < PARTS; i++) {
        double part[4];
        integrate(p, front + (i + 0.5) / PARTS * (back - front), length_mm / PARTS, part);
        for (int c = 0; c < 3; c++)
            rgba[c] += (1.0 - rgba[3]) * part[c];
        rgba[3] += (1.0 - rgba[3]) * part[3];
    }
}

/* Sum over a cell's corners: of values, or of what pre-classified voxels hold. Returns the value. */
static double sample(const struct plain *p, const double at[3], double length_mm, double rgba[4])
{
    const bool point = p->quality->slices.interpolation == VR_INTERPOLATION_POINT;
    const bool independent = p->transfer->emission == BRICK_EMISSION_INDEPENDENT;
    double value = 0.0, whole[4] = {0};
    for (int i = 0; i < 8; i++) {
        int64_t corner[3];
        double weight = 1.0, sigma, entry[4];
        for (int a = 0; a < 3; a++) {
            double f = at[a] - floor(at[a]);
            f = point ? f >= 0.5 : f;
            corner[a] = (int64_t)floor(at[a]) + (i >> a & 1);
            weight *= i >> a & 1 ? f : 1.0 - f;
        }
        value += weight * voxel_at(corner);
        integrate(p, voxel_at(corner), p->spacing_mm, entry);
        if (!independent)
            brick_transfer_eval(p->transfer, voxel_at(corner), entry, &sigma);
        for (int c = 0; c < 4; c++)
            whole[c] += weight * stored(entry[c], p->quality->slices.classified_bits);
    }
    integrate(p, value, length_mm, rgba);
    if (p->quality->classification != VR_CLASSIFY_PRE)
        return value;
    /* a part of the slice's thickness lets through its power of what the whole does */
    double alpha = -expm1(length_mm / p->spacing_mm * log1p(-whole[3]));
    for (int c = 0; c < 3; c++)
        rgba[c] = !independent     ? whole[c] * alpha
                  : whole[3] > 0.0 ? whole[c] * alpha / whole[3]
                                   : whole[c] * length_mm / p->spacing_mm;
    rgba[3] = alpha;
    return value;
}

/* Of the ray between two distances. Returns by how much a colour may be off. */
static double slice(const struct plain *p, const struct brick_ray *ray, double from, double to,
                    double rgba[4])
{
    double at[3][3], unused[4];
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            at[i][a] = ray->origin[a] + (from + 0.5 * i * (to - from)) * ray->direction[a];
    if (p->quality->classification != VR_CLASSIFY_PREINTEGRATED) {
        sample(p, at[1], to - from, rgba);
        return 0.0;
    }
    integrate_linear(p, sample(p, at[0], 1.0, unused), sample(p, at[2], 1.0, unused), to - from, rgba);
    double depth = -log1p(-rgba[3]);
    assert_true(depth <= 2.0);
    return depth * depth * depth * exp(-0.5 * depth) / 56.0;
}

/* slack: by how much a colour may be off. */
static void draw_plainly(const struct plain *p, const struct vr_scene *scene, const struct brick_grid *grid,
                         int planes, struct brick_image *image, double slack[SIZE * SIZE])
{
    struct brick_view view;
    struct brick_error err = {0};
    double forward[3], norm = 0.0, centre = 0.0;
    const double diagonal = sqrt(3.0) * N;
    assert_int_equal(brick_view_init(&view, &scene->camera, grid, SIZE, SIZE, &err), 0);
    for (int a = 0; a < 3; a++) {
        forward[a] = scene->camera.look_mm[a] - scene->camera.eye_mm[a];
        norm += forward[a] * forward[a];
    }
    for (int a = 0; a < 3; a++) {
        forward[a] /= sqrt(norm);
        centre += forward[a] * ((N - 1) / 2.0 - scene->camera.eye_mm[a]);
    }
    for (uint32_t y = 0; y < SIZE; y++)
        for (uint32_t x = 0; x < SIZE; x++) {
            struct brick_ray ray;
            float *out = image->rgba + 4 * (y * SIZE + x);
            double enter, leave, sum[4] = {0}, cosine = 0.0, off = 0.0;
            brick_view_ray(&view, x, y, &ray);
            bool hit = brick_ray_span(&ray, grid, &enter, &leave);
            for (int a = 0; a < 3; a++)
                cosine += ray.direction[a] * forward[a];
            for (int k = 0; k < planes && hit; k++) {
                double from = (centre - 0.5 * diagonal + k * p->spacing_mm) / cosine;
                double to = from + p->spacing_mm / cosine, rgba[4];
                from = fmax(from, enter);
                to = fmin(to, leave);
                if (!(to > from))
                    continue;
                off += (1.0 - sum[3]) * slice(p, &ray, from, to, rgba);
                for (int c = 0; c < 4; c++)
                    sum[c] += (1.0 - sum[3]) * (c < 3 ? rgba[c] : 0.0);
                sum[3] += (1.0 - sum[3]) * rgba[3];
            }
            for (int c = 0; c < 4; c++)
                out[c] = (float)sum[c];
            slack[y * SIZE + x] = off;
        }
}

static void assert_alike(const struct brick_image *image, const struct brick_image *plain,
                         const double slack[SIZE * SIZE], int kind, int planes, double *worst)
{
    double peak = 0.0, most = 0.0;
    for (int i = 0; i < 4 * SIZE * SIZE; i++)
        peak = fmax(peak, (double)plain->rgba[i]);
    for (int i = 0; i < 4 * SIZE * SIZE; i++)
        most = fmax(most,
                    fabs((double)image->rgba[i] - (double)plain->rgba[i]) - (i % 4 < 3 ? slack[i / 4] : 0.0));
    /* A blend and a sample round to some 2^-22 of what they add, at most. */
    if (!(most <= planes * 0x1p-22 * peak))
        fail_msg("kind %d: %g off (peak %g)", kind, most, peak);
    *worst = fmax(*worst, most / peak);
}

static void all_kinds(void **state)
{
    static double slack[SIZE * SIZE];
    struct memory_source source;
    struct brick_error err = {0};
    struct vr_renderer *renderer;
    (void)state;
    for (int i = 0; i < N * N * N; i++)
        voxels[i] = (int16_t)(900 * sin(0.5 * (i % N)) * cos(0.4 * (i / N % N)) +
                              700 * sin(0.6 * (i / N / N)) + (int)(noise64(5, (uint64_t)i) % 200));
    memory_source_init(&source, BRICK_I16, N, N, N, voxels);
    struct brick_volume *volume = volume_of(&source, 16);
    struct brick_transfer *transfer = transfer_of(points, 4);
    struct brick_image plain = {0}, image;
    assert_int_equal(brick_image_init(&plain, SIZE, SIZE, &err), 0);
    if (!(renderer = try_renderer(volume, VR_CONTEXT_AUTO))) {
        brick_image_finish(&plain);
        brick_transfer_destroy(&transfer);
        brick_volume_close(&volume);
        skip();
    }
    double worst = 0.0;
    for (int kind = 0; kind < 2 * 2 * 2 * 5; kind++) {
        const int pre = kind >> 3; /* post, pre of 8, 16, 32 bits, pre-integrated */
        if (pre == 4 && kind & 1)
            continue; /* does not go with independent emission */
        struct vr_scene scene = vr_scene_defaults;
        struct vr_quality quality = vr_quality_defaults;
        struct plain p = {transfer, &quality, 0.0};
        const int planes = 50 + 13 * kind;
        brick_transfer_set_emission(transfer, kind & 1 ? BRICK_EMISSION_INDEPENDENT : BRICK_EMISSION_SCALED);
        quality.method = VR_METHOD_SLICES;
        quality.termination = 0.0;
        quality.slices.planes = (uint32_t)planes;
        quality.slices.interpolation = kind & 2 ? VR_INTERPOLATION_POINT : VR_INTERPOLATION_TRILINEAR;
        quality.slices.back_to_front = kind % 3 == 0;
        quality.classification = pre == 4 ? VR_CLASSIFY_PREINTEGRATED
                                 : pre    ? VR_CLASSIFY_PRE
                                          : VR_CLASSIFY_POST;
        quality.slices.classified_bits = pre % 4 ? 4u << pre : 32;
        p.spacing_mm = sqrt(3.0) * N / planes;
        scene.transfer = transfer;
        scene.width = scene.height = SIZE;
        brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 33, 21, 40, kind & 4 ? 60 : 0, 1.0);
        for (int a = 0; a < 3; a++) { /* no sample half way between voxels: the nearest is one */
            scene.camera.eye_mm[a] += 0.013 * (a + 1);
            scene.camera.look_mm[a] += 0.013 * (a + 1);
        }
        draw_plainly(&p, &scene, brick_volume_grid(volume), planes, &plain, slack);
        render(renderer, &scene, &quality, &image, NULL);
        assert_alike(&image, &plain, slack, kind, planes, &worst);
        brick_image_finish(&image);
    }
    print_message("largest difference %.2g of the brightest channel\n", worst);
    vr_renderer_destroy(&renderer);
    brick_image_finish(&plain);
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_kinds),
    };
    return cmocka_run_group_tests_name("slices_reference", tests, NULL, NULL);
}
