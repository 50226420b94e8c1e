/* Projected cells from where no parallel view is: from inside the volume, on its lattice and its surface,
 * from very far away, and of what is behind the eye. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "cells_scene.h"

/* A point of level 0's index space, in mm. */
static void to_mm(const struct brick_volume *volume, const double at[3], double mm[3])
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    for (int i = 0; i < 3; i++) {
        mm[i] = grid->affine[i][3];
        for (int j = 0; j < 3; j++)
            mm[i] += grid->affine[i][j] * at[j];
    }
}

static void place(struct fixture *f, const double eye[3], const double at[3], double fov_deg, uint32_t width,
                  uint32_t height)
{
    struct brick_camera *camera = &f->scene.camera;
    *camera = (struct brick_camera){.up = {0.1, 0.2, 0.97}, .fov_deg = fov_deg};
    to_mm(f->volume, eye, camera->eye_mm);
    to_mm(f->volume, at, camera->look_mm);
    f->scene.width = width;
    f->scene.height = height;
}

/* Odd pictures have a ray along the view: through voxels, along the faces and edges of cells, where they are
 * looked along; on straight axes exactly along them. */
static void test_eye(void **state)
{
    static float voxels[NX * NY * NZ];
    static const struct {
        const char *what;
        double eye[3], at[3], fov_deg;
        uint32_t width, height;
    } cases[] = {
        {"inside a cell", {17.3, 14.8, 20.6}, {30, 3, 11}, 60, 64, 48},
        {"on a voxel", {18, 15, 20}, {18, 29, 20}, 90, 63, 63},
        {"on an edge", {18, 15.4, 20}, {40, 15.4, 20}, 40, 65, 33},
        {"on a face, along it", {18.5, 15.25, 20}, {4, 2, 20}, 120, 65, 65},
        {"near a voxel", {18 + 1e-9, 15 - 1e-9, 20 + 1e-7}, {0, 0, 0}, 100, 64, 64},
        {"on a tetrahedron's face", {18.5, 15.25, 20.25}, {0, 20, 40}, 100, 64, 64},
        {"wide", {18.1, 15.2, 20.3}, {20, 10, 0}, 172, 96, 64},
        {"on a corner of the box", {-0.5, -0.5, -0.5}, {18, 15, 20}, 90, 64, 64},
        {"on a side of the box", {36.5, 11, 7}, {0, 14, 20}, 90, 64, 64},
        {"in the rim", {36.2, 11.3, 7.1}, {0, 14, 20}, 90, 64, 64},
        {"along a side", {-0.5, 12, -20}, {-0.5, 12, 30}, 50, 64, 64},
        {"beside the volume", {-4, 14.3, 20.2}, {-4.2, 29.3, 30}, 140, 64, 64},
        {"few pixels", {17.3, 14.8, 20.6}, {30, 3, 11}, 150, 3, 2},
        {"through a keyhole", {17.3, 14.8, -90}, {17.9, 14, 20}, 0.01, 32, 32},
    };
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    for (size_t i = 0; i < 2 * (sizeof cases / sizeof *cases) && f.renderer; i++) {
        if (i == sizeof cases / sizeof *cases) {
            static const double straight[3][4] = {{0.9, 0, 0, 0}, {0, 0.8, 0, 0}, {0, 0, 1.4, 0}};
            vr_renderer_destroy(&f.renderer);
            brick_volume_close(&f.volume);
            memcpy(f.source.base.geometry.affine, straight, sizeof straight);
            f.volume = volume_of(&f.source, 16);
            f.renderer = try_renderer(f.volume, VR_CONTEXT_AUTO);
        }
        size_t c = i % (sizeof cases / sizeof *cases);
        place(&f, cases[c].eye, cases[c].at, cases[c].fov_deg, cases[c].width, cases[c].height);
        against_exact(f.renderer, f.volume, &f.scene, cases[c].what);
    }
    if (f.renderer) {
        /* Nothing of what is behind the eye, and nothing turned round. */
        struct brick_image image;
        place(&f, (const double[]){-1, 14, 20}, (const double[]){-9, 14, 20}, 120, 64, 64);
        render(f.renderer, &f.scene, &f.quality, &image, NULL);
        for (size_t i = 0; i < (size_t)4 * 64 * 64; i++)
            assert_true(image.rgba[i] == 0.0f);
        brick_image_finish(&image);
    }
    fixture_finish(&f);
}

/* So many times as far away as the volume is large, a ray is beside the parallel one by less than that part
 * of the volume's size, and the picture changes by less than 1 a mm. */
static void test_far(void **state)
{
    static float voxels[NX * NY * NZ];
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    for (double times = 1e3; times < 1e7 && f.renderer; times *= 1e3) {
        struct brick_camera *camera = &f.scene.camera;
        const double height_mm = 70.0, size_mm = 70.0;
        double distance = 0.0, more = size_mm * times;
        look(&f.scene, f.volume, 37, 24, false);
        struct brick_image image, want = exact_of(f.volume, &f.scene);
        struct brick_image_difference d;
        for (int i = 0; i < 3; i++)
            distance = hypot(distance, camera->eye_mm[i] - camera->look_mm[i]);
        for (int i = 0; i < 3; i++)
            camera->eye_mm[i] =
                camera->look_mm[i] + more / distance * (camera->eye_mm[i] - camera->look_mm[i]);
        camera->ortho_height_mm = 0.0;
        camera->fov_deg = 2.0 * atan(0.5 * height_mm / more) * 180.0 / M_PI;
        against_exact(f.renderer, f.volume, &f.scene, "far away");
        f.quality.cells_integration = VR_CELLS_EXACT;
        render(f.renderer, &f.scene, &f.quality, &image, NULL);
        assert_int_equal(brick_image_compare(&image, &want, &d, NULL), 0);
        print_message("%g sizes away, to the parallel picture: %.2g\n", times, d.max_abs);
        assert_true(d.max_abs < size_mm / times + CELLS_ROUNDING);
        brick_image_finish(&image);
        brick_image_finish(&want);
    }
    fixture_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_eye),
        cmocka_unit_test(test_far),
    };
    return cmocka_run_group_tests_name("cells_perspective", tests, NULL, NULL);
}
