/* Kernels for one voxel type and instruction set. No include guard: included by kernels_set.h with
 *   T                the voxel type,  NAME(f) the function's name for it and the set,  TARGET its attribute,
 *   FINITE(v, e)     v where it is finite, else e,
 *   LOWEST, HIGHEST  the ends of the type (an empty range is HIGHEST, LOWEST),
 *   MEAN8(a, .. h)   their mean. */

#define MIN(a, b) ((a) < (b) ? (a) : (b))
#define MAX(a, b) ((a) > (b) ? (a) : (b))
#define LEAST(v)  FINITE(v, HIGHEST)
#define MOST(v)   FINITE(v, LOWEST)

/* Four rows at a time, so that lo and hi are loaded and stored once for the four. */
TARGET static void NAME(fold)(void *restrict lo_out, void *restrict hi_out, const void *a_in,
                              const void *b_in, size_t stride, size_t rows, size_t n)
{
    T *restrict lo = lo_out, *restrict hi = hi_out;
    const T *a = a_in, *b = b_in;
    for (size_t i = 0; i < n; i++) {
        lo[i] = LEAST(a[i]);
        hi[i] = MOST(b[i]);
    }
    size_t r = 1;
    for (; r + 4 <= rows; r += 4) {
        const T *a0 = a + r * stride, *a1 = a0 + stride, *a2 = a1 + stride, *a3 = a2 + stride;
        const T *b0 = b + r * stride, *b1 = b0 + stride, *b2 = b1 + stride, *b3 = b2 + stride;
        for (size_t i = 0; i < n; i++) {
            T least0 = MIN(LEAST(a0[i]), LEAST(a1[i])), least1 = MIN(LEAST(a2[i]), LEAST(a3[i]));
            T most0 = MAX(MOST(b0[i]), MOST(b1[i])), most1 = MAX(MOST(b2[i]), MOST(b3[i]));
            T least = MIN(least0, least1), most = MAX(most0, most1);
            lo[i] = MIN(least, lo[i]);
            hi[i] = MAX(most, hi[i]);
        }
    }
    for (; r < rows; r++) {
        const T *a0 = a + r * stride, *b0 = b + r * stride;
        for (size_t i = 0; i < n; i++) {
            T least = LEAST(a0[i]), most = MOST(b0[i]);
            lo[i] = MIN(least, lo[i]);
            hi[i] = MAX(most, hi[i]);
        }
    }
}

TARGET static void NAME(mean_pairs)(void *restrict to, const void *const rows[4], size_t n)
{
    T *restrict out = to;
    const T *r0 = rows[0], *r1 = rows[1], *r2 = rows[2], *r3 = rows[3];
    for (size_t i = 0; i < n; i++)
        out[i] = MEAN8(r0[2 * i], r0[2 * i + 1], r1[2 * i], r1[2 * i + 1], r2[2 * i], r2[2 * i + 1],
                       r3[2 * i], r3[2 * i + 1]);
}

TARGET static void NAME(range_pairs)(void *restrict lo_out, void *restrict hi_out, const void *const a[4],
                                     const void *const b[4], size_t n)
{
    T *restrict lo = lo_out, *restrict hi = hi_out;
    const T *a0 = a[0], *a1 = a[1], *a2 = a[2], *a3 = a[3];
    const T *b0 = b[0], *b1 = b[1], *b2 = b[2], *b3 = b[3];
    for (size_t i = 0; i < n; i++) {
        T e0 = MIN(LEAST(a0[2 * i]), LEAST(a1[2 * i])), e1 = MIN(LEAST(a2[2 * i]), LEAST(a3[2 * i]));
        T o0 = MIN(LEAST(a0[2 * i + 1]), LEAST(a1[2 * i + 1]));
        T o1 = MIN(LEAST(a2[2 * i + 1]), LEAST(a3[2 * i + 1]));
        T e = MIN(e0, e1), o = MIN(o0, o1);
        lo[i] = MIN(e, o);
    }
    for (size_t i = 0; i < n; i++) {
        T e0 = MAX(MOST(b0[2 * i]), MOST(b1[2 * i])), e1 = MAX(MOST(b2[2 * i]), MOST(b3[2 * i]));
        T o0 = MAX(MOST(b0[2 * i + 1]), MOST(b1[2 * i + 1]));
        T o1 = MAX(MOST(b2[2 * i + 1]), MOST(b3[2 * i + 1]));
        T e = MAX(e0, e1), o = MAX(o0, o1);
        hi[i] = MAX(e, o);
    }
}

#undef MIN
#undef MAX
#undef LEAST
#undef MOST
#undef T
#undef NAME
#undef FINITE
#undef LOWEST
#undef HIGHEST
#undef MEAN8
