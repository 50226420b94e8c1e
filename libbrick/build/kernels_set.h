/* All kernels for one instruction set. No include guard: included once a set by kernels.c with SET, its name,
 * and TARGET, the attribute that lets the compiler use it. */

#define PASTE3_(f, t, s) f##_##t##_##s
#define PASTE3(f, t, s)  PASTE3_(f, t, s)
#define PASTE2_(f, s)    f##_##s
#define PASTE2(f, s)     PASTE2_(f, s)
#define TEXT_(s)         #s
#define TEXT(s)          TEXT_(s)

#define T                             uint8_t
#define NAME(f)                       PASTE3(f, u8, SET)
#define FINITE(v, e)                  (v)
#define LOWEST                        0
#define HIGHEST                       UINT8_MAX
#define MEAN8(a, b, c, d, e, f, g, h) (uint8_t) eighth((int32_t)(a) + b + c + d + e + f + g + h)
#include "kernels_typed.h"
#define T                             int8_t
#define NAME(f)                       PASTE3(f, i8, SET)
#define FINITE(v, e)                  (v)
#define LOWEST                        INT8_MIN
#define HIGHEST                       INT8_MAX
#define MEAN8(a, b, c, d, e, f, g, h) (int8_t) eighth((int32_t)(a) + b + c + d + e + f + g + h)
#include "kernels_typed.h"
#define T                             uint16_t
#define NAME(f)                       PASTE3(f, u16, SET)
#define FINITE(v, e)                  (v)
#define LOWEST                        0
#define HIGHEST                       UINT16_MAX
#define MEAN8(a, b, c, d, e, f, g, h) (uint16_t) eighth((int32_t)(a) + b + c + d + e + f + g + h)
#include "kernels_typed.h"
#define T                             int16_t
#define NAME(f)                       PASTE3(f, i16, SET)
#define FINITE(v, e)                  (v)
#define LOWEST                        INT16_MIN
#define HIGHEST                       INT16_MAX
#define MEAN8(a, b, c, d, e, f, g, h) (int16_t) eighth((int32_t)(a) + b + c + d + e + f + g + h)
#include "kernels_typed.h"
#define T                             float
#define NAME(f)                       PASTE3(f, f32, SET)
#define FINITE(v, e)                  (isfinite(v) ? (v) : (e))
#define LOWEST                        (-INFINITY)
#define HIGHEST                       INFINITY
#define MEAN8(a, b, c, d, e, f, g, h) mean_finite(a, b, c, d, e, f, g, h)
#include "kernels_typed.h"

TARGET static void PASTE2(sum_f32, SET)(double sum[8], const float *row, size_t n)
{
    size_t i = 0;
    for (; i + 8 <= n; i += 8)
        for (size_t k = 0; k < 8; k++)
            sum[k] += isfinite(row[i + k]) ? (double)row[i + k] : 0.0;
    for (; i < n; i++)
        sum[i % 8] += isfinite(row[i]) ? (double)row[i] : 0.0;
}

TARGET static void PASTE2(squares_f32, SET)(double sum[8], const float *row, size_t n, double mean)
{
    size_t i = 0;
    for (; i + 8 <= n; i += 8)
        for (size_t k = 0; k < 8; k++) {
            double d = isfinite(row[i + k]) ? (double)row[i + k] - mean : 0.0;
            sum[k] += d * d;
        }
    for (; i < n; i++) {
        double d = isfinite(row[i]) ? (double)row[i] - mean : 0.0;
        sum[i % 8] += d * d;
    }
}

#define ROW(f)                                                                                               \
    {                                                                                                        \
        PASTE3(f, u8, SET), PASTE3(f, i8, SET), PASTE3(f, u16, SET), PASTE3(f, i16, SET),                    \
            PASTE3(f, f32, SET)                                                                              \
    }
static const struct kernels PASTE2(kernels, SET) = {
    .name = TEXT(SET),
    .fold = ROW(fold),
    .mean_pairs = ROW(mean_pairs),
    .range_pairs = ROW(range_pairs),
    .sum_f32 = PASTE2(sum_f32, SET),
    .squares_f32 = PASTE2(squares_f32, SET),
};

#undef ROW
#undef PASTE3_
#undef PASTE3
#undef PASTE2_
#undef PASTE2
#undef TEXT_
#undef TEXT
#undef SET
#undef TARGET
