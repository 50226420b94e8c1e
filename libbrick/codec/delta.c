/* Why: smooth integers differ little from their neighbours, but a difference of -1 is all ones in two's
 * complement, which spoils the byte shuffle. Folded (0, -1, 1, -2, ... to 0, 1, 2, 3, ...) the upper bytes
 * are zero. */
#include "delta.h"

#include <stdint.h>

#define DEFINE(W)                                                                                            \
    static void encode_##W(const uint##W##_t *src, uint##W##_t *dst, size_t n)                               \
    {                                                                                                        \
        uint##W##_t before = 0;                                                                              \
        for (size_t i = 0; i < n; i++) {                                                                     \
            uint##W##_t d = (uint##W##_t)(src[i] - before), sign = (uint##W##_t)(0u - (d >> (W - 1)));       \
            dst[i] = (uint##W##_t)((uint##W##_t)(d << 1) ^ sign);                                            \
            before = src[i];                                                                                 \
        }                                                                                                    \
    }                                                                                                        \
    static void decode_##W(uint##W##_t *p, size_t n)                                                         \
    {                                                                                                        \
        uint##W##_t before = 0;                                                                              \
        for (size_t i = 0; i < n; i++)                                                                       \
            p[i] = before = (uint##W##_t)(before + ((p[i] >> 1) ^ (uint##W##_t)(0u - (p[i] & 1u))));         \
    }
DEFINE(8)
DEFINE(16)
DEFINE(32)
#undef DEFINE

void delta_encode(size_t width, const void *src, void *dst, size_t n)
{
    if (width == 1)
        encode_8(src, dst, n);
    else if (width == 2)
        encode_16(src, dst, n);
    else
        encode_32(src, dst, n);
}

void delta_decode(size_t width, void *elements, size_t n)
{
    if (width == 1)
        decode_8(elements, n);
    else if (width == 2)
        decode_16(elements, n);
    else
        decode_32(elements, n);
}
