/* Gauss-Legendre quadrature of eight points on intervals of a depth of at most 2, where its error is below
 * 1e-15; beyond DEEP nothing is left to integrate. */
#include "psi.h"

#include <math.h>

#define DEEP 46.0 /* exp(-46) = 1e-20 */

static const double node[4] = {0.183434642495649804939476142360184, 0.525532409916328985817739049189246,
                               0.796666477413626739591553936475830, 0.960289856497536231683560868569473};
static const double weight[4] = {0.362683783378361982965150449277196, 0.313706645877887287337962201986601,
                                 0.222381034453374470544355994426241, 0.101228536290376259152531354309962};

double vr_psi(double front, double back)
{
    double half = 0.5 * (back - front), end = 1.0, sum = 0.0;
    if (isinf(front) || isinf(back))
        return 0.0;
    if (0.5 * (front + back) > DEEP)
        end = 2.0 * DEEP / (front + sqrt(front * front + 4.0 * half * DEEP));
    /* The steepest end times the length is at most twice the depth. */
    double steepest = fmax(front, front + 2.0 * half * end) * end;
    int intervals = 1 + (int)(0.5 * steepest);
    double h = 0.5 * end / intervals;
    for (int i = 0; i < intervals; i++) {
        double middle = (2 * i + 1) * h;
        for (int k = 0; k < 4; k++) {
            double a = middle - h * node[k], b = middle + h * node[k];
            sum += weight[k] * (exp(-a * (front + half * a)) + exp(-b * (front + half * b)));
        }
    }
    return sum * h;
}

void vr_psi_table(float *table, int n)
{
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) {
            double front = i < n - 1 ? (double)i / (n - 1 - i) : INFINITY;
            double back = j < n - 1 ? (double)j / (n - 1 - j) : INFINITY;
            table[j * n + i] = (float)vr_psi(front, back);
        }
}
