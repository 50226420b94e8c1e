/* The kernels: kernel_typed.h for each stored type, plain and tiled. */
#include "walk.h"

#include <math.h>
#include <stddef.h>

/* Half of f(p + e) - f(p - e) for the trilinear field, e a step of `axis`, u and v those of the other two
 * axes, at fractions fa, fu, fv of the cell whose first corner is at c. 0 where a neighbour is not finite. */
static inline double central(const double *c, int axis, int u, int v, double fa, double fu, double fv)
{
    double d[4];
    for (int i = 0; i < 4; i++) {
        const double *row = c + (i & 1) * u + (i >> 1) * v;
        d[i] = (row[axis] + fa * (row[2 * axis] - row[axis])) - (row[-axis] + fa * (row[0] - row[-axis]));
    }
    double low = d[0] + fu * (d[1] - d[0]), high = d[2] + fu * (d[3] - d[2]),
           g = 0.5 * (low + fv * (high - low));
    return isfinite(g) ? g : 0.0;
}

#ifdef __GNUC__
#define FETCH(p) __builtin_prefetch(p)
#else
#define FETCH(p)
#endif

#define ALWAYS(x) ((void)(x), true)

#define VOXEL      uint8_t
#define SPLIT      split_int
#define SPLIT_TYPE int32_t
#define NAME(x)    x##_u8
#define FINITE(x)  ALWAYS(x)
#include "kernel_typed.h"

#define VOXEL      int8_t
#define SPLIT      split_int
#define SPLIT_TYPE int32_t
#define NAME(x)    x##_i8
#define FINITE(x)  ALWAYS(x)
#include "kernel_typed.h"

#define VOXEL      uint16_t
#define SPLIT      split_int
#define SPLIT_TYPE int32_t
#define NAME(x)    x##_u16
#define FINITE(x)  ALWAYS(x)
#include "kernel_typed.h"

#define VOXEL      int16_t
#define SPLIT      split_int
#define SPLIT_TYPE int32_t
#define NAME(x)    x##_i16
#define FINITE(x)  ALWAYS(x)
#include "kernel_typed.h"

#define VOXEL      float
#define SPLIT      split
#define SPLIT_TYPE float
#define NAME(x)    x##_f32
#define FINITE(x)  isfinite(x)
#include "kernel_typed.h"

#define TILED

#define VOXEL      uint8_t
#define SPLIT      split_int
#define SPLIT_TYPE int32_t
#define NAME(x)    x##_u8_tiled
#define FINITE(x)  ALWAYS(x)
#include "kernel_typed.h"

#define VOXEL      int8_t
#define SPLIT      split_int
#define SPLIT_TYPE int32_t
#define NAME(x)    x##_i8_tiled
#define FINITE(x)  ALWAYS(x)
#include "kernel_typed.h"

#define VOXEL      uint16_t
#define SPLIT      split_int
#define SPLIT_TYPE int32_t
#define NAME(x)    x##_u16_tiled
#define FINITE(x)  ALWAYS(x)
#include "kernel_typed.h"

#define VOXEL      int16_t
#define SPLIT      split_int
#define SPLIT_TYPE int32_t
#define NAME(x)    x##_i16_tiled
#define FINITE(x)  ALWAYS(x)
#include "kernel_typed.h"

#define VOXEL      float
#define SPLIT      split
#define SPLIT_TYPE float
#define NAME(x)    x##_f32_tiled
#define FINITE(x)  isfinite(x)
#include "kernel_typed.h"

const struct vr_iso_kernel *vr_iso_kernel_of(enum brick_type type, bool tiled)
{
    static const struct vr_iso_kernel kernels[2][BRICK_TYPE_STORED_COUNT] = {
        {
            [BRICK_U8] = {through_u8, parts_u8, gradient_u8},
            [BRICK_I8] = {through_i8, parts_i8, gradient_i8},
            [BRICK_U16] = {through_u16, parts_u16, gradient_u16},
            [BRICK_I16] = {through_i16, parts_i16, gradient_i16},
            [BRICK_F32] = {through_f32, parts_f32, gradient_f32},
        },
        {
            [BRICK_U8] = {through_u8_tiled, parts_u8_tiled, gradient_u8_tiled},
            [BRICK_I8] = {through_i8_tiled, parts_i8_tiled, gradient_i8_tiled},
            [BRICK_U16] = {through_u16_tiled, parts_u16_tiled, gradient_u16_tiled},
            [BRICK_I16] = {through_i16_tiled, parts_i16_tiled, gradient_i16_tiled},
            [BRICK_F32] = {through_f32_tiled, parts_f32_tiled, gradient_f32_tiled},
        },
    };
    return &kernels[tiled][type];
}
