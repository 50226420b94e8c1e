/* The same C compiled several times, in vectors as wide as each instruction set has; the processor is asked
 * once which it has. Beside GCC's vectors a set has a handful of operations of its own. Invariant: no
 * operation is contracted or reordered (-ffp-contract=off, no fast-math), so all tables give the same bits,
 * and those are what the shaders (field.glsl, transfer.glsl, exponential.glsl, shading.glsl) compute where
 * OpenGL rounds as IEEE 754 does. */
#include "kernels.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#if defined __x86_64__ && defined __GNUC__
#include <immintrin.h>
#endif

/* Vectors never cross a function that is not inlined. */
#pragma GCC diagnostic ignored "-Wpsabi"

#define INLINE static inline __attribute__((always_inline))

#define SET(name) c_##name
#define TARGET
#define LANES    4
#define IOTA     0, 1, 2, 3
#define ODD      1, 3, 5, 7
#define EVEN     0, 2, 4, 6
#define ZIP_LOW  0, 4, 1, 5
#define ZIP_HIGH 2, 6, 3, 7
#include "kernels_vector.h"

INLINE vi c_gather(const void *base, vi byte)
{
    vi v;
    for (int i = 0; i < LANES; i++) {
        int32_t word;
        memcpy(&word, (const char *)base + byte[i], sizeof word);
        v[i] = word;
    }
    return v;
}

INLINE uint32_t c_mask(vi v)
{
    uint32_t mask = 0;
    for (int i = 0; i < LANES; i++)
        mask |= (uint32_t)(v[i] & 1) << i;
    return mask;
}

INLINE void c_compress(void *to, uint32_t mask, vi v)
{
    int32_t *out = to;
    for (int i = 0; i < LANES; i++)
        if (mask >> i & 1)
            *out++ = v[i];
}

INLINE vf c_min(vf a, vf b)
{
    vi less = a < b;
    return (vf)((less & (vi)a) | (~less & (vi)b));
}

INLINE vf c_max(vf a, vf b)
{
    vi more = a > b;
    return (vf)((more & (vi)a) | (~more & (vi)b));
}

INLINE vf c_sqrt(vf a)
{
    vf r;
    for (int i = 0; i < LANES; i++)
        r[i] = __builtin_sqrtf(a[i]);
    return r;
}

INLINE vf c_floor(vf a) /* of numbers that an int holds */
{
    const vf whole = __builtin_convertvector(__builtin_convertvector(a, vi), vf);
    return whole + __builtin_convertvector(whole > a, vf); /* true is -1 */
}

/* Two words one after the other, from each of four bases. */
INLINE void c_rows(const char *const base[4], vi byte, vi words[4][2])
{
    for (int k = 0; k < 4; k++)
        for (int w = 0; w < 2; w++)
            words[k][w] = c_gather(base[k] + 4 * w, byte);
}

/* row[at], of a row of so many */
INLINE vf c_pick(const float *row, uint32_t count, vi at)
{
    (void)count;
    vf v;
    for (int i = 0; i < LANES; i++)
        v[i] = row[at[i]];
    return v;
}
#include "kernels_set.h"

#if defined __x86_64__ && defined __GNUC__
#define SET(name) avx2_##name
#define TARGET    __attribute__((target("avx2,bmi,bmi2,popcnt")))
#define LANES     8
#define IOTA      0, 1, 2, 3, 4, 5, 6, 7
#define ODD       1, 3, 5, 7, 9, 11, 13, 15
#define EVEN      0, 2, 4, 6, 8, 10, 12, 14
#define ZIP_LOW   0, 8, 1, 9, 2, 10, 3, 11
#define ZIP_HIGH  4, 12, 5, 13, 6, 14, 7, 15
#include "kernels_vector.h"

TARGET INLINE vi avx2_gather(const void *base, vi byte)
{
    return (vi)_mm256_i32gather_epi32(base, (__m256i)byte, 1);
}

TARGET INLINE uint32_t avx2_mask(vi v)
{
    return (uint32_t)_mm256_movemask_ps((__m256)v);
}

TARGET INLINE void avx2_compress(void *to, uint32_t mask, vi v)
{
    const uint64_t lanes = _pdep_u64(mask, UINT64_C(0x0101010101010101)) * 0xff; /* a byte each */
    const __m128i order = _mm_cvtsi64_si128((long long)_pext_u64(UINT64_C(0x0706050403020100), lanes));
    _mm256_storeu_si256(to, _mm256_permutevar8x32_epi32((__m256i)v, _mm256_cvtepu8_epi32(order)));
}

TARGET INLINE vf avx2_min(vf a, vf b)
{
    return (vf)_mm256_min_ps((__m256)a, (__m256)b);
}

TARGET INLINE vf avx2_max(vf a, vf b)
{
    return (vf)_mm256_max_ps((__m256)a, (__m256)b);
}

TARGET INLINE vf avx2_sqrt(vf a)
{
    return (vf)_mm256_sqrt_ps((__m256)a);
}

TARGET INLINE vf avx2_floor(vf a)
{
    return (vf)_mm256_floor_ps((__m256)a);
}

/* Loads one by one take less time than gathers of twice the width. */
INLINE __m128i load_two(const char *base, int32_t first, int32_t second)
{
    const __m128 low = (__m128)_mm_loadl_epi64((const __m128i *)(base + first));
    return (__m128i)_mm_loadh_pi(low, (const __m64 *)(base + second));
}

TARGET INLINE void avx2_rows(const char *const base[4], vi byte, vi words[4][2])
{
    vi part[4][2];
    int32_t at[LANES];
    memcpy(at, &byte, sizeof at);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 4; k++)
            part[k][i] = (vi)_mm256_set_m128i(load_two(base[k], at[4 * i + 2], at[4 * i + 3]),
                                              load_two(base[k], at[4 * i], at[4 * i + 1]));
    for (int k = 0; k < 4; k++) {
        words[k][0] = __builtin_shufflevector(part[k][0], part[k][1], 0, 2, 4, 6, 8, 10, 12, 14);
        words[k][1] = __builtin_shufflevector(part[k][0], part[k][1], 1, 3, 5, 7, 9, 11, 13, 15);
    }
}

TARGET INLINE vf avx2_pick(const float *row, uint32_t count, vi at)
{
    if (count > 16)
        return (vf)_mm256_i32gather_ps(row, (__m256i)at, 4);
    const __m256 low = _mm256_permutevar8x32_ps(_mm256_load_ps(row), (__m256i)at);
    const __m256 high = _mm256_permutevar8x32_ps(_mm256_load_ps(row + 8), (__m256i)at);
    return (vf)_mm256_blendv_ps(low, high, (__m256)(at << 28));
}
#include "kernels_set.h"

#define SET(name) avx512_##name
#define TARGET    __attribute__((target("avx512f,avx512bw,avx512vl,avx512dq,bmi,popcnt")))
#define LANES     16
#define IOTA      0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15
#define ODD       1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31
#define EVEN      0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30
#define ZIP_LOW   0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23
#define ZIP_HIGH  8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31
#include "kernels_vector.h"

TARGET INLINE vi avx512_gather(const void *base, vi byte)
{
    return (vi)_mm512_i32gather_epi32((__m512i)byte, base, 1);
}

TARGET INLINE uint32_t avx512_mask(vi v)
{
    return _mm512_movepi32_mask((__m512i)v);
}

TARGET INLINE void avx512_compress(void *to, uint32_t mask, vi v)
{
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32((__mmask16)mask, (__m512i)v));
}

TARGET INLINE vf avx512_min(vf a, vf b)
{
    return (vf)_mm512_min_ps((__m512)a, (__m512)b);
}

TARGET INLINE vf avx512_max(vf a, vf b)
{
    return (vf)_mm512_max_ps((__m512)a, (__m512)b);
}

TARGET INLINE vf avx512_sqrt(vf a)
{
    return (vf)_mm512_sqrt_ps((__m512)a);
}

TARGET INLINE vf avx512_floor(vf a)
{
    return (vf)_mm512_floor_ps((__m512)a);
}

TARGET INLINE void avx512_rows(const char *const base[4], vi byte, vi words[4][2])
{
    __m256i part[4][4];
    int32_t at[LANES];
    memcpy(at, &byte, sizeof at);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            part[k][i] = _mm256_set_m128i(load_two(base[k], at[4 * i + 2], at[4 * i + 3]),
                                          load_two(base[k], at[4 * i], at[4 * i + 1]));
    for (int k = 0; k < 4; k++) {
        const vi low = (vi)_mm512_inserti64x4(_mm512_castsi256_si512(part[k][0]), part[k][1], 1);
        const vi high = (vi)_mm512_inserti64x4(_mm512_castsi256_si512(part[k][2]), part[k][3], 1);
        words[k][0] =
            __builtin_shufflevector(low, high, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
        words[k][1] =
            __builtin_shufflevector(low, high, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    }
}

TARGET INLINE vf avx512_pick(const float *row, uint32_t count, vi at)
{
    if (count > 64)
        return (vf)_mm512_i32gather_ps((__m512i)at, row, 4);
    if (count <= 16)
        return (vf)_mm512_permutexvar_ps((__m512i)at, _mm512_load_ps(row));
    const __m512 low = _mm512_permutex2var_ps(_mm512_load_ps(row), (__m512i)at, _mm512_load_ps(row + 16));
    if (count <= 32)
        return (vf)low;
    const __m512 high =
        _mm512_permutex2var_ps(_mm512_load_ps(row + 32), (__m512i)at, _mm512_load_ps(row + 48));
    return (vf)_mm512_mask_blend_ps(_mm512_test_epi32_mask((__m512i)at, _mm512_set1_epi32(32)), low, high);
}
#include "kernels_set.h"
#endif

int vr_cast_pieces_init(struct vr_cast_pieces *pieces, const struct vr_transfer_table *table,
                        struct brick_error *err)
{
    const size_t room =
        table->count <= 64 ? 64 : ((size_t)table->count + 15) / 16 * 16; /* MAX_KNOTS bounds it */
    *pieces = (struct vr_cast_pieces){.table = table};
    float *memory = aligned_alloc(64, VR_CAST_ROWS * room * sizeof *memory);
    if (!memory)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a transfer function of %u pieces",
                          table->count);
    memset(memory, 0, VR_CAST_ROWS * room * sizeof *memory);
    for (size_t r = 0; r < VR_CAST_ROWS; r++)
        pieces->row[r] = memory + r * room;
    for (uint32_t i = 0; i < table->count; i++) {
        const struct vr_piece *p = &table->pieces[i];
        pieces->row[VR_CAST_START][i] = p->start;
        pieces->row[VR_CAST_ORIGIN][i] = p->origin;
        pieces->row[VR_CAST_SIGMA][i] = p->sigma;
        pieces->row[VR_CAST_SIGMA_SLOPE][i] = p->sigma_slope;
        for (int c = 0; c < 3; c++) {
            pieces->row[VR_CAST_RGB + c][i] = p->rgb[c];
            pieces->row[VR_CAST_RGB_SLOPE + c][i] = p->rgb_slope[c];
        }
    }
    return BRICK_OK;
}

void vr_cast_pieces_finish(struct vr_cast_pieces *pieces)
{
    free(pieces->row[0]);
    *pieces = (struct vr_cast_pieces){0};
}

const struct vr_cast_kernels *vr_cast_kernels_table(unsigned i)
{
    const struct vr_cast_kernels *tables[3];
    unsigned n = 0;
#if defined __x86_64__ && defined __GNUC__
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq"))
        tables[n++] = &avx512_kernels;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2"))
        tables[n++] = &avx2_kernels;
#endif
    tables[n++] = &c_kernels;
    return i < n ? tables[i] : NULL;
}

unsigned vr_cast_flush(void)
{
#if defined __x86_64__ && defined __GNUC__
    const unsigned kept = _mm_getcsr();
    _mm_setcsr(kept | 0x8040); /* results and operands */
    return kept;
#else
    return 0;
#endif
}

void vr_cast_restore(unsigned kept)
{
#if defined __x86_64__ && defined __GNUC__
    _mm_setcsr(kept);
#else
    (void)kept;
#endif
}
