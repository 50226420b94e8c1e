/* Voxel i of a halved axis averages 2i and 2i+1 of the stored level above, clamped at the end, so an axis
 * that ends on an odd voxel counts it twice; eight values are averaged whichever axes are halved (a repeated
 * value changes no mean). The ranges of level 0 travel along: the smallest and largest value below each
 * coarse voxel. */
#include "downsample.h"

#include <math.h>

/* Sum of eight integers / 8, rounded half to even. */
static int32_t eighth(int32_t sum)
{
    int32_t q = sum >> 3, r = sum & 7; /* floor and remainder, for negative sums too */
    return q + (r > 4 || (r == 4 && (q & 1)));
}

/* Mean of the finite ones among eight, rounded once; NaN when none is. */
static float mean_finite(const float v[8])
{
    double sum = 0.0;
    int n = 0;
    for (int i = 0; i < 8; i++)
        if (isfinite(v[i])) {
            sum += (double)v[i];
            n++;
        }
    return n ? (float)(sum / n) : NAN;
}

#define SUM8(r, i, j) ((int32_t)r[0][i] + r[0][j] + r[1][i] + r[1][j] + r[2][i] + r[2][j] + r[3][i] + r[3][j])

#define T             uint8_t
#define NAME(f)       f##_u8
#define USABLE(v)     true
#define LOWEST        0
#define HIGHEST       UINT8_MAX
#define MEAN(r, i, j) (uint8_t) eighth(SUM8(r, i, j))
#include "downsample_typed.h"
#define T             int8_t
#define NAME(f)       f##_i8
#define USABLE(v)     true
#define LOWEST        INT8_MIN
#define HIGHEST       INT8_MAX
#define MEAN(r, i, j) (int8_t) eighth(SUM8(r, i, j))
#include "downsample_typed.h"
#define T             uint16_t
#define NAME(f)       f##_u16
#define USABLE(v)     true
#define LOWEST        0
#define HIGHEST       UINT16_MAX
#define MEAN(r, i, j) (uint16_t) eighth(SUM8(r, i, j))
#include "downsample_typed.h"
#define T             int16_t
#define NAME(f)       f##_i16
#define USABLE(v)     true
#define LOWEST        INT16_MIN
#define HIGHEST       INT16_MAX
#define MEAN(r, i, j) (int16_t) eighth(SUM8(r, i, j))
#include "downsample_typed.h"
#define T         float
#define NAME(f)   f##_f32
#define USABLE(v) isfinite(v)
#define LOWEST    (-INFINITY)
#define HIGHEST   INFINITY
#define MEAN(r, i, j)                                                                                        \
    mean_finite((const float[8]){r[0][i], r[0][j], r[1][i], r[1][j], r[2][i], r[2][j], r[3][i], r[3][j]})
#include "downsample_typed.h"

void downsample_row(const struct window *fine, const struct window *coarse, const bool halved[3],
                    enum brick_type type, bool nearest, uint64_t y, uint64_t z)
{
    size_t width = brick_type_bytes(type);
    const uint64_t *n = fine->level->dims;
    uint64_t at[2] = {y, z}, first[2], second[2];
    for (int a = 0; a < 2; a++) {
        first[a] = halved[a + 1] ? 2 * at[a] : at[a];
        second[a] = halved[a + 1] && first[a] + 1 < n[a + 1] ? first[a] + 1 : first[a];
    }
    const void *rows[3][4];
    const unsigned char *arrays[3] = {fine->voxels, fine->min, fine->max};
    for (int k = 0; k < 3; k++)
        for (int r = 0; r < 4; r++) {
            uint64_t sy = r & 1 ? second[0] : first[0], sz = r & 2 ? second[1] : first[1];
            rows[k][r] = arrays[k] + window_slot(fine, sz) + sy * n[0] * width;
        }
    size_t to = window_slot(coarse, z) + y * coarse->level->dims[0] * width;
    void *out = coarse->voxels + to, *min = coarse->min + to, *max = coarse->max + to;
    uint64_t coarse_n = coarse->level->dims[0];
    switch (type) {
#define CASE(TYPE, T, SUFFIX)                                                                                \
    case TYPE:                                                                                               \
        row_##SUFFIX((const T *const *)rows[0], (const T *const *)rows[1], (const T *const *)rows[2], n[0],  \
                     coarse_n, halved[0], nearest, out, min, max);                                           \
        break;
        CASE(BRICK_U8, uint8_t, u8)
        CASE(BRICK_I8, int8_t, i8)
        CASE(BRICK_U16, uint16_t, u16)
        CASE(BRICK_I16, int16_t, i16)
        CASE(BRICK_F32, float, f32)
#undef CASE
    default:
        break;
    }
}
