/* The integral over one segment: closed forms, and random cubics and transfer functions against the
 * reference. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "ray.h"
#include "reference.h"

#define TOLERANCE 1e-10

static struct brick_transfer from_knots(struct brick_transfer_knot *knots, size_t count)
{
    return (struct brick_transfer){.knots = knots, .count = count};
}

static struct vr_ray_integral integrate(const struct brick_transfer *t, struct vr_cubic f, double length_mm)
{
    struct vr_ray_integral ray = {.length_mm = length_mm};
    vr_ray_add(&ray, t, &f, NULL, length_mm, TOLERANCE);
    return ray;
}

static void near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance))
        fail_msg("%.17g is not %.17g: %.3g off, %.3g allowed", a, b, a - b, tolerance);
}

static void constant_slab(void **state)
{
    static const double sigma[] = {1e-300, 1e-12, 1e-3, 0.7, 30.0, 1e6, 1e300};
    (void)state;
    for (size_t i = 0; i < sizeof sigma / sizeof sigma[0]; i++) {
        struct brick_transfer_knot knot = {5.0, 0.25, 0.5, 1.0, sigma[i]};
        struct brick_transfer t = from_knots(&knot, 1);
        struct vr_ray_integral ray = integrate(&t, (struct vr_cubic){{4.0, 2.0, -3.0, 1.0}}, 2.5);
        double alpha = -expm1(-sigma[i] * 2.5);
        near(ray.depth, sigma[i] * 2.5, 1e-15 * ray.depth);
        near(ray.rgb[0], 0.25 * alpha, 1e-15 * alpha);
        near(ray.rgb[2], alpha, 1e-15 * alpha);
    }
}

/* Colour that is not scaled by extinction: C = E (1 - exp(-x)) / x, E where nothing is absorbed (Wilson et
 * al. 1994, section 2.1). */
static void independent_slab(void **state)
{
    static const double sigma[] = {0.0, 1e-300, 1e-12, 1e-3, 0.7, 30.0, 1e6};
    (void)state;
    for (size_t i = 0; i < sizeof sigma / sizeof sigma[0]; i++) {
        struct brick_transfer_knot knot = {5.0, 0.25, 0.5, 0.0, sigma[i]};
        struct brick_transfer t = from_knots(&knot, 1);
        t.emission = BRICK_EMISSION_INDEPENDENT;
        t.unit_mm = 0.5;
        struct vr_ray_integral ray = integrate(&t, (struct vr_cubic){{4.0, 2.0, -3.0, 1.0}}, 2.5);
        double x = sigma[i] * 2.5, fraction = x > 0.0 ? -expm1(-x) / x : 1.0;
        near(ray.depth, x, 1e-15 * x);
        near(ray.rgb[0], 0.25 * 5.0 * fraction, TOLERANCE);
        near(ray.rgb[1], 0.5 * 5.0 * fraction, TOLERANCE);
        near(ray.rgb[2], 0.0, 0.0);
    }
}

/* sigma = k f and colour = f over f = x: the emission has an error function in it. */
static void linear_ramp(void **state)
{
    static const double slope[] = {1e-9, 0.01, 1.0, 50.0, 1e4, 1e8};
    (void)state;
    for (size_t i = 0; i < sizeof slope / sizeof slope[0]; i++)
        for (double length = 0.01; length < 4.0; length *= 3.0) {
            double k = slope[i];
            struct brick_transfer_knot knots[2] = {{0.0, 0.0, 1.0, 0.3, 0.0}, {8.0, 1.0, 0.0, 0.3, 8.0 * k}};
            struct brick_transfer t = from_knots(knots, 2);
            struct vr_ray_integral ray = integrate(&t, (struct vr_cubic){{0.0, length, 0.0, 0.0}}, length);
            double depth = k * length * length / 2.0, alpha = -expm1(-depth);
            double emission = sqrt(M_PI / (2.0 * k)) * erf(length * sqrt(k / 2.0)) - length * exp(-depth);
            near(ray.depth, depth, 1e-14 * depth);
            near(ray.rgb[0], emission / 8.0, TOLERANCE * alpha + 1e-16);
            near(ray.rgb[1], alpha - emission / 8.0, TOLERANCE * alpha + 1e-16);
            near(ray.rgb[2], 0.3 * alpha, 1e-14 * alpha);
        }
}

/* A ramp seen from its dense end: the light dies in a thin layer at the front. */
static void falling_ramp(void **state)
{
    (void)state;
    for (double k = 1e-3; k < 1e9; k *= 10.0) {
        struct brick_transfer_knot knots[2] = {{0.0, 0.0, 1.0, 0.0, 0.0}, {1.0, 1.0, 0.0, 0.0, k}};
        struct brick_transfer t = from_knots(knots, 2);
        struct vr_ray_integral ray = integrate(&t, (struct vr_cubic){{1.0, -1.0, 0.0, 0.0}}, 1.0);
        /* with y = 1 - x, depth = k (1 - y^2) / 2 and E = 1 - integral of exp(k (y^2 - 1) / 2) dy: by its
         * series for small k, by the asymptotic one for large */
        double integral = 0.0;
        if (k < 40.0) {
            double term = exp(-k / 2.0);
            for (int n = 0; n < 200; n++, term *= k / 2.0 / n)
                integral += term / (2 * n + 1);
        } else {
            double term = 1.0 / k; /* Dawson: 1/k + 1/k^2 + 3/k^3 + 15/k^4 ... */
            for (int n = 1; n < 12; n++, term *= (2 * n - 3) / k)
                integral += term;
        }
        near(ray.rgb[0], 1.0 - integral, k < 40.0 ? TOLERANCE : fmax(TOLERANCE, 1e6 / pow(k, 7.0)));
        near(ray.rgb[0] + ray.rgb[1], -expm1(-k / 2.0), 1e-14);
    }
}

/* A box of extinction between two jumps, crossed by a cubic whose crossings are known. */
static void step_function(void **state)
{
    struct brick_transfer_knot knots[4] = {
        {0.125, 0, 1, 0, 0.0}, {0.125, 1, 1, 0, 3.0}, {0.512, 1, 1, 0, 3.0}, {0.512, 0, 0, 1, 0.5}};
    struct brick_transfer t = from_knots(knots, 4);
    (void)state;
    struct vr_ray_integral up = integrate(&t, (struct vr_cubic){{0.0, 0.0, 0.0, 1.0}}, 2.0); /* f = s^3 */
    double inside = 3.0 * 2.0 * (0.8 - 0.5), behind = 0.5 * 2.0 * (1.0 - 0.8);
    near(up.depth, inside + behind, 1e-15);
    near(up.rgb[0], -expm1(-inside), 1e-15);
    near(up.rgb[2], exp(-inside) * -expm1(-behind), 1e-15);
    struct vr_ray_integral down = integrate(&t, (struct vr_cubic){{1.0, -3.0, 3.0, -1.0}}, 2.0); /* (1-s)^3 */
    near(down.depth, inside + behind, 1e-14);
    near(down.rgb[0], exp(-behind) * -expm1(-inside), 1e-14);
    near(down.rgb[2], -expm1(-behind), 1e-14);
}

/* A constant on a jump takes the right side; one that touches it from below stays on the left. */
static void plateau_on_a_jump(void **state)
{
    struct brick_transfer_knot knots[4] = {
        {1, 0, 0, 0, 0.0}, {1, 1, 0, 0, 2.0}, {2, 1, 0, 0, 2.0}, {2, 0, 0, 0, 0.0}};
    struct brick_transfer t = from_knots(knots, 4);
    (void)state;
    near(integrate(&t, (struct vr_cubic){{1.0, 0.0, 0.0, 0.0}}, 1.0).depth, 2.0, 0.0);
    near(integrate(&t, (struct vr_cubic){{2.0, 0.0, 0.0, 0.0}}, 1.0).depth, 0.0, 0.0);
    near(integrate(&t, (struct vr_cubic){{0.0, 1.0, 0.0, 0.0}}, 1.0).depth, 0.0, 0.0);
    near(integrate(&t, (struct vr_cubic){{1.0, 1.0, 0.0, 0.0}}, 1.0).depth, 2.0, 1e-15);
    near(integrate(&t, (struct vr_cubic){{2.0, -1.0, 0.0, 0.0}}, 1.0).depth, 2.0, 1e-15);
    near(integrate(&t, (struct vr_cubic){{0.75, 1.0, -1.0, 0.0}}, 1.0).depth, 0.0, 1e-15); /* touches 1 */
    near(integrate(&t, (struct vr_cubic){{1.25, -1.0, 1.0, 0.0}}, 1.0).depth, 2.0, 1e-15);
}

static void cubic_of_a_cell_is_trilinear(void **state)
{
    unsigned long long seed = 7;
    (void)state;
    for (int round = 0; round < 1000; round++) {
        double v[8], p[3], q[3];
        for (int i = 0; i < 8; i++)
            v[i] = reference_random(&seed) * 2000.0 - 1000.0;
        for (int i = 0; i < 3; i++) {
            p[i] = reference_random(&seed);
            q[i] = round % 3 == i ? p[i] : reference_random(&seed);
        }
        struct vr_cubic f = vr_cubic_in_cell(v, p, q);
        for (int k = 0; k <= 4; k++) {
            long double s = k / 4.0L, sum = 0.0L;
            for (int i = 0; i < 8; i++) {
                long double w = 1.0L;
                for (int a = 0; a < 3; a++) {
                    long double x = p[a] + s * ((long double)q[a] - p[a]);
                    w *= i >> a & 1 ? x : 1.0L - x;
                }
                sum += w * v[i];
            }
            near(vr_cubic_eval(&f, (double)s), (double)sum, 2e-12);
        }
    }
    const double same[8] = {0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1}, p[3] = {0.3, 0.7, 0.1},
                 q[3] = {0.9, 0.2, 1.0};
    struct vr_cubic f = vr_cubic_in_cell(same, p, q);
    assert_true(f.c[0] == 0.1 && f.c[1] == 0.0 && f.c[2] == 0.0 && f.c[3] == 0.0);
}

static void roots_are_to_the_last_bits(void **state)
{
    unsigned long long seed = 11;
    double s[2];
    (void)state;
    for (int round = 0; round < 100000; round++) {
        struct vr_cubic f;
        for (int i = 0; i < 4; i++)
            f.c[i] = (reference_random(&seed) - 0.5) * pow(10.0, round % 7 == i ? -12.0 : 2.0);
        double cuts[4] = {0.0};
        int n = vr_cubic_extrema(&f, cuts + 1);
        cuts[n + 1] = 1.0;
        for (int i = 0; i <= n; i++) {
            double a = cuts[i], b = cuts[i + 1], fa = vr_cubic_eval(&f, a), fb = vr_cubic_eval(&f, b);
            double v = fa + (fb - fa) * reference_random(&seed);
            double root = vr_cubic_solve(&f, v, a, b);
            assert_true(a <= b && root >= a && root <= b);
            double slope = f.c[1] + root * (2.0 * f.c[2] + root * 3.0 * f.c[3]);
            near(vr_cubic_eval(&f, root), v, 1e-13 + 4e-16 * fabs(slope));
        }
    }
    const struct vr_cubic two = {{0.0, 0.25, -0.75, 0.5}}; /* a minimum and a maximum inside */
    int n = vr_cubic_extrema(&two, s);
    for (int i = 0; i < n; i++)
        near(two.c[1] + s[i] * (2.0 * two.c[2] + s[i] * 3.0 * two.c[3]), 0.0, 1e-15);
    assert_int_equal(n, 2);
    const struct vr_cubic line = {{1.0, 2.0, 0.0, 0.0}}, still = {{1.0, 0.0, 0.0, 0.0}},
                          bow = {{0.0, 1.0, -1.0, 0.0}};
    assert_int_equal(vr_cubic_extrema(&line, s), 0);
    assert_int_equal(vr_cubic_extrema(&still, s), 0);
    assert_int_equal(vr_cubic_extrema(&bow, s), 1);
    assert_true(s[0] == 0.5);
}

static long double cubic_field(void *context, long double s)
{
    const struct vr_cubic *f = context;
    return f->c[0] + s * (f->c[1] + s * (f->c[2] + s * (long double)f->c[3]));
}

/* Cubics of random cells through random transfer functions, with jumps in every other round. */
static void random_segments(void **state)
{
    unsigned long long seed = 3;
    double worst = 0.0;
    (void)state;
    for (int round = 0; round < 120; round++) {
        double v[8], p[3], q[3], length = pow(10.0, 2.0 * reference_random(&seed) - 1.0);
        struct brick_transfer_knot knots[10];
        double value = -0.3, dense = pow(10.0, 4.0 * reference_random(&seed) - 2.0);
        for (int i = 0; i < 8; i++)
            v[i] = reference_random(&seed);
        for (int i = 0; i < 3; i++) {
            p[i] = reference_random(&seed);
            q[i] = reference_random(&seed);
        }
        for (int i = 0; i < 10; i++) {
            value += round % 2 && i % 3 == 1 ? 0.0 : 0.3 * reference_random(&seed);
            knots[i] = (struct brick_transfer_knot){value, reference_random(&seed), reference_random(&seed),
                                                    reference_random(&seed), 0.0};
            knots[i].sigma = reference_random(&seed) < 0.3 ? 0.0 : dense * reference_random(&seed);
        }
        struct brick_transfer t = from_knots(knots, 10);
        t.emission = round % 4 < 2 ? BRICK_EMISSION_SCALED : BRICK_EMISSION_INDEPENDENT;
        t.unit_mm = 0.7;
        struct vr_cubic f = vr_cubic_in_cell(v, p, q);
        struct vr_ray_integral ray = integrate(&t, f, length);

        /* the reference runs over s: lengths go into extinction */
        struct brick_transfer_knot scaled[10];
        for (int i = 0; i < 10; i++) {
            scaled[i] = knots[i];
            scaled[i].sigma *= length;
        }
        struct brick_transfer by_s = from_knots(scaled, 10);
        struct reference r = {.field = cubic_field, .context = &f, .transfer = &by_s};
        r.glow = t.emission == BRICK_EMISSION_SCALED ? 0.0 : length / t.unit_mm;
        reference_add(&r, 0.0L, 1.0L, 1500);
        worst = fmax(worst, fabs((double)(expl(-r.depth) - expl(-(long double)ray.depth))));
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs((double)(r.rgb[c] - ray.rgb[c])));
    }
    print_message("largest difference from the reference: %.2g\n", worst);
    near(worst, 0.0, TOLERANCE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constant_slab),
        cmocka_unit_test(independent_slab),
        cmocka_unit_test(linear_ramp),
        cmocka_unit_test(falling_ramp),
        cmocka_unit_test(step_function),
        cmocka_unit_test(plateau_on_a_jump),
        cmocka_unit_test(cubic_of_a_cell_is_trilinear),
        cmocka_unit_test(roots_are_to_the_last_bits),
        cmocka_unit_test(random_segments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
