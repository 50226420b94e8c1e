/* Ranges of level 0 that travel up the pyramid are those of the converted voxels, because bricks overlap and
 * what a lossy codec makes of a voxel differs from brick to brick. The codec's tolerance holds for each of
 * them, so ranges widened by it cover them all. */
#include "lossy.h"

#include <float.h>
#include <math.h>
#include <string.h>

static void widen_f32(float *lo, float *hi, double tolerance)
{
    if (!(*lo <= *hi))
        return;
    float below = nextafterf((float)((double)*lo - tolerance), -INFINITY),
          above = nextafterf((float)((double)*hi + tolerance), INFINITY);
    *lo = below > -FLT_MAX ? below : -FLT_MAX;
    *hi = above < FLT_MAX ? above : FLT_MAX;
}

static const struct {
    double lowest, highest;
} limits[] = {
    [BRICK_U8] = {0, 255}, [BRICK_I8] = {-128, 127}, [BRICK_U16] = {0, 65535}, [BRICK_I16] = {-32768, 32767}};

void lossy_widen(enum brick_type type, void *lo, void *hi, size_t n, double tolerance)
{
    if (tolerance == 0.0)
        return;
    switch (type) {
#define CASE(TYPE, T)                                                                                        \
    case TYPE:                                                                                               \
        for (size_t i = 0; i < n; i++) {                                                                     \
            T *l = (T *)lo + i, *h = (T *)hi + i;                                                            \
            *l = (T)fmax((double)*l - tolerance, limits[TYPE].lowest);                                       \
            *h = (T)fmin((double)*h + tolerance, limits[TYPE].highest);                                      \
        }                                                                                                    \
        break;
        CASE(BRICK_U8, uint8_t)
        CASE(BRICK_I8, int8_t)
        CASE(BRICK_U16, uint16_t)
        CASE(BRICK_I16, int16_t)
#undef CASE
    default:
        for (size_t i = 0; i < n; i++)
            widen_f32((float *)lo + i, (float *)hi + i, tolerance);
        break;
    }
}

void lossy_widen_value(enum brick_type type, float range[2], double tolerance)
{
    if (tolerance == 0.0)
        return;
    if (type == BRICK_F32) {
        widen_f32(&range[0], &range[1], tolerance);
        return;
    }
    range[0] = (float)fmax((double)range[0] - tolerance, limits[type].lowest);
    range[1] = (float)fmin((double)range[1] + tolerance, limits[type].highest);
}

bool lossy_agree(enum brick_type type, const void *a, const void *b, size_t n, double tolerance)
{
    size_t width = brick_type_bytes(type);
    if (memcmp(a, b, n * width) == 0)
        return true;
    /* A difference of two f32 may be rounded in double, by less than this. */
    double most = 2.0 * tolerance * (1.0 + 0x1p-50);
    for (size_t i = 0; tolerance > 0.0 && i < n; i++)
        if (memcmp((const char *)a + i * width, (const char *)b + i * width, width) != 0 &&
            !(fabs(brick_type_load(type, a, i) - brick_type_load(type, b, i)) <= most))
            return false;
    return tolerance > 0.0;
}
