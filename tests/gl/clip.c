/* Clip planes in the raycaster, against the exact pictures. */
#include "cut_setting.h"

static double along_y(int x, int y, int z)
{
    (void)x, (void)z;
    return 10.0 * y;
}

/* Planes through empty space change no bit: samples stay where they are. */
static void planes_leave_samples_alone(void **state)
{
    struct setting s;
    (void)state;
    begin(&s, ball, 100.0);
    for (int run = 0; s.renderer && run < 24; run++) {
        struct brick_image whole, cut;
        s.scene.mode = (enum brick_mode)(run % 4);
        s.quality.skip = run & 4;
        if (run & 8)
            memcpy(s.scene.camera.eye_mm, (const double[]){2, 3, 5},
                   sizeof s.scene.camera.eye_mm); /* inside */
        if (run >= 16) {
            s.scene.mode = (enum brick_mode)(run % 2);
            s.quality.classification = VR_CLASSIFY_PREINTEGRATED;
        }
        s.scene.clip_count = 0;
        draw(&s, &whole);
        for (int p = 0; p < VR_MAX_CLIP_PLANES; p++)
            s.scene.clip[p] = plane_at(cos(p), sin(p), 0.3 * p - 2, 19.0 + 0.137 * p);
        s.scene.clip_count = VR_MAX_CLIP_PLANES;
        draw(&s, &cut);
        assert_true(whole.rgba[4 * (SIZE / 2 * SIZE + SIZE / 2) + 3] > 0.1f);
        assert_same_image(&cut, &whole, "planes outside what is visible");
        brick_image_finish(&whole);
        brick_image_finish(&cut);
    }
    end(&s);
}

/* Planes through what is there: the error falls as without them, by four as the step halves. */
static void planes_cut_matter(void **state)
{
    struct setting s;
    (void)state;
    begin(&s, ball, 100.0);
    s.scene.clip[0] = plane_at(1, -2, 0.5, 3.3);
    s.scene.clip[1] = plane_at(-1, 2, -0.5, 5.2);
    s.scene.clip[2] = plane_at(0, 0, 1, -1.7);
    s.scene.clip_count = 3;
    for (int mode = 0; s.renderer && mode < 2; mode++) {
        struct brick_image exact, image;
        struct brick_image_difference d;
        double rmse[4];
        s.scene.mode = (enum brick_mode)mode;
        draw_exact(&s, &exact, NULL);
        for (int i = 0; i < 4; i++) {
            s.quality.step_vox = ldexp(1.0, -i);
            draw(&s, &image);
            assert_int_equal(brick_image_compare(&image, &exact, &d, NULL), 0);
            rmse[i] = d.rmse;
            print_message("mode %d, step 1/%d: rmse %.3e, max %.3e\n", mode, 1 << i, d.rmse, d.max_abs);
            assert_int_equal(d.covered_only_a + d.covered_only_b, 0);
            brick_image_finish(&image);
        }
        /* Lit, there is no order at the ball's middle, where the gradient turns round. */
        for (int i = 1; i < 4; i++)
            assert_true(mode || (rmse[i - 1] / rmse[i] > 3.3 && rmse[i - 1] / rmse[i] < 5.0));
        assert_true(rmse[0] / rmse[3] > 36.0);
        brick_image_finish(&exact);
    }
    end(&s);
}

/* In matter that is the same everywhere only lengths count, and pieces have theirs: slabs thinner than a
 * step, wedges, half-spaces, and what is left when nothing is. */
static void lengths_are_right(void **state)
{
    struct setting s;
    (void)state;
    begin(&s, same, 100.0);
    for (int run = 0; s.renderer && run < 16; run++) {
        struct brick_image exact, image;
        struct brick_image_difference d;
        static const double thickness[] = {0.01, 0.7, 30.0, -1.0};
        s.quality.step_vox = run < 4 ? 0.5 : run < 8 ? 3.7 : run < 12 ? 100.0 : 0.5;
        if (run == 12)
            s.quality.classification = VR_CLASSIFY_PREINTEGRATED;
        s.scene.clip[0] = plane_at(1, 3, -1, 2.0);
        s.scene.clip[1] = plane_at(-1, -3, 1, thickness[run % 4] - 2.0);
        s.scene.clip[2] = plane_at(0.2, 0, 1, 7.0);
        s.scene.clip_count = 3;
        if (run == 10)
            brick_camera_orbit(&s.scene.camera, brick_volume_grid(s.volume), 0, 0, 0, 60, 1.0);
        draw(&s, &image);
        draw_exact(&s, &exact, NULL);
        assert_int_equal(brick_image_compare(&image, &exact, &d, NULL), 0);
        /* Up to 150 sums of opacities of half a unit in the last place. */
        if (!(d.max_abs <= 1e-6 + 75 * 1.2e-7))
            fail_msg("run %d: %g", run, d.max_abs);
        if (run % 4 == 3)
            for (int i = 0; i < 4 * SIZE * SIZE; i++)
                assert_true(image.rgba[i] == 0.0f);
        else
            assert_true(image.rgba[4 * (SIZE / 2 * SIZE + SIZE / 2) + 3] > 0.0001f);
        brick_image_finish(&image);
        brick_image_finish(&exact);
    }
    end(&s);
}

/* A surface across every ray, and a plane across the surface: it is there where the plane keeps it, up to
 * rounding of the field in float32. */
static void surfaces_are_cut(void **state)
{
    struct setting s;
    static double whole_mm[SIZE * SIZE];
    (void)state;
    begin(&s, along_y, 0.0);
    s.scene.mode = BRICK_MODE_ISO;
    s.scene.isovalue = 254.0;
    s.quality.step_vox = 0.8;
    brick_camera_orbit(&s.scene.camera, brick_volume_grid(s.volume), 0, 0, 0, 4, 1.0);
    if (s.renderer) {
        struct brick_image image, exact;
        int kept = 0, gone = 0;
        draw_exact(&s, &exact, whole_mm);
        brick_image_finish(&exact);
        s.scene.clip[0] = plane_at(1, 2, 0, -1.5);
        s.scene.clip_count = 1;
        draw(&s, &image);
        struct brick_view view;
        assert_int_equal(
            brick_view_init(&view, &s.scene.camera, brick_volume_grid(s.volume), SIZE, SIZE, NULL), 0);
        for (uint32_t p = 0; p < SIZE * SIZE; p++) {
            struct brick_ray ray;
            double inside = -s.scene.clip[0].offset_mm;
            brick_view_ray(&view, p % SIZE, p / SIZE, &ray);
            for (int i = 0; i < 3; i++)
                inside += s.scene.clip[0].normal[i] * (ray.origin[i] + whole_mm[p] * ray.direction[i]);
            bool hit = image.rgba[4 * p + 3] > 0.5f;
            double behind_mm = inside / 2.0; /* along y from the cut */
            assert_true(isfinite(whole_mm[p]));
            if (fabs(behind_mm) > 1e-5)
                assert_int_equal(hit, behind_mm > 0.0);
            kept += hit;
            gone += !hit;
        }
        assert_true(kept > 1000 && gone > 1000);
        brick_image_finish(&image);
    }
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes_leave_samples_alone),
        cmocka_unit_test(planes_cut_matter),
        cmocka_unit_test(lengths_are_right),
        cmocka_unit_test(surfaces_are_cut),
    };
    return cmocka_run_group_tests_name("clip", tests, NULL, NULL);
}
