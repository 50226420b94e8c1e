/* The kernels: kernel_typed.h for each stored type, plain and tiled. */
#include "walk.h"

#include <math.h>
#include <stddef.h>

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
            [BRICK_U8] = {through_u8, macrocells_u8, gradient_u8},
            [BRICK_I8] = {through_i8, macrocells_i8, gradient_i8},
            [BRICK_U16] = {through_u16, macrocells_u16, gradient_u16},
            [BRICK_I16] = {through_i16, macrocells_i16, gradient_i16},
            [BRICK_F32] = {through_f32, macrocells_f32, gradient_f32},
        },
        {
            [BRICK_U8] = {through_u8_tiled, macrocells_u8_tiled, gradient_u8_tiled},
            [BRICK_I8] = {through_i8_tiled, macrocells_i8_tiled, gradient_i8_tiled},
            [BRICK_U16] = {through_u16_tiled, macrocells_u16_tiled, gradient_u16_tiled},
            [BRICK_I16] = {through_i16_tiled, macrocells_i16_tiled, gradient_i16_tiled},
            [BRICK_F32] = {through_f32_tiled, macrocells_f32_tiled, gradient_f32_tiled},
        },
    };
    return &kernels[tiled][type];
}
