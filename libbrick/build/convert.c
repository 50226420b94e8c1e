/* Wider source types become f32 only when that loses nothing, or when asked. */
#include "convert.h"

#include <math.h>
#include <stdint.h>

enum brick_type convert_stored_type(enum brick_type source)
{
    return (unsigned)source < BRICK_TYPE_STORED_COUNT ? source : BRICK_F32;
}

int convert_to_f32(enum brick_type source, const void *src, float *dst, size_t n, bool round,
                   uint64_t first_voxel, struct brick_error *err)
{
    for (size_t i = 0; i < n; i++) {
        double v = brick_type_load(source, src, i);
        float f = (float)v;
        if ((double)f != v && !isnan(v) && (!round || isinf(f)))
            return brick_fail(err, BRICK_ERR_INEXACT, "voxel %llu holds %.17g, which f32 cannot hold%s",
                              (unsigned long long)(first_voxel + i), v,
                              round ? " even rounded" : " exactly: ask for rounding with --to f32");
        dst[i] = f;
    }
    return BRICK_OK;
}
