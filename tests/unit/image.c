/* Pictures and their difference. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <brick/image.h>

static void sizes_are_checked(void **state)
{
    struct brick_image image;
    (void)state;
    assert_int_equal(brick_image_init(&image, 0, 4, NULL), BRICK_ERR_ARGUMENT);
    assert_int_equal(brick_image_init(&image, 4, BRICK_IMAGE_MAX_DIM + 1, NULL), BRICK_ERR_ARGUMENT);
    assert_null(image.rgba);
    assert_int_equal(brick_image_init(&image, 3, 2, NULL), BRICK_OK);
    for (int i = 0; i < 24; i++)
        assert_true(image.rgba[i] == 0.0f);
    brick_image_finish(&image);
    assert_null(image.rgba);
}

static void difference_is_by_definition(void **state)
{
    struct brick_image a, b, c;
    struct brick_image_difference d;
    (void)state;
    assert_int_equal(brick_image_init(&a, 3, 2, NULL), BRICK_OK);
    assert_int_equal(brick_image_init(&b, 3, 2, NULL), BRICK_OK);
    assert_int_equal(brick_image_init(&c, 2, 3, NULL), BRICK_OK);
    assert_int_equal(brick_image_compare(&a, &c, &d, NULL), BRICK_ERR_ARGUMENT);

    assert_int_equal(brick_image_compare(&a, &b, &d, NULL), BRICK_OK);
    assert_true(d.max_abs == 0.0 && d.rmse == 0.0 && isinf(d.psnr_db) && d.psnr_db > 0.0);
    assert_int_equal(d.pixels_differing, 0);

    a.rgba[(1 * 3 + 2) * 4 + 1] = 0.5f; /* column 2, row 1, green */
    a.rgba[(1 * 3 + 2) * 4 + 3] = 0.25f;
    b.rgba[0] = 0.25f;
    assert_int_equal(brick_image_compare(&a, &b, &d, NULL), BRICK_OK);
    assert_true(d.max_abs == 0.5);
    assert_int_equal(d.max_x, 2);
    assert_int_equal(d.max_y, 1);
    assert_int_equal(d.max_channel, 1);
    assert_int_equal(d.pixels_differing, 2);
    assert_int_equal(d.covered_only_a, 1);
    assert_int_equal(d.covered_only_b, 0);
    assert_true(fabs(d.rmse - sqrt((0.25 + 0.0625 + 0.0625) / 24.0)) < 1e-16);
    assert_true(fabs(d.psnr_db + 20.0 * log10(d.rmse)) < 1e-12);

    a.rgba[5] = b.rgba[5] = NAN; /* the same NaN in both */
    assert_int_equal(brick_image_compare(&a, &b, &d, NULL), BRICK_OK);
    assert_true(d.max_abs == 0.5);
    b.rgba[6] = NAN;
    b.rgba[3] = b.rgba[7] = b.rgba[(1 * 3 + 2) * 4 + 3] = 1.0f;
    assert_int_equal(brick_image_compare(&a, &b, &d, NULL), BRICK_OK);
    assert_int_equal(d.covered_only_a, 0);
    assert_int_equal(d.covered_only_b, 2);
    assert_true(isinf(d.max_abs) && isinf(d.rmse));
    brick_image_finish(&a);
    brick_image_finish(&b);
    brick_image_finish(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_are_checked),
        cmocka_unit_test(difference_is_by_definition),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
