/* The walk from cell to cell: nothing skipped, nothing twice, whatever the ray runs through; and whole rays
 * through random volumes against the reference. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "memory_cells.h"
#include "trace.h"

#define TOLERANCE 1e-10

/* dvr; a vr_trace whose result is the integral. */
static int march(struct memory_cells *m, const struct brick_transfer *transfer, const struct brick_ray *ray,
                 double enter, double leave, double tolerance, struct vr_ray_integral *integral)
{
    const struct vr_look look = {.mode = BRICK_MODE_DVR, .transfer = transfer, .tolerance = tolerance};
    struct vr_traced traced;
    int result = vr_trace(&look, &m->cells, ray, enter, leave, &traced, NULL);
    *integral = traced.light;
    return result;
}

static const struct brick_grid grid = {.dims = {NX, NY, NZ}};

static void near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance))
        fail_msg("%.17g is not %.17g: %.3g off, %.3g allowed", a, b, a - b, tolerance);
}

/* In a volume of one extinction, alpha tells the length that was walked. */
static void every_ray_is_covered_once(void **state)
{
    struct brick_transfer_knot knot = {0.0, 1.0, 0.5, 0.25, 0.125};
    const struct brick_transfer t = {.knots = &knot, .count = 1};
    struct brick_ray *rays = malloc(MAX_AWKWARD * sizeof *rays);
    struct memory_cells m;
    unsigned long long seed = 5;
    size_t hits = 0, count;
    (void)state;
    assert_non_null(rays);
    count = awkward_rays(rays);
    assert_true(count <= MAX_AWKWARD);
    for (size_t i = 0; i < count + 20000; i++) {
        struct brick_ray random, *ray = i < count ? &rays[i] : &random;
        struct vr_ray_integral integral = {0};
        double enter, leave;
        for (int a = 0; a < 3 && i >= count; a++) {
            double target = (reference_random(&seed) * 1.2 - 0.1) * (double)grid.dims[a] - 0.5;
            random.origin[a] = reference_random(&seed) * 14.0 - 4.0;
            random.direction[a] = 0.1 * (target - random.origin[a]);
        }
        fill(&m, 1);
        if (!brick_ray_span(ray, &grid, &enter, &leave))
            continue;
        hits++;
        assert_int_equal(march(&m, &t, ray, enter, leave, 1e-13, &integral), BRICK_OK);
        near(integral.depth, fmin(0.125 * (leave - enter), -log(1e-15)), 1e-14 * (1.0 + leave));
        assert_true(m.loads <= NX + NY + NZ + 3);
        assert_int_equal(m.jumps, 0);
    }
    assert_true(hits > 5000);
    free(rays);
}

static double difference(const struct reference *r, const struct vr_ray_integral *ray)
{
    double worst = fabs((double)(expl(-r->depth) - expl(-(long double)ray->depth)));
    for (int c = 0; c < 3; c++)
        worst = fmax(worst, fabs((double)(r->rgb[c] - ray->rgb[c])));
    return worst;
}

/* Extinction on narrow tents and steps over values in [0,1]. */
static const struct brick_transfer_knot tents[] = {
    {0.1, 0.9, 0.0, 0.1, 0.0}, {0.2, 0.1, 0.7, 0.2, 0.9}, {0.3, 0.5, 0.5, 0.9, 0.0},
    {0.5, 0.0, 1.0, 0.0, 0.0}, {0.5, 1.0, 0.0, 0.0, 4.0}, {0.6, 0.2, 0.2, 1.0, 0.3},
    {0.6, 0.3, 0.9, 0.2, 0.1}, {0.9, 1.0, 1.0, 1.0, 2.5},
};

static void random_volumes(void **state)
{
    const struct brick_transfer t = {.knots = (struct brick_transfer_knot *)(uintptr_t)tents,
                                     .count = sizeof tents / sizeof tents[0]};
    unsigned long long seed = 17;
    double worst = 0.0;
    int hits = 0;
    (void)state;
    for (int round = 0; round < 120; round++) {
        struct memory_cells m;
        struct brick_ray ray;
        struct vr_ray_integral integral = {0};
        double enter, leave;
        fill(&m, (unsigned long long)round);
        if (round % 4 == 3) /* a coarser level: the same box, other samples */
            for (int i = 0; i < 3; i++) {
                m.cells.scale[i] = 2.0;
                m.cells.offset[i] = 0.5;
            }
        struct brick_grid box = {.dims = {(uint64_t)(NX * m.cells.scale[0]),
                                          (uint64_t)(NY * m.cells.scale[1]),
                                          (uint64_t)(NZ * m.cells.scale[2]) - (uint64_t)(round % 8 == 7)}};
        for (int i = 0; i < 3; i++) {
            ray.origin[i] = reference_random(&seed) * 12.0 - 4.0;
            ray.direction[i] = (reference_random(&seed) * 5.0 - ray.origin[i]) * 0.3;
            if (round % 5 == i)
                ray.direction[i] = 0.0;
        }
        if (!brick_ray_span(&ray, &box, &enter, &leave))
            continue;
        hits++;
        assert_int_equal(march(&m, &t, &ray, enter, leave, TOLERANCE, &integral), BRICK_OK);
        struct reference_volume v = volume_of(&m);
        struct reference r = reference_ray(&v, &t, &ray, enter, leave, 400);
        worst = fmax(worst, difference(&r, &integral));
    }
    print_message("%d rays, largest difference from the reference: %.2g\n", hits, worst);
    assert_true(hits > 60);
    near(worst, 0.0, TOLERANCE);
}

/* In faces, along edges and through corners, where the field's value is the same from every side. */
static void awkward_rays_are_right(void **state)
{
    const struct brick_transfer t = {.knots = (struct brick_transfer_knot *)(uintptr_t)tents,
                                     .count = sizeof tents / sizeof tents[0]};
    struct brick_ray *rays = malloc(MAX_AWKWARD * sizeof *rays);
    struct memory_cells m;
    double worst = 0.0;
    (void)state;
    assert_non_null(rays);
    size_t count = awkward_rays(rays);
    fill(&m, 99);
    for (size_t i = 0; i < count; i += 5) { /* no multiple of any pattern in the list */
        struct vr_ray_integral integral = {0};
        double enter, leave;
        if (!brick_ray_span(&rays[i], &grid, &enter, &leave))
            continue;
        assert_int_equal(march(&m, &t, &rays[i], enter, leave, TOLERANCE, &integral), BRICK_OK);
        struct reference_volume v = volume_of(&m);
        struct reference r = reference_ray(&v, &t, &rays[i], enter, leave, 200);
        worst = fmax(worst, difference(&r, &integral));
    }
    print_message("largest difference from the reference: %.2g\n", worst);
    near(worst, 0.0, TOLERANCE);
    free(rays);
}

/* Straight on: a million samples by Simpson's rule, with nothing clever about cells or knots. */
static void brute_force(void **state)
{
    struct brick_transfer_knot knots[3] = {
        {0.0, 0.1, 0.9, 0.5, 0.0}, {0.4, 0.8, 0.1, 0.5, 0.2}, {1.0, 0.2, 0.3, 1.0, 1.5}};
    const struct brick_transfer t = {.knots = knots, .count = 3};
    const struct brick_ray ray = {{-2.0, 0.3, 6.0}, {0.6, 0.25, -0.55}};
    enum { SAMPLES = 1000000 };
    struct memory_cells m;
    struct vr_ray_integral integral = {0};
    double enter, leave;
    (void)state;
    fill(&m, 23);
    assert_true(brick_ray_span(&ray, &grid, &enter, &leave));
    assert_int_equal(march(&m, &t, &ray, enter, leave, TOLERANCE, &integral), BRICK_OK);

    struct reference_volume v = volume_of(&m);
    v.ray = &ray;
    struct reference r = {.field = reference_field, .context = &v, .transfer = &t};
    long double h = ((long double)leave - enter) / SAMPLES, rgb[3], depth = 0.0L, sum[3] = {0.0L};
    long double before = reference_classify(&r, enter, rgb);
    for (int i = 0; i <= SAMPLES; i += 2) {
        long double sigma = reference_classify(&r, enter + i * h, rgb), mid_rgb[3];
        if (i > 0) { /* sigma at i - 2, i - 1 and i: depth at i - 1 by the parabola through them */
            long double mid = reference_classify(&r, enter + (i - 1) * h, mid_rgb);
            long double mid_depth = depth + h * (5.0L * before + 8.0L * mid - sigma) / 12.0L;
            depth += h * (before + 4.0L * mid + sigma) / 3.0L;
            for (int c = 0; c < 3; c++)
                sum[c] += 4.0L * mid_rgb[c] * mid * expl(-mid_depth);
        }
        for (int c = 0; c < 3; c++)
            sum[c] += (i == 0 || i == SAMPLES ? 1.0L : 2.0L) * rgb[c] * sigma * expl(-depth);
        before = sigma;
    }
    /* Kinks at faces and knots cost up to slope * h^2 / 6 each: h is 7e-6, there are below 60, slopes
     * below 4. */
    near(integral.depth, (double)depth, 60 * 4 * (double)(h * h) / 6);
    for (int c = 0; c < 3; c++)
        near(integral.rgb[c], (double)(sum[c] * h / 3.0L), 60 * 4 * (double)(h * h) / 6);
}

/* Cells with a voxel that is not finite are transparent, all of them and only they. */
static void not_finite_is_transparent(void **state)
{
    struct brick_transfer_knot knot = {0.0, 1.0, 1.0, 1.0, 0.5};
    const struct brick_transfer t = {.knots = &knot, .count = 1};
    const struct brick_ray near_it = {{-3.0, 1.5, 2.5}, {1.0, 0.0, 0.0}},
                           beside = {{-3.0, 2.5, 3.5}, {1.0, 0.0, 0.0}};
    struct memory_cells m;
    struct vr_ray_integral a = {0}, b = {0};
    (void)state;
    fill(&m, 2);
    m.voxels[(2 * NY + 1) * NX + 2] = NAN; /* cells 1 and 2 along x */
    assert_int_equal(march(&m, &t, &near_it, 2.5, 7.5, TOLERANCE, &a), BRICK_OK);
    assert_int_equal(march(&m, &t, &beside, 2.5, 7.5, TOLERANCE, &b), BRICK_OK);
    near(a.depth, 0.5 * 3.0, 1e-14);
    near(b.depth, 0.5 * 5.0, 1e-14);
}

/* Where nothing shines through any more the walk ends, and what it leaves out is below the tolerance. */
static void opaque_rays_end_early(void **state)
{
    struct brick_transfer_knot knot = {0.0, 1.0, 0.5, 0.25, 1e4};
    const struct brick_transfer t = {.knots = &knot, .count = 1};
    const struct brick_ray ray = {{-3.0, 1.5, 2.5}, {1.0, 0.0, 0.0}};
    struct memory_cells m;
    struct vr_ray_integral integral = {0};
    (void)state;
    fill(&m, 2);
    assert_int_equal(march(&m, &t, &ray, 2.5, 7.5, TOLERANCE, &integral), BRICK_OK);
    assert_int_equal(m.loads, 1);
    near(integral.rgb[0], 1.0, TOLERANCE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_ray_is_covered_once), cmocka_unit_test(random_volumes),
        cmocka_unit_test(awkward_rays_are_right),    cmocka_unit_test(brute_force),
        cmocka_unit_test(not_finite_is_transparent), cmocka_unit_test(opaque_rays_end_early),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
