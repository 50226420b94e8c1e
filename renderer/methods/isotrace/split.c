/* A comparison of stored values that says exactly what comparing physical ones in double would.
 *
 * slope * s + intercept, rounded, ascends (or, with a negative slope, descends) with s. So "physical >=
 * isovalue" changes once as s ascends, and bisection over all values of the type finds where. For f32 these
 * are the floats in their order, counted by their bits. */
#include "split.h"

#include <math.h>
#include <string.h>

/* The float of rank k in their order; rank 0 is 0. */
static float float_of_rank(int64_t k)
{
    uint32_t bits = k < 0 ? (uint32_t)-k | UINT32_C(0x80000000) : (uint32_t)k;
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

void vr_iso_split(const struct brick_grid *grid, struct vr_iso_level *level)
{
    static const int64_t lowest[BRICK_TYPE_STORED_COUNT] = {0, -128, 0, -32768, -0x7f7fffff};
    static const int64_t highest[BRICK_TYPE_STORED_COUNT] = {255, 127, 65535, 32767, 0x7f7fffff};
    bool real = grid->type == BRICK_F32;
    int64_t lo = lowest[grid->type], hi = highest[grid->type] + 1; /* the split is in [lo, hi] */
    while (lo < hi) {
        int64_t middle = lo + (hi - lo) / 2;
        double stored = real ? (double)float_of_rank(middle) : (double)middle;
        bool above = grid->slope * stored + grid->intercept >= level->isovalue;
        if (above == (grid->slope > 0.0))
            hi = middle;
        else
            lo = middle + 1;
    }
    level->split = real ? float_of_rank(lo) : (float)lo; /* rank 0x7f800000 is infinity: no value is beyond */
    level->split_int = real ? 0 : (int32_t)lo;
}
