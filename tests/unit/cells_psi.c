/* Partial pre-integration against adaptive quadrature that shares nothing with it, and against closed forms.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "psi.h"

struct depths {
    long double front, back;
};

static long double transmittance(const struct depths *d, long double x)
{
    return expl(-x * (d->front + 0.5L * (d->back - d->front) * x));
}

/* Adaptive Simpson. */
static long double simpson(const struct depths *d, long double a, long double b, long double fa,
                           long double fm, long double fb, long double whole, long double tolerance,
                           int levels)
{
    long double m = 0.5L * (a + b), fl = transmittance(d, 0.5L * (a + m)),
                fr = transmittance(d, 0.5L * (m + b));
    long double left = (m - a) / 6.0L * (fa + 4.0L * fl + fm), right = (b - m) / 6.0L * (fm + 4.0L * fr + fb);
    long double error = left + right - whole;
    if (levels == 0 || fabsl(error) < 15.0L * tolerance)
        return left + right + error / 15.0L;
    return simpson(d, a, m, fa, fl, fm, left, 0.5L * tolerance, levels - 1) +
           simpson(d, m, b, fm, fr, fb, right, 0.5L * tolerance, levels - 1);
}

static double quadrature(double front, double back)
{
    const struct depths d = {front, back};
    long double sum = 0.0L;
    /* From short to long, so that nothing steep near 0 is stepped over. */
    for (int i = 0; i <= 40; i++) {
        long double a = i ? ldexpl(1.0L, i - 41) : 0.0L, b = ldexpl(1.0L, i - 40);
        long double fa = transmittance(&d, a), fm = transmittance(&d, 0.5L * (a + b)),
                    fb = transmittance(&d, b);
        sum += simpson(&d, a, b, fa, fm, fb, (b - a) / 6.0L * (fa + 4.0L * fm + fb), 1e-17L, 30);
    }
    return (double)sum;
}

static void test_quadrature(void **state)
{
    static const double depths[] = {0,   1e-12, 1e-6, 1e-3, 0.03, 0.3, 0.9999, 1,   1.7, 3,
                                    7.5, 20,    45.9, 46.1, 91,   93,  400,    2e3, 1e5, 1e7};
    const int n = sizeof depths / sizeof *depths;
    double worst = 0.0;
    (void)state;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            worst = fmax(worst, fabs(vr_psi(depths[i], depths[j]) - quadrature(depths[i], depths[j])));
    print_message("psi: worst difference to quadrature %.2g\n", worst);
    assert_true(worst < 1e-14);
}

static void test_closed_forms(void **state)
{
    (void)state;
    assert_true(vr_psi(0.0, 0.0) == 1.0);
    for (double a = 1e-6; a < 1e6; a *= 3.7) {
        double rising = sqrt(M_PI / (2.0 * a)) * erf(sqrt(0.5 * a));
        assert_true(fabs(vr_psi(a, a) - -expm1(-a) / a) < 1e-14);
        assert_true(fabs(vr_psi(0.0, a) - rising) < 1e-14);
    }
    assert_true(vr_psi(INFINITY, 1.0) == 0.0 && vr_psi(1.0, INFINITY) == 0.0);
}

/* Read bilinearly as the shader does, half way between the table's places, where the error is largest: of
 * second order where psi is smooth; towards infinite depth, where it goes like a root, it is not. */
static void test_table(void **state)
{
    enum { N = 512 };
    static float table[N * N];
    double worst = 0.0, worst_deep = 0.0;
    (void)state;
    vr_psi_table(table, N);
    for (int j = 0; j < N - 1; j++)
        for (int i = 0; i < N - 1; i++) {
            const float *t = table + j * N + i;
            double front = (i + 0.5) / (N - 1 - (i + 0.5)), back = (j + 0.5) / (N - 1 - (j + 0.5));
            double read = 0.25 * ((double)t[0] + (double)t[1] + (double)t[N] + (double)t[N + 1]);
            double error = fabs(read - vr_psi(front, back));
            *(front < 16.0 && back < 16.0 ? &worst : &worst_deep) =
                fmax(front < 16.0 && back < 16.0 ? worst : worst_deep, error);
        }
    print_message("psi: the table is off by %.2g, beyond a depth of 16 by %.2g\n", worst, worst_deep);
    assert_true(worst < 2e-5);
    assert_true(worst_deep < 0.03);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quadrature),
        cmocka_unit_test(test_closed_forms),
        cmocka_unit_test(test_table),
    };
    return cmocka_run_group_tests_name("cells_psi", tests, NULL, NULL);
}
