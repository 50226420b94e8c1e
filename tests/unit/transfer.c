/* Transfer functions: the 1e-4 promise of the subdivision, jumps, support and the visibility test. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <brick/transfer.h>

static const double any_range[2] = {0.0, 1.0};

static struct brick_transfer *create(const struct brick_transfer_point *points, size_t count)
{
    struct brick_transfer_spec spec = {(struct brick_transfer_point *)(uintptr_t)points, count, 1.0,
                                       BRICK_UNIT_MM, false};
    struct brick_transfer *t = NULL;
    struct brick_error err;
    assert_int_equal(brick_transfer_create(&t, &spec, 1.0, any_range, &err), BRICK_OK);
    assert_non_null(t);
    return t;
}

static double sigma_at(const struct brick_transfer *t, double value)
{
    double rgb[3], sigma;
    brick_transfer_eval(t, value, rgb, &sigma);
    return sigma;
}

/* Every pair of opacities from a list that crowds both ends, sampled densely. */
static void pieces_are_within_1e4(void **state)
{
    static const double opacity[] = {0.0,  1e-12, 1e-6, 1e-4,  0.01,   0.1,     0.3,        0.5,
                                     0.75, 0.9,   0.99, 0.999, 0.9999, 0.99999, 1.0 - 1e-7, 1.0};
    enum { COUNT = sizeof opacity / sizeof opacity[0], SAMPLES = 20011 };
    double worst = 0.0;
    (void)state;
    for (size_t i = 0; i < COUNT; i++)
        for (size_t j = 0; j < COUNT; j++) {
            const struct brick_transfer_point points[2] = {{-3.0, 0.1, 0.2, 0.9, opacity[i]},
                                                           {4.0, 0.8, 0.2, 0.3, opacity[j]}};
            struct brick_transfer *t = create(points, 2);
            for (int k = 0; k <= SAMPLES; k++) {
                double s = (double)k / SAMPLES, rgb[3], sigma;
                brick_transfer_eval(t, -3.0 + 7.0 * s, rgb, &sigma);
                double a = opacity[i] + s * (opacity[j] - opacity[i]);
                worst = fmax(worst, fabs(-expm1(-sigma) - a));
                assert_true(fabs(rgb[0] - (0.1 + 0.7 * s)) < 1e-14);
                assert_true(fabs(rgb[2] - (0.9 - 0.6 * s)) < 1e-14);
            }
            assert_true(t->count <= 103);
            brick_transfer_destroy(&t);
        }
    assert_true(worst <= 1e-4);
    assert_true(worst > 2e-5); /* not bought with needless knots */
}

static void extinction_is_exact_at_points(void **state)
{
    const struct brick_transfer_point points[] = {{0, 0, 0, 0, 1e-15}, {1, 0, 0, 0, 0.5}, {2, 0, 0, 0, 1.0}};
    struct brick_transfer_spec spec = {(struct brick_transfer_point *)(uintptr_t)points, 3, 2.0,
                                       BRICK_UNIT_VOXEL, false};
    struct brick_transfer *t;
    (void)state;
    assert_int_equal(brick_transfer_create(&t, &spec, 0.25, any_range, NULL), BRICK_OK);
    assert_true(fabs(sigma_at(t, 0.0) - 2e-15) < 1e-27); /* the unit is half a mm */
    assert_true(fabs(sigma_at(t, 1.0) - 2.0 * log(2.0)) < 1e-15);
    assert_true(fabs(sigma_at(t, 2.0) - 48.0 * log(2.0)) < 1e-13);
    assert_true(sigma_at(t, 99.0) == sigma_at(t, 2.0));
    assert_true(sigma_at(t, -INFINITY) == sigma_at(t, 0.0));
    assert_true(sigma_at(t, NAN) == 0.0);
    assert_true(t->continuous);
    brick_transfer_destroy(&t);
    assert_null(t);
}

static void jumps_take_the_right_side(void **state)
{
    const struct brick_transfer_point points[] = {
        {1, 0.5, 0, 0, 0.0}, {1, 0.25, 0, 0, 0.5}, {2, 0.25, 0, 0, 0.5}, {2, 1, 0, 0, 0.0}};
    struct brick_transfer *t = create(points, 4);
    double rgb[3], sigma;
    (void)state;
    assert_int_equal(t->count, 4);
    assert_false(t->continuous);
    brick_transfer_eval(t, 1.0, rgb, &sigma);
    assert_true(rgb[0] == 0.25 && sigma > 0.69);
    assert_true(sigma_at(t, nextafter(1.0, 0.0)) == 0.0);
    assert_true(sigma_at(t, nextafter(2.0, 0.0)) > 0.69);
    assert_true(sigma_at(t, 2.0) == 0.0);
    assert_int_equal(t->support_count, 1);
    assert_true(t->support[0].lo == 1.0 && t->support[0].hi == 2.0);
    assert_true(brick_transfer_visible(t, 1.0, 1.0));
    assert_true(brick_transfer_visible(t, 0.0, 1.0));
    assert_false(brick_transfer_visible(t, 2.0, 2.0));
    assert_false(brick_transfer_visible(t, 2.0, 3.0));
    assert_true(brick_transfer_visible(t, nextafter(2.0, 0.0), 3.0));
    assert_false(brick_transfer_visible(t, 0.0, nextafter(1.0, 0.0)));
    brick_transfer_destroy(&t);
}

static void ramps_are_clear_at_their_zero_end(void **state)
{
    const struct brick_transfer_point points[] = {{0, 0, 0, 0, 0},   {1, 0, 0, 0, 0.5}, {2, 0, 0, 0, 0},
                                                  {3, 0, 0, 0, 0.5}, {4, 0, 0, 0, 0},   {5, 0, 0, 0, 0},
                                                  {6, 0, 0, 0, 0.1}};
    struct brick_transfer *t = create(points, 7);
    (void)state;
    assert_int_equal(t->support_count, 2);
    assert_true(t->support[0].lo == 0.0 && t->support[0].hi == 4.0);
    assert_true(t->support[1].lo == 5.0 && t->support[1].hi == INFINITY);
    assert_false(brick_transfer_visible(t, -5.0, 0.0));
    assert_true(brick_transfer_visible(t, -5.0, 1e-300));
    assert_false(brick_transfer_visible(t, 2.0, 2.0)); /* an isolated zero */
    assert_true(brick_transfer_visible(t, 2.0, nextafter(2.0, 3.0)));
    assert_true(brick_transfer_visible(t, nextafter(2.0, 1.0), 2.0));
    assert_false(brick_transfer_visible(t, 4.0, 5.0));
    assert_true(brick_transfer_visible(t, 4.0, nextafter(5.0, 6.0)));
    assert_true(brick_transfer_visible(t, 6.0, INFINITY));
    assert_true(brick_transfer_visible(t, 1e9, 1e9));
    assert_true(brick_transfer_visible(t, -INFINITY, INFINITY));
    assert_false(brick_transfer_visible(t, 3.0, 2.0)); /* empty */
    assert_false(brick_transfer_visible(t, INFINITY, -INFINITY));
    assert_false(brick_transfer_visible(t, NAN, 3.0));
    brick_transfer_destroy(&t);
}

/* Colour without extinction shows only when it does not need extinction. */
static void colour_shows_with_independent_emission(void **state)
{
    const struct brick_transfer_point points[] = {
        {0, 0, 0, 0, 0}, {1, 0, 0.5, 0, 0}, {2, 0, 0, 0, 0}, {3, 0, 0, 0, 0}, {4, 0, 0, 0, 0.5}};
    struct brick_transfer *t = create(points, 5);
    (void)state;
    assert_false(brick_transfer_visible(t, -1.0, 3.0));
    brick_transfer_set_emission(t, BRICK_EMISSION_INDEPENDENT);
    assert_int_equal(t->support_count, 2);
    assert_false(brick_transfer_visible(t, -1.0, 0.0));
    assert_true(brick_transfer_visible(t, -1.0, 0.5));
    assert_true(brick_transfer_visible(t, 1.5, 1.5));
    assert_false(brick_transfer_visible(t, 2.0, 3.0));
    assert_true(brick_transfer_visible(t, 2.0, 3.5));
    brick_transfer_set_emission(t, BRICK_EMISSION_SCALED);
    assert_false(brick_transfer_visible(t, -1.0, 3.0));
    brick_transfer_destroy(&t);
}

/* A spike between neighbouring doubles is zero at each of them, and seen by what holds both. */
static void a_spike_too_narrow_for_a_double_is_seen(void **state)
{
    const double a = nextafter(1.0, 0.0), b = 1.0;
    const struct brick_transfer_point points[] = {
        {0, 0, 0, 0, 0}, {a, 0, 0, 0, 0}, {b, 0, 0, 0, 0.5}, {b, 0, 0, 0, 0}};
    struct brick_transfer *t = create(points, 4);
    (void)state;
    assert_true(sigma_at(t, a) == 0.0 && sigma_at(t, b) == 0.0);
    assert_true(brick_transfer_visible(t, a, b));
    assert_true(brick_transfer_visible(t, 0.5, 2.0));
    assert_false(brick_transfer_visible(t, 0.5, a));
    assert_false(brick_transfer_visible(t, b, 2.0));
    brick_transfer_destroy(&t);
}

/* The visibility test against the function itself on a grid that holds every knot. */
static void visibility_agrees_with_sampling(void **state)
{
    uint32_t seed = 12345;
    (void)state;
    for (int round = 0; round < 300; round++) {
        struct brick_transfer_point points[12];
        size_t count = 1 + (seed = seed * 1664525u + 1013904223u) / 400000000u;
        double value = -4.0;
        for (size_t i = 0; i < count; i++) {
            seed = seed * 1664525u + 1013904223u;
            bool jump = seed >> 30 == 0 && i > 0 && (i < 2 || points[i - 2].value < value);
            value += jump ? 0.0 : (double)(1 + (seed >> 20) % 3);
            bool clear = (seed >> 10) % 2 == 0;
            points[i] = (struct brick_transfer_point){value, 0, 0, 0, clear ? 0.0 : 0.05};
        }
        struct brick_transfer *t = create(points, count);
        for (int lo = -24; lo < 48; lo++)
            for (int hi = lo; hi < 48; hi++) {
                bool seen = false; /* quarters: between any two grid points lies an inner sample */
                for (int k = 2 * lo; k <= 2 * hi; k++)
                    seen = seen || sigma_at(t, k / 4.0) > 0.0;
                assert_int_equal(brick_transfer_visible(t, lo / 2.0, hi / 2.0), seen);
            }
        brick_transfer_destroy(&t);
    }
}

static void one_point_is_a_constant(void **state)
{
    const struct brick_transfer_point points[] = {{7, 0.1, 0.2, 0.3, 0.5}};
    struct brick_transfer *t = create(points, 1);
    (void)state;
    assert_int_equal(t->support_count, 1);
    assert_true(t->support[0].lo == -INFINITY && t->support[0].hi == INFINITY);
    assert_true(fabs(sigma_at(t, -1e300) - log(2.0)) < 1e-15);
    brick_transfer_destroy(&t);
}

static void ranges_map_and_may_be_empty(void **state)
{
    struct brick_transfer_spec spec;
    struct brick_transfer *t;
    const double range[2] = {-100.0, 300.0}, point[2] = {5.0, 5.0}, tiny[2] = {1.0, 1.0 + 0x1p-52};
    (void)state;
    assert_int_equal(brick_transfer_builtin("gray", &spec, NULL), BRICK_OK);
    assert_int_equal(brick_transfer_create(&t, &spec, 1.0, range, NULL), BRICK_OK);
    assert_true(t->knots[0].value == -100.0 && t->knots[t->count - 1].value == 300.0);
    brick_transfer_destroy(&t);
    assert_int_equal(brick_transfer_create(&t, &spec, 1.0, point, NULL), BRICK_OK);
    assert_true(t->knots[0].value == 5.0 && t->knots[t->count - 1].value > 5.0);
    brick_transfer_destroy(&t);
    brick_transfer_spec_finish(&spec);
    assert_int_equal(brick_transfer_builtin("mri", &spec, NULL), BRICK_OK);
    assert_int_equal(brick_transfer_create(&t, &spec, 1.0, tiny, NULL), BRICK_OK);
    for (size_t i = 0; i + 2 < t->count; i++)
        assert_true(t->knots[i].value < t->knots[i + 2].value);
    brick_transfer_destroy(&t);
    brick_transfer_spec_finish(&spec);
}

static void builtins_are_continuous(void **state)
{
    static const char *const names[] = {"ct-bone", "ct-skin", "mri", "gray"};
    const double range[2] = {-1024.0, 3071.0};
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        struct brick_transfer_spec spec;
        struct brick_transfer *t;
        assert_int_equal(brick_transfer_builtin(names[i], &spec, NULL), BRICK_OK);
        assert_int_equal(brick_transfer_create(&t, &spec, 1.0, range, NULL), BRICK_OK);
        assert_true(t->continuous);
        assert_true(sigma_at(t, -1000.0) == 0.0 || spec.range_values); /* air */
        brick_transfer_destroy(&t);
        brick_transfer_spec_finish(&spec);
    }
}

static void bad_functions_are_refused(void **state)
{
    static const struct {
        struct brick_transfer_point points[3];
        size_t count;
        double unit;
    } bad[] = {
        {{{0, 0, 0, 0, 0}}, 0, 1.0},
        {{{0, 0, 0, 0, 0}}, 1, 0.0},
        {{{0, 0, 0, 0, 0}}, 1, -1.0},
        {{{0, 0, 0, 0, 0}}, 1, NAN},
        {{{0, 0, 0, 0, 0}}, 1, INFINITY},
        {{{NAN, 0, 0, 0, 0}}, 1, 1.0},
        {{{INFINITY, 0, 0, 0, 0}}, 1, 1.0},
        {{{0, 0, 0, 0, 1.5}}, 1, 1.0},
        {{{0, 0, 0, 0, -0.1}}, 1, 1.0},
        {{{0, 0, 0, 0, NAN}}, 1, 1.0},
        {{{0, 0, 2, 0, 0}}, 1, 1.0},
        {{{1, 0, 0, 0, 0}, {0, 0, 0, 0, 0}}, 2, 1.0},
        {{{1, 0, 0, 0, 0}, {1, 0, 0, 0, 0}, {1, 0, 0, 0, 0}}, 3, 1.0},
        {{{0, 0, 0, 0, 0.9}}, 1, 1e-310},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        struct brick_transfer_spec spec = {(struct brick_transfer_point *)(uintptr_t)bad[i].points,
                                           bad[i].count, bad[i].unit, BRICK_UNIT_MM, false};
        struct brick_transfer *t = NULL;
        struct brick_error err = {0};
        assert_int_equal(brick_transfer_create(&t, &spec, 1.0, any_range, &err), BRICK_ERR_ARGUMENT);
        assert_null(t);
        assert_true(strlen(err.message) > 0);
    }
    struct brick_transfer_spec spec;
    struct brick_error err;
    assert_int_equal(brick_transfer_builtin("bone", &spec, &err), BRICK_ERR_ARGUMENT);
    assert_non_null(strstr(err.message, "ct-bone"));
}

static void scaling_raises_what_gets_through_to_a_power(void **state)
{
    static const struct brick_transfer_point points[] = {{0, 1, 0, 0, 0}, {1, 0, 1, 0, 0.5}, {2, 0, 1, 0, 1}};
    struct brick_transfer *t = create(points, 3);
    double before[3] = {sigma_at(t, 0.25), sigma_at(t, 1.0), sigma_at(t, 1.75)}, rgb[3], sigma;
    (void)state;
    brick_transfer_scale(t, 2.5);
    assert_true(sigma_at(t, 0.25) == 2.5 * before[0]);
    assert_true(fabs(sigma_at(t, 1.0) - 2.5 * before[1]) < 1e-15 &&
                fabs(sigma_at(t, 1.75) - 2.5 * before[2]) < 1e-12);
    brick_transfer_eval(t, 0.5, rgb, &sigma);
    assert_true(fabs(rgb[0] - 0.5) < 1e-15);
    assert_true(brick_transfer_visible(t, 0.0, 1e-300) && !brick_transfer_visible(t, -1.0, 0.0));
    brick_transfer_destroy(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_are_within_1e4),
        cmocka_unit_test(extinction_is_exact_at_points),
        cmocka_unit_test(jumps_take_the_right_side),
        cmocka_unit_test(ramps_are_clear_at_their_zero_end),
        cmocka_unit_test(colour_shows_with_independent_emission),
        cmocka_unit_test(a_spike_too_narrow_for_a_double_is_seen),
        cmocka_unit_test(visibility_agrees_with_sampling),
        cmocka_unit_test(one_point_is_a_constant),
        cmocka_unit_test(ranges_map_and_may_be_empty),
        cmocka_unit_test(builtins_are_continuous),
        cmocka_unit_test(scaling_raises_what_gets_through_to_a_power),
        cmocka_unit_test(bad_functions_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
