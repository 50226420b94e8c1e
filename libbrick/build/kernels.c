/* The same C compiled several times: the compiler vectorises it for each instruction set, and the processor
 * is asked once which it has. There are no intrinsics, so other processors and compilers just get the plain
 * table. Invariant: no operation here may be contracted or reordered (-ffp-contract=off, no fast-math), so
 * all tables give the same bits. Traps and their flags are not used, hence -fno-trapping-math: it lets
 * isfinite vectorise. */
#include "kernels.h"

#include <math.h>
#include <stdint.h>

/* Sum of eight integers / 8, rounded half to even. */
static inline int32_t eighth(int32_t sum)
{
    return (sum + 3 + (sum >> 3 & 1)) >> 3; /* floor for negative sums too */
}

/* Mean of the finite ones among eight, rounded once; NaN when none is. */
static inline float mean_finite(float a, float b, float c, float d, float e, float f, float g, float h)
{
#define ADD(v)                                                                                               \
    sum += isfinite(v) ? (double)(v) : 0.0;                                                                  \
    n += isfinite(v) ? 1.0 : 0.0;
    double sum = 0.0, n = 0.0;
    ADD(a) ADD(b) ADD(c) ADD(d) ADD(e) ADD(f) ADD(g) ADD(h)
#undef ADD
                return n > 0.0
        ? (float)(sum / n)
        : NAN;
}

#define SET c
#define TARGET
#include "kernels_set.h"

#if defined __x86_64__ && defined __GNUC__
#define SET    avx2
#define TARGET __attribute__((target("avx2")))
#include "kernels_set.h"
#define SET    avx512
#define TARGET __attribute__((target("avx512bw,avx512vl,avx512dq,prefer-vector-width=512")))
#include "kernels_set.h"
#endif

const struct kernels *kernels_table(unsigned i)
{
    const struct kernels *tables[KERNELS_MAX + 1] = {0};
    unsigned n = 0;
#if defined __x86_64__ && defined __GNUC__
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq"))
        tables[n++] = &kernels_avx512;
    if (__builtin_cpu_supports("avx2"))
        tables[n++] = &kernels_avx2;
#endif
    tables[n++] = &kernels_c;
    return i < n ? tables[i] : NULL;
}

const struct kernels *kernels_best(void)
{
    return kernels_table(0);
}

const struct kernels *kernels_plain(void)
{
    return &kernels_c;
}
