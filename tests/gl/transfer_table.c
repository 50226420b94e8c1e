/* The transfer function's float32 table, looked up as the shader does, against the function itself. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "gl_scene.h"
#include "transfer_table.h"

static void look_up(const struct vr_transfer_table *t, float v, double rgb[3], double *sigma)
{
    float offset = v - t->bin_origin;
    const struct vr_bin *bin =
        &t->bins[(uint32_t)fminf(fmaxf(offset * t->bin_scale, 0.0f), (float)(t->bin_count - 1))];
    uint32_t low = bin->first, high = bin->last;
    for (uint32_t i = 0; i < t->search_steps; i++) {
        uint32_t middle = (low + high + 1) / 2;
        if (v >= t->pieces[middle].start)
            low = middle;
        else if (middle > low)
            high = middle - 1;
    }
    const struct vr_piece *p = &t->pieces[low];
    for (int c = 0; c < 3; c++)
        rgb[c] = (double)(p->rgb[c] + p->rgb_slope[c] * (v - p->origin));
    *sigma = fmax(0.0, (double)(p->sigma + p->sigma_slope * (v - p->origin)));
}

static void check(double slope, double intercept, const struct brick_transfer_point *points, size_t count)
{
    struct brick_grid grid = {.slope = slope, .intercept = intercept};
    struct brick_transfer *transfer = transfer_of(points, count);
    struct vr_transfer_table table;
    double lo = points[0].value - 10, hi = points[count - 1].value + 10;
    assert_int_equal(vr_transfer_table_init(&table, transfer, &grid, NULL), 0);
    for (int i = 0; i < 200000; i++) {
        /* Every other value is at a knot or next to it. */
        double value = lo + (hi - lo) * (i / 200000.0), rgb[3], want_rgb[3], sigma, want;
        if (i & 1)
            value = transfer->knots[(size_t)(i >> 1) % transfer->count].value;
        float v = (float)((value - intercept) / fabs(slope));
        if (i & 1)
            for (int n = (i >> 1) % 7 - 3; n; n += n < 0 ? 1 : -1)
                v = nextafterf(v, n < 0 ? -FLT_MAX : FLT_MAX);
        brick_transfer_eval(transfer, fabs(slope) * (double)v + intercept, want_rgb, &want);
        look_up(&table, v, rgb, &sigma);
        /* A difference of float32 numbers as large as the values, times the steepest piece, and the rest. */
        double slack = 1e-6 * (1.0 + want);
        if (want == 0.0 && sigma != 0.0)
            fail_msg("value %.9g is transparent but has extinction %g", (double)v, sigma);
        if (!(fabs(sigma - want) <= slack) || !(fabs(rgb[0] - want_rgb[0]) <= slack) ||
            !(fabs(rgb[1] - want_rgb[1]) <= slack) || !(fabs(rgb[2] - want_rgb[2]) <= slack))
            fail_msg("value %.9g: rgb %g %g %g sigma %g, not %g %g %g %g", (double)v, rgb[0], rgb[1], rgb[2],
                     sigma, want_rgb[0], want_rgb[1], want_rgb[2], want);
    }
    vr_transfer_table_finish(&table);
    brick_transfer_destroy(&transfer);
}

static void test_table(void **state)
{
    (void)state;
    static const struct brick_transfer_point smooth[] = {{-1200, 0.2, 0.9, 0.1, 0.05},
                                                         {-300, 0.5, 0.1, 1.0, 0.0},
                                                         {100, 1, 1, 1, 0.0},
                                                         {900, 0.9, 0.5, 0.1, 1.0}};
    static const struct brick_transfer_point jumps[] = {
        {0.1, 0, 0, 0, 0}, {0.1, 1, 1, 0, 0.5}, {0.7, 1, 1, 0, 0.5}, {0.7, 0, 0, 1, 0.0}, {0.9, 0, 0, 1, 0}};
    static const struct brick_transfer_point one[] = {{5, 0.5, 0.25, 1, 0.3}};
    check(1, 0, smooth, 4);
    check(-0.7, 12.3, smooth, 4);
    check(0.1, 0, jumps, 5);
    check(1, 0, jumps, 5);
    check(3, 1, one, 1);
}

/* Comparing with the threshold is comparing physical values. */
static void test_threshold(void **state)
{
    (void)state;
    static const double slopes[] = {1, -1, 0.1, 3e-20, -7e10}, values[] = {0.3, 300, -1e-30, 1e20, 0};
    for (size_t s = 0; s < 5; s++)
        for (size_t i = 0; i < 5; i++) {
            struct brick_grid grid = {.slope = slopes[s], .intercept = s == 1 ? 0.7 : 0.0};
            float t = vr_stored_threshold(&grid, values[i]);
            if (isfinite(t))
                assert_true(fabs(grid.slope) * (double)t + grid.intercept >= values[i]);
            if (t > -FLT_MAX)
                assert_true(fabs(grid.slope) * (double)nextafterf(t, -INFINITY) + grid.intercept < values[i]);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_table),
        cmocka_unit_test(test_threshold),
    };
    return cmocka_run_group_tests_name("transfer_table", tests, NULL, NULL);
}
