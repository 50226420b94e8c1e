/* The camera: where rays go, which way is left, and the span inside the box. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <brick/camera.h>

/* Oblique, anisotropic and, with flip, left-handed. */
static void make_grid(struct brick_grid *grid, bool oblique, bool flip)
{
    struct brick_geometry geometry = {.dims = {20, 30, 10}, .slope = 1.0};
    static const double plain[3][4] = {{1, 0, 0, -9.5}, {0, 1, 0, -14.5}, {0, 0, 3, 100}};
    static const double skewed[3][4] = {{0.8, -0.5, 0.1, -40}, {0.6, 0.9, -0.2, 7}, {0.05, 0.3, 2.5, 300}};
    memcpy(geometry.affine, oblique ? skewed : plain, sizeof geometry.affine);
    if (flip)
        for (int i = 0; i < 3; i++)
            geometry.affine[i][1] = -geometry.affine[i][1];
    assert_int_equal(brick_grid_init(grid, BRICK_U8, &geometry, 8, 2, 4, NULL), BRICK_OK);
}

static void to_world(const struct brick_grid *grid, const double index[3], double mm[3])
{
    for (int i = 0; i < 3; i++)
        mm[i] = grid->affine[i][0] * index[0] + grid->affine[i][1] * index[1] +
                grid->affine[i][2] * index[2] + grid->affine[i][3];
}

static void world_ray(const struct brick_view *view, const struct brick_grid *grid, uint32_t x, uint32_t y,
                      double t, double mm[3])
{
    struct brick_ray ray;
    double at[3];
    brick_view_ray(view, x, y, &ray);
    for (int i = 0; i < 3; i++)
        at[i] = ray.origin[i] + t * ray.direction[i];
    to_world(grid, at, mm);
}

/* From the front, the patient's left (+x) is on the viewer's right, the head (+z) on top; for every affine.
 */
static void picture_is_upright_and_not_mirrored(void **state)
{
    (void)state;
    for (int kind = 0; kind < 8; kind++) {
        struct brick_grid grid;
        struct brick_camera camera;
        struct brick_view view;
        double left[3], right[3], top[3], middle[3];
        make_grid(&grid, kind & 1, kind & 2);
        brick_camera_orbit(&camera, &grid, 0, 0, 0, kind & 4 ? 50.0 : 0.0, 1.0);
        assert_int_equal(brick_view_init(&view, &camera, &grid, 65, 65, NULL), BRICK_OK);
        world_ray(&view, &grid, 0, 32, 100, left);
        world_ray(&view, &grid, 64, 32, 100, right);
        world_ray(&view, &grid, 32, 0, 100, top);
        world_ray(&view, &grid, 32, 32, 100, middle);
        assert_true(right[0] > left[0] + 1.0);
        assert_true(top[2] > middle[2] + 1.0);
        assert_true(fabs(right[2] - left[2]) < 1e-9 && fabs(right[1] - left[1]) < 1e-9);
        assert_true(camera.eye_mm[1] < camera.look_mm[1]);
        assert_true(fabs(camera.eye_mm[0] - camera.look_mm[0]) < 1e-12);
    }
}

static void orbit_angles_turn_the_right_way(void **state)
{
    struct brick_grid grid;
    struct brick_camera camera;
    (void)state;
    make_grid(&grid, false, false);
    brick_camera_orbit(&camera, &grid, 90, 0, 0, 0, 1.0);
    assert_true(camera.eye_mm[0] > 20.0 &&
                camera.eye_mm[1] == camera.look_mm[1]); /* exactly along the axis */
    brick_camera_orbit(&camera, &grid, 180, 0, 0, 0, 1.0);
    assert_true(camera.eye_mm[1] > 20.0 && camera.eye_mm[0] == camera.look_mm[0]);
    brick_camera_orbit(&camera, &grid, -90, 0, 0, 0, 1.0);
    assert_true(camera.eye_mm[0] < -20.0 && camera.eye_mm[1] == camera.look_mm[1]);
    brick_camera_orbit(&camera, &grid, 0, 90, 0, 0, 1.0);
    assert_true(camera.eye_mm[2] > camera.look_mm[2] + 20.0 && camera.eye_mm[1] == camera.look_mm[1]);
    brick_camera_orbit(&camera, &grid, 30, 20, 0, 0, 1.0);
    assert_true(camera.eye_mm[0] > 0.0 && camera.eye_mm[1] < 0.0 && camera.eye_mm[2] > camera.look_mm[2]);
    double d[3], length = 0.0;
    for (int i = 0; i < 3; i++) {
        d[i] = camera.eye_mm[i] - camera.look_mm[i];
        length += d[i] * d[i];
    }
    assert_true(fabs(atan2(d[0], -d[1]) - M_PI / 6.0) < 1e-12);
    assert_true(fabs(asin(d[2] / sqrt(length)) - M_PI / 9.0) < 1e-12);
}

/* t is in mm from the eye or the eye plane, and the middle pixel looks at the aim. */
static void rays_are_in_mm(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        struct brick_grid grid;
        struct brick_camera camera;
        struct brick_view view;
        double from[3], to[3], distance = 0.0, gone = 0.0;
        make_grid(&grid, true, kind & 1);
        brick_camera_orbit(&camera, &grid, 33, -21, 40, kind & 2 ? 50.0 : 0.0, 1.5);
        assert_int_equal(brick_view_init(&view, &camera, &grid, 31, 21, NULL), BRICK_OK);
        for (int i = 0; i < 3; i++)
            distance += pow(camera.look_mm[i] - camera.eye_mm[i], 2);
        world_ray(&view, &grid, 15, 10, sqrt(distance), to);
        for (int i = 0; i < 3; i++)
            assert_true(fabs(to[i] - camera.look_mm[i]) < 1e-9);
        world_ray(&view, &grid, 3, 7, 0.0, from);
        world_ray(&view, &grid, 3, 7, 12.5, to);
        for (int i = 0; i < 3; i++)
            gone += pow(to[i] - from[i], 2);
        assert_true(fabs(sqrt(gone) - 12.5) < 1e-10);
        if (!(kind & 2)) {
            double along = 0.0, length = 0.0; /* row 0's edge is fov / 2 from the axis */
            double edge[3];
            struct brick_ray ray;
            brick_view_ray(&view, 15, 0, &ray);
            for (int i = 0; i < 3; i++) {
                double index[3] = {ray.direction[0], ray.direction[1], ray.direction[2]};
                edge[i] = grid.affine[i][0] * index[0] + grid.affine[i][1] * index[1] +
                          grid.affine[i][2] * index[2];
                along += edge[i] * (camera.look_mm[i] - camera.eye_mm[i]) / sqrt(distance);
                length += edge[i] * edge[i];
            }
            assert_true(fabs(length - 1.0) < 1e-12);
            assert_true(fabs(tan(acos(along)) - tan(20.0 * M_PI / 180.0) * 20.0 / 21.0) < 1e-9);
        }
    }
}

/* The default distance: every corner is in the picture, for wide and for tall ones. */
static void bounding_sphere_fits(void **state)
{
    static const uint32_t size[3][2] = {{200, 200}, {400, 100}, {100, 400}};
    (void)state;
    for (int s = 0; s < 3; s++)
        for (int azimuth = 0; azimuth < 360; azimuth += 45) {
            struct brick_grid grid;
            struct brick_camera camera;
            make_grid(&grid, true, false);
            double aspect = (double)size[s][0] / size[s][1];
            brick_camera_orbit(&camera, &grid, azimuth, 25, 0, 0, aspect);
            assert_true(camera.fov_deg == 30.0);
            double forward[3], right[3], distance = 0.0;
            for (int i = 0; i < 3; i++) {
                forward[i] = camera.look_mm[i] - camera.eye_mm[i];
                distance += forward[i] * forward[i];
            }
            distance = sqrt(distance);
            for (int i = 0; i < 3; i++)
                forward[i] /= distance;
            for (int i = 0; i < 3; i++)
                right[i] = forward[(i + 1) % 3] * camera.up[(i + 2) % 3] -
                           forward[(i + 2) % 3] * camera.up[(i + 1) % 3];
            double tangent = tan(15.0 * M_PI / 180.0);
            for (int corner = 0; corner < 8; corner++) {
                double index[3], mm[3], depth = 0, across = 0, above = 0;
                for (int i = 0; i < 3; i++)
                    index[i] = corner >> i & 1 ? (double)grid.dims[i] - 0.5 : -0.5;
                to_world(&grid, index, mm);
                for (int i = 0; i < 3; i++) {
                    depth += (mm[i] - camera.eye_mm[i]) * forward[i];
                    across += (mm[i] - camera.eye_mm[i]) * right[i];
                    above += (mm[i] - camera.eye_mm[i]) * camera.up[i];
                }
                assert_true(fabs(above) <= tangent * depth);
                assert_true(fabs(across) <= tangent * aspect * depth);
            }
        }
}

static void span_is_the_part_in_the_box(void **state)
{
    struct brick_grid grid;
    double a, b;
    (void)state;
    make_grid(&grid, false, false); /* 20 x 30 x 10 */
    const struct brick_ray through = {{5, -10, 3}, {0, 2, 0}};
    assert_true(brick_ray_span(&through, &grid, &a, &b));
    assert_true(a == 4.75 && b == 19.75);
    const struct brick_ray inside = {{5, 10, 3}, {0, -2, 0}};
    assert_true(brick_ray_span(&inside, &grid, &a, &b));
    assert_true(a == 0.0 && b == 5.25);
    const struct brick_ray behind = {{5, -10, 3}, {0, -2, 0}};
    assert_false(brick_ray_span(&behind, &grid, &a, &b));
    const struct brick_ray beside = {{19.6, -10, 3}, {0, 2, 0}};
    assert_false(brick_ray_span(&beside, &grid, &a, &b));
    const struct brick_ray in_face = {{19.5, -10, 3}, {0, 2, 0}};
    assert_true(brick_ray_span(&in_face, &grid, &a, &b));
    const struct brick_ray corner = {{-1.5, -1.5, -1.5}, {1, 1, 1}};
    assert_true(brick_ray_span(&corner, &grid, &a, &b));
    assert_true(a == 1.0 && b == 11.0);
}

static void bad_cameras_are_refused(void **state)
{
    struct brick_grid grid;
    struct brick_camera good, bad;
    struct brick_view view;
    (void)state;
    make_grid(&grid, false, false);
    brick_camera_orbit(&good, &grid, 10, 90, 0, 0, 1.0);
    assert_int_equal(brick_view_init(&view, &good, &grid, 8, 8, NULL), BRICK_OK); /* straight from above */
    assert_int_equal(brick_view_init(&view, &good, &grid, 0, 8, NULL), BRICK_ERR_ARGUMENT);
    for (int kind = 0; kind < 9; kind++) {
        bad = good;
        switch (kind) {
        case 0:
            memcpy(bad.eye_mm, bad.look_mm, sizeof bad.eye_mm);
            break;
        case 1:
            for (int i = 0; i < 3; i++)
                bad.up[i] = 3.0 * (bad.look_mm[i] - bad.eye_mm[i]);
            break;
        case 2:
            bad.up[0] = bad.up[1] = bad.up[2] = 0.0;
            break;
        case 3:
            bad.fov_deg = 180.0;
            break;
        case 4:
            bad.fov_deg = 0.0;
            break;
        case 5:
            bad.fov_deg = NAN;
            break;
        case 6:
            bad.ortho_height_mm = INFINITY;
            break;
        case 7:
            bad.eye_mm[1] = NAN;
            break;
        default:
            bad.look_mm[2] = INFINITY;
        }
        struct brick_error err = {0};
        assert_int_equal(brick_view_init(&view, &bad, &grid, 8, 8, &err), BRICK_ERR_ARGUMENT);
        assert_true(strlen(err.message) > 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(picture_is_upright_and_not_mirrored),
        cmocka_unit_test(orbit_angles_turn_the_right_way),
        cmocka_unit_test(rays_are_in_mm),
        cmocka_unit_test(bounding_sphere_fits),
        cmocka_unit_test(span_is_the_part_in_the_box),
        cmocka_unit_test(bad_cameras_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
