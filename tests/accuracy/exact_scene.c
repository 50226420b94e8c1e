/* vr_render_exact in all modes and fields, from file to picture, where the answer has a closed form; and the
 * same bytes whatever the bricks, the cache and the threads. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <renderer/renderer.h>

#include "../support/memory_source.h"

enum { N = 20, SIZE = 24 };

static const double sheared[3][4] = {{0.8, -0.35, 0.1, -40}, {0.6, 0.75, -0.2, 7}, {0.05, 0.2, 1.6, 300}};

typedef double field_function(int x, int y, int z);

static double ramp(int x, int y, int z)
{
    (void)y, (void)z;
    return x;
}

/* |p - (9, 10, 9)|^2 */
static double bowl(int x, int y, int z)
{
    return (x - 9) * (x - 9) + (y - 10) * (y - 10) + (z - 9) * (z - 9);
}

static double tilted(int x, int y, int z)
{
    return 0.5 * x - 0.25 * y + 0.125 * z;
}

static double waves(int x, int y, int z)
{
    return 5.0 + 4.0 * sin(0.7 * x) * cos(0.5 * y + 0.3 * z) +
           0.01 * (double)(noise64(1, (uint64_t)(x + N * (y + N * z))) % 101);
}

/* Above 1, then no value, then below; and the same the other way round, with bricks of nothing between. */
static double gap(int x, int y, int z)
{
    (void)y, (void)z;
    return x < 8 ? 2.0 : x < 10 ? (double)NAN : 0.0;
}

static double wide_gap(int x, int y, int z)
{
    (void)y, (void)z;
    return x < 1 ? 0.0 : x < 18 ? (double)NAN : 2.0;
}

/* A brick of nothing beside one that is wholly above. */
static double aligned_gap(int x, int y, int z)
{
    (void)y, (void)z;
    return x < 8 ? (double)NAN : 2.0;
}

static struct brick_volume *make_volume(field_function *f, const double affine[3][4], uint32_t edge)
{
    static float voxels[N * N * N];
    struct memory_source source;
    struct brick_build_params params = brick_build_defaults;
    for (int i = 0; i < N * N * N; i++)
        voxels[i] = (float)f(i % N, i / N % N, i / (N * N));
    memory_source_init(&source, BRICK_F32, N, N, N, voxels);
    if (affine)
        memcpy(source.base.geometry.affine, affine, sizeof source.base.geometry.affine);
    params.edge = edge;
    return build_and_open(&source, "scene.brick", &params);
}

/* Extinction and colour linear in the value, from 0 to 20. */
static struct brick_transfer_knot line_knots[2] = {{0, 0.25, 0, 1, 0.01}, {20, 0.75, 1, 0.5, 0.5}};
static struct brick_interval everywhere = {-INFINITY, INFINITY};
static const struct brick_transfer line = {.knots = line_knots,
                                           .count = 2,
                                           .support = &everywhere,
                                           .support_count = 1,
                                           .visible = &everywhere,
                                           .visible_count = 1,
                                           .continuous = true,
                                           .unit_mm = 2};

struct shot {
    struct brick_image image;
    double hit_mm[SIZE * SIZE];
    struct brick_view view;
};

static struct vr_scene make_scene(const struct brick_volume *volume, enum brick_mode mode, double azimuth,
                                  double elevation, double ortho)
{
    struct vr_scene scene = vr_scene_defaults;
    scene.mode = mode;
    scene.transfer = mode == BRICK_MODE_ISO ? NULL : &line;
    scene.width = scene.height = SIZE;
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), azimuth, elevation, 0, ortho, 1.0);
    return scene;
}

static void take(struct shot *shot, const struct brick_volume *volume, const struct vr_scene *scene,
                 struct vr_exact_params params)
{
    struct brick_error err;
    params.hit_mm = shot->hit_mm;
    assert_int_equal(brick_image_init(&shot->image, SIZE, SIZE, NULL), BRICK_OK);
    assert_int_equal(
        brick_view_init(&shot->view, &scene->camera, brick_volume_grid(volume), SIZE, SIZE, NULL), BRICK_OK);
    if (vr_render_exact(volume, scene, &params, &shot->image, NULL, &err))
        fail_msg("%s", err.message);
}

static struct vr_exact_params in_field(enum vr_field field)
{
    struct vr_exact_params params = vr_exact_defaults;
    params.field = field;
    return params;
}

/* float32 pictures: to half a unit in the last place of 1, and the tolerance. */
static void near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance))
        fail_msg("%.17g is not %.17g: %.3g off, %.3g allowed", a, b, a - b, tolerance);
}
#define FLOAT_NEAR (0x1p-24 + 1e-10)

/* The gradient of a ramp points one way wherever it is sampled, so its light is a factor. */
static void shaded_ramp(void **state)
{
    (void)state;
    for (uint32_t level = 0; level < 2; level++)
        for (int field = 0; field < 3; field++) {
            struct brick_volume *volume = make_volume(ramp, sheared, 8);
            struct vr_scene scene = make_scene(volume, BRICK_MODE_SHADED, 35, 20, level ? 22 : 0);
            struct shot lit, plain;
            double inverse[3][4], n[3], length;
            scene.level = level;
            take(&lit, volume, &scene, in_field((enum vr_field)field));
            scene.mode = BRICK_MODE_DVR;
            take(&plain, volume, &scene, in_field((enum vr_field)field));
            brick_affine_invert(sheared, inverse);
            for (int i = 0; i < 3; i++)
                n[i] = inverse[0][i];
            length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            int seen = 0;
            for (uint32_t p = 0; p < SIZE * SIZE; p++) {
                struct brick_ray ray;
                double facing = 0.0;
                brick_view_ray(&lit.view, p % SIZE, p / SIZE, &ray);
                for (int i = 0; i < 3; i++)
                    for (int a = 0; a < 3; a++)
                        facing += n[i] / length * sheared[i][a] * ray.direction[a];
                facing = fabs(facing);
                const float *a = &lit.image.rgba[4 * p], *b = &plain.image.rgba[4 * p];
                seen += b[3] > 0.5f;
                for (int c = 0; c < 3; c++)
                    near(a[c], b[c] * (0.2 + 0.7 * facing) + 0.3 * pow(facing, 20.0) * b[3], 3 * FLOAT_NEAR);
                assert_true(a[3] == b[3]);
            }
            assert_true(seen > 50);
            brick_image_finish(&lit.image);
            brick_image_finish(&plain.image);
            brick_volume_close(&volume);
        }
}

/* Seen across, each ray of a ramp has one value. From the front +x of the volume is to the right or to the
 * left: the ray itself says where it is. */
static void mip_of_a_ramp(void **state)
{
    struct brick_volume *volume = make_volume(ramp, NULL, 8);
    struct vr_scene scene = make_scene(volume, BRICK_MODE_MIP, 0, 0, 15);
    (void)state;
    for (int field = 0; field < 2; field++) {
        struct shot shot;
        take(&shot, volume, &scene, in_field((enum vr_field)field));
        for (uint32_t p = 0; p < SIZE * SIZE; p++) {
            struct brick_ray ray;
            double rgb[3], sigma;
            brick_view_ray(&shot.view, p % SIZE, p / SIZE, &ray);
            brick_transfer_eval(&line, fmin(fmax(ray.origin[0], 0), N - 1), rgb, &sigma);
            double alpha = -expm1(-sigma * line.unit_mm);
            near(shot.image.rgba[4 * p + 3], alpha, FLOAT_NEAR);
            for (int c = 0; c < 3; c++)
                near(shot.image.rgba[4 * p + (uint32_t)c], alpha * rgb[c], FLOAT_NEAR);
        }
        brick_image_finish(&shot.image);
    }
    brick_volume_close(&volume);
}

static void iso_of_a_plane(void **state)
{
    struct brick_volume *volume = make_volume(tilted, sheared, 16);
    struct vr_scene scene = make_scene(volume, BRICK_MODE_ISO, -60, 25, 0);
    (void)state;
    scene.isovalue = 3.3;
    for (int field = 0; field < 2; field++) {
        struct shot shot;
        int hits = 0;
        take(&shot, volume, &scene, in_field((enum vr_field)field));
        for (uint32_t p = 0; p < SIZE * SIZE; p++) {
            static const double slope[3] = {0.5, -0.25, 0.125};
            struct brick_ray ray;
            double at = -3.3, rate = 0.0;
            bool inside = true;
            brick_view_ray(&shot.view, p % SIZE, p / SIZE, &ray);
            for (int i = 0; i < 3; i++) {
                at += slope[i] * ray.origin[i];
                rate += slope[i] * ray.direction[i];
            }
            double t = -at / rate;
            for (int i = 0; i < 3; i++) {
                double x = ray.origin[i] + t * ray.direction[i];
                inside = inside && x > 0.0 && x < N - 1;
            }
            assert_true((shot.image.rgba[4 * p + 3] == 1.0f) == isfinite(shot.hit_mm[p]));
            if (inside) {
                near(shot.hit_mm[p], t, 1e-11); /* t of some 100 mm, values of some 10, slopes of 1/2 */
                hits++;
            }
        }
        assert_true(hits > 50);
        brick_image_finish(&shot.image);
    }
    brick_volume_close(&volume);
}

/* Interpolated, u^2 is u^2 + f (1 - f) with f the fraction of u: the field of |p - c|^2 lies between the
 * truth and 3/4 above it, so hits lie between two spheres. */
static void iso_of_a_sphere(void **state)
{
    struct brick_volume *volume = make_volume(bowl, NULL, 8);
    struct vr_scene scene = make_scene(volume, BRICK_MODE_ISO, 20, -40, 16);
    struct shot shot;
    int hits = 0, misses = 0;
    (void)state;
    scene.isovalue = 40.0;
    take(&shot, volume, &scene, vr_exact_defaults);
    for (uint32_t p = 0; p < SIZE * SIZE; p++) {
        static const double centre[3] = {9, 10, 9};
        struct brick_ray ray;
        double along = 0.0, distance2 = 0.0, hit2 = 0.0;
        brick_view_ray(&shot.view, p % SIZE, p / SIZE, &ray);
        for (int i = 0; i < 3; i++)
            along += (centre[i] - ray.origin[i]) * ray.direction[i];
        for (int i = 0; i < 3; i++) {
            double nearest = ray.origin[i] + along * ray.direction[i] - centre[i];
            double hit = ray.origin[i] + shot.hit_mm[p] * ray.direction[i] - centre[i];
            distance2 += nearest * nearest;
            hit2 += hit * hit;
        }
        if (isfinite(shot.hit_mm[p])) {
            hits++;
            assert_true(shot.hit_mm[p] < along && hit2 <= 40.0 + 1e-11 && hit2 >= 39.25 - 1e-11);
        } else {
            misses++;
            assert_true(distance2 >= 39.25 - 1e-11);
        }
    }
    assert_true(hits > 100 && misses > 100);
    brick_image_finish(&shot.image);

    /* Cut through its middle: no cap, and what is seen is the wall behind, from inside. */
    scene.clip_count = 1;
    scene.clip[0] = (struct vr_plane){{0, 1, 0}, 10.0};
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 0, 0, 0, 3, 1.0);
    take(&shot, volume, &scene, vr_exact_defaults);
    for (uint32_t p = 0; p < SIZE * SIZE; p++) {
        struct brick_ray ray;
        brick_view_ray(&shot.view, p % SIZE, p / SIZE, &ray);
        assert_true(ray.origin[1] + shot.hit_mm[p] * ray.direction[1] > 15.0);
    }
    brick_image_finish(&shot.image);
    brick_volume_close(&volume);
}

/* Along a row of voxels the field of the bowl is linear between each two. */
static void iso_on_a_row_of_voxels(void **state)
{
    struct brick_volume *volume = make_volume(bowl, NULL, 8);
    struct vr_scene scene = make_scene(volume, BRICK_MODE_ISO, 0, 0, SIZE);
    struct shot shot;
    (void)state;
    /* rays at x = integer, z = integer */
    for (int i = 0; i < 3; i++)
        scene.camera.look_mm[i] = i == 1 ? 30 : i == 0 ? 8.5 : 9.5;
    memcpy(scene.camera.eye_mm, scene.camera.look_mm, sizeof scene.camera.eye_mm);
    scene.camera.eye_mm[1] = -30;
    scene.isovalue = 40.0;
    for (int field = 0; field < 2; field++) {
        int hits = 0;
        take(&shot, volume, &scene, in_field((enum vr_field)field));
        for (uint32_t p = 0; p < SIZE * SIZE; p++) {
            struct brick_ray ray;
            brick_view_ray(&shot.view, p % SIZE, p / SIZE, &ray);
            double x = ray.origin[0], z = ray.origin[2], want = INFINITY;
            near(x, rint(x), 1e-12);
            near(z, rint(z), 1e-12);
            if (x < -0.5 || x > N - 0.5 || z < -0.5 || z > N - 0.5)
                continue;
            double rest = (x - 9) * (x - 9) + (z - 9) * (z - 9);
            for (int y = 1; y < N && isinf(want); y++) {
                double a = rest + (y - 11) * (y - 11), b = rest + (y - 10) * (y - 10);
                if ((a >= 40.0) != (b >= 40.0))
                    want = y - 1 + (40.0 - a) / (b - a);
            }
            double found = ray.origin[1] + shot.hit_mm[p] * ray.direction[1];
            hits += isfinite(want);
            assert_true(isfinite(want) == isfinite(found));
            if (isfinite(want))
                near(found, want, 1e-11);
        }
        assert_true(hits > 80);
        brick_image_finish(&shot.image);
    }
    brick_volume_close(&volume);
}

static double one(int x, int y, int z)
{
    (void)x, (void)y, (void)z;
    return 1.0;
}

/* A box of one value seen along y, between y = 3.25 and the plane x + y = 14. */
static void clipped_box(void **state)
{
    struct brick_volume *volume = make_volume(one, NULL, 16);
    struct vr_scene scene = make_scene(volume, BRICK_MODE_DVR, 0, 0, 18);
    struct shot shot;
    double rgb[3], sigma;
    (void)state;
    scene.clip_count = 3;
    scene.clip[0] = (struct vr_plane){{0, 2, 0}, 6.5};
    scene.clip[1] = (struct vr_plane){{-1, -1, 0}, -14.0};
    scene.clip[2] = (struct vr_plane){{0, 0, 1}, 4.0};
    take(&shot, volume, &scene, vr_exact_defaults);
    brick_transfer_eval(&line, 1.0, rgb, &sigma);
    for (uint32_t p = 0; p < SIZE * SIZE; p++) {
        struct brick_ray ray;
        brick_view_ray(&shot.view, p % SIZE, p / SIZE, &ray);
        double length = ray.origin[2] < 4.0 ? 0.0 : fmax(14.0 - ray.origin[0] - 3.25, 0.0);
        near(shot.image.rgba[4 * p + 3], -expm1(-sigma * length), FLOAT_NEAR);
        near(shot.image.rgba[4 * p + 2], rgb[2] * -expm1(-sigma * length), FLOAT_NEAR);
    }
    brick_image_finish(&shot.image);
    brick_volume_close(&volume);
}

static double largest_difference(const struct shot *a, const struct shot *b)
{
    struct brick_image_difference difference;
    assert_int_equal(brick_image_compare(&a->image, &b->image, &difference, NULL), BRICK_OK);
    return difference.max_abs;
}

/* A linear field is the same on tetrahedra; linear classification is the same before interpolation. Both are
 * something else on other fields and functions. */
static void where_fields_agree(void **state)
{
    static struct brick_transfer_knot bent_knots[3] = {
        {0, 1, 0, 1, 0.0}, {5, 0, 1, 1, 0.4}, {20, 0, 1, 0, 0.0}};
    struct brick_transfer bent = line;
    static const enum brick_mode modes[] = {BRICK_MODE_DVR, BRICK_MODE_SHADED, BRICK_MODE_ISO,
                                            BRICK_MODE_MIP};
    struct brick_volume *linear = make_volume(tilted, sheared, 8);
    bent.knots = bent_knots;
    bent.count = 3;
    (void)state;
    for (int n = 0; n < 4; n++) {
        struct vr_scene scene = make_scene(linear, modes[n], 35, 20, 0);
        struct shot a, b;
        scene.isovalue = 2.0;
        if (n != 2)
            scene.transfer = &bent;
        take(&a, linear, &scene, in_field(VR_FIELD_TRILINEAR));
        take(&b, linear, &scene, in_field(VR_FIELD_TETRAHEDRA));
        assert_true(largest_difference(&a, &b) <= 2 * FLOAT_NEAR);
        brick_image_finish(&a.image);
        brick_image_finish(&b.image);
    }
    brick_volume_close(&linear);

    struct brick_volume *curved = make_volume(waves, sheared, 8);
    for (int n = 0; n < 2; n++) {
        struct vr_scene scene = make_scene(curved, modes[n], 35, 20, 0);
        struct shot post, pre, tetrahedra;
        take(&post, curved, &scene, in_field(VR_FIELD_TRILINEAR));
        take(&pre, curved, &scene, in_field(VR_FIELD_PRECLASSIFIED));
        take(&tetrahedra, curved, &scene, in_field(VR_FIELD_TETRAHEDRA));
        assert_true(largest_difference(&post, &pre) <= 2 * FLOAT_NEAR);
        assert_true(largest_difference(&post, &tetrahedra) > 1e-3);
        brick_image_finish(&pre.image);
        brick_image_finish(&post.image);
        scene.transfer = &bent;
        take(&post, curved, &scene, in_field(VR_FIELD_TRILINEAR));
        take(&pre, curved, &scene, in_field(VR_FIELD_PRECLASSIFIED));
        assert_true(largest_difference(&post, &pre) > 1e-3);
        brick_image_finish(&pre.image);
        brick_image_finish(&post.image);
        brick_image_finish(&tetrahedra.image);
    }
    brick_volume_close(&curved);
}

/* What has no value has no side: nothing is hit where it ends. */
static void not_finite_bounds_no_surface(void **state)
{
    static field_function *const gaps[] = {gap, wide_gap, aligned_gap};
    (void)state;
    for (int n = 0; n < 6; n++) {
        struct brick_volume *volume = make_volume(gaps[n / 2], NULL, n % 2 ? 8 : 16);
        struct vr_scene scene = make_scene(volume, BRICK_MODE_ISO, 60, 10, 0);
        struct shot shot;
        scene.isovalue = 1.0;
        take(&shot, volume, &scene, vr_exact_defaults);
        for (uint32_t p = 0; p < SIZE * SIZE; p++)
            assert_true(isinf(shot.hit_mm[p]) && shot.image.rgba[4 * p + 3] == 0.0f);
        brick_image_finish(&shot.image);
        brick_volume_close(&volume);
    }
}

static void same_bytes(void **state)
{
    static const struct {
        enum brick_mode mode;
        enum vr_field field;
    } kinds[] = {
        {BRICK_MODE_SHADED, VR_FIELD_TRILINEAR},  {BRICK_MODE_SHADED, VR_FIELD_TETRAHEDRA},
        {BRICK_MODE_DVR, VR_FIELD_PRECLASSIFIED}, {BRICK_MODE_ISO, VR_FIELD_TRILINEAR},
        {BRICK_MODE_ISO, VR_FIELD_TETRAHEDRA},    {BRICK_MODE_MIP, VR_FIELD_TRILINEAR},
    };
    (void)state;
    for (size_t n = 0; n < sizeof kinds / sizeof kinds[0]; n++) {
        struct shot first = {.image = {0}};
        for (int e = 0; e < 3; e++) {
            struct brick_volume *volume = make_volume(waves, sheared, 8u << e);
            struct vr_scene scene = make_scene(volume, kinds[n].mode, 35, 20, 0);
            struct vr_exact_params params = in_field(kinds[n].field);
            struct shot shot;
            scene.isovalue = 7.0;
            params.threads = 1 + (unsigned)e;
            if (e > 0) /* room for one brick or two: fewer than threads */
                params.host_cache_bytes =
                    (uint64_t)e * brick_grid_max_payload_bytes(brick_volume_grid(volume));
            take(&shot, volume, &scene, params);
            if (e == 0) {
                first = shot;
            } else {
                assert_memory_equal(first.image.rgba, shot.image.rgba,
                                    SIZE * SIZE * 4 * sizeof *shot.image.rgba);
                assert_memory_equal(first.hit_mm, shot.hit_mm, sizeof first.hit_mm);
                brick_image_finish(&shot.image);
            }
            brick_volume_close(&volume);
        }
        brick_image_finish(&first.image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shaded_ramp),
        cmocka_unit_test(mip_of_a_ramp),
        cmocka_unit_test(iso_of_a_plane),
        cmocka_unit_test(iso_of_a_sphere),
        cmocka_unit_test(iso_on_a_row_of_voxels),
        cmocka_unit_test(clipped_box),
        cmocka_unit_test(where_fields_agree),
        cmocka_unit_test(not_finite_bounds_no_surface),
        cmocka_unit_test(same_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
