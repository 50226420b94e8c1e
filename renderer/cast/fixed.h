/* Positions along a ray in fixed point, 56 binary places: shaders/fixed.glsl for the CPU, the same numbers.
 */
#ifndef RENDERER_CAST_FIXED_H
#define RENDERER_CAST_FIXED_H

#include <math.h>
#include <stdint.h>

struct vr_fixed {
    int64_t cell;      /* the whole part */
    uint64_t fraction; /* below 2^56 */
};

#define VR_FIXED_ONE (UINT64_C(1) << 56)

static inline struct vr_fixed vr_fixed_from(double p)
{
    const int64_t near = (int64_t)p, cell = near - ((double)near > p); /* floor() can be a call */
    const int64_t fraction = (int64_t)((p - (double)cell) * 0x1p56);
    return (struct vr_fixed){cell, fraction < (int64_t)VR_FIXED_ONE /* not so just below an integer */
                                       ? (uint64_t)fraction
                                       : VR_FIXED_ONE - 1};
}

/* a + k b, exactly. */
static inline struct vr_fixed vr_fixed_after(struct vr_fixed a, struct vr_fixed b, uint32_t k)
{
    const uint64_t half = (UINT64_C(1) << 28) - 1;
    const uint64_t low = (b.fraction & half) * k, high = (b.fraction >> 28) * k + (low >> 28);
    const uint64_t fraction = a.fraction + ((high & half) << 28 | (low & half));
    return (struct vr_fixed){a.cell + b.cell * (int64_t)k + (int64_t)(high >> 28) + (int64_t)(fraction >> 56),
                             fraction & (VR_FIXED_ONE - 1)};
}

/* From `place` on, in 8.56 fixed point, which wraps around: for positions within 256 voxels of it, and for
 * steps. */
static inline uint64_t vr_fixed_near(struct vr_fixed a, int64_t place)
{
    return (uint64_t)(a.cell - place) << 56 | a.fraction;
}

#endif
