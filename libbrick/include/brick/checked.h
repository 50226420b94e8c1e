/* Checked arithmetic on sizes: true when the result fits, false (and *out untouched) when it does not. */
#ifndef BRICK_CHECKED_H
#define BRICK_CHECKED_H

#include <stdbool.h>
#include <stdint.h>

static inline bool brick_add_u64(uint64_t a, uint64_t b, uint64_t *out)
{
    uint64_t r;
    if (__builtin_add_overflow(a, b, &r))
        return false;
    *out = r;
    return true;
}

static inline bool brick_mul_u64(uint64_t a, uint64_t b, uint64_t *out)
{
    uint64_t r;
    if (__builtin_mul_overflow(a, b, &r))
        return false;
    *out = r;
    return true;
}

static inline bool brick_mul3_u64(uint64_t a, uint64_t b, uint64_t c, uint64_t *out)
{
    uint64_t ab;
    return brick_mul_u64(a, b, &ab) && brick_mul_u64(ab, c, out);
}

#endif
