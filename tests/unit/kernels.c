/* The twins of build/kernels.h: every table that this processor can run against the plain one, bit for bit;
 * and the plain one against the definitions, written another way. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "../support/memory_source.h"
#include "kernels.h"

enum { N = 4096, ROWS = 9 };

/* Noise of all bit patterns; of floats an eighth is NaN or Inf, and zeros of both signs are frequent. */
static void noise(enum brick_type type, uint64_t seed, void *dst, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        uint64_t r = noise64(seed, i);
        float f = (float)(int32_t)(r >> 32) * 1e-3f;
        const float special[8] = {NAN, INFINITY, -INFINITY, 0.0f, -0.0f, 1e-42f, 3e38f, -3e38f};
        if (r % 4 == 0)
            f = special[r >> 2 & 7];
        memcpy((unsigned char *)dst + i * brick_type_bytes(type),
               type == BRICK_F32 ? (const void *)&f : (const void *)&r, brick_type_bytes(type));
    }
}

static void tables_agree(void **state)
{
    (void)state;
    static uint64_t a[N], b[N], out[2][2][N];
    const struct kernels *plain = kernels_plain();
    for (unsigned t = 0; kernels_table(t) != NULL; t++) {
        const struct kernels *k = kernels_table(t);
        for (uint64_t round = 0; round < 400; round++)
            for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++) {
                size_t width = brick_type_bytes((enum brick_type)type);
                size_t rows = 1 + noise64(1, round) % ROWS, n = 1 + noise64(2, round) % 200, stride = 201;
                noise((enum brick_type)type, 2 * round, a, rows < 4 ? 4 * 402 : ROWS * 402);
                noise((enum brick_type)type, 2 * round + 1, b, ROWS * 402);
                memset(out, 0x55, sizeof out); /* what must not be written shows, too */
                k->fold[type](out[0][0], out[0][1], a, b, stride, rows, n);
                plain->fold[type](out[1][0], out[1][1], a, b, stride, rows, n);
                assert_memory_equal(out[0], out[1], sizeof out[0]);
                const void *ra[4], *rb[4];
                for (size_t r = 0; r < 4; r++) {
                    ra[r] = (const unsigned char *)a + r * 401 * width;
                    rb[r] = (const unsigned char *)b + r * 401 * width;
                }
                k->range_pairs[type](out[0][0], out[0][1], ra, rb, n);
                plain->range_pairs[type](out[1][0], out[1][1], ra, rb, n);
                assert_memory_equal(out[0], out[1], sizeof out[0]);
                k->mean_pairs[type](out[0][0], ra, n);
                plain->mean_pairs[type](out[1][0], ra, n);
                assert_memory_equal(out[0], out[1], sizeof out[0]);
                if (type != BRICK_F32)
                    continue;
                double sum[2][8] = {{0}};
                k->sum_f32(sum[0], (const float *)a, n);
                plain->sum_f32(sum[1], (const float *)a, n);
                k->squares_f32(sum[0], (const float *)a, n, 0.25);
                plain->squares_f32(sum[1], (const float *)a, n, 0.25);
                assert_memory_equal(sum[0], sum[1], sizeof sum[0]);
            }
    }
}

static void plain_is_the_definition(void **state)
{
    (void)state;
    static uint64_t a[N], b[N], lo[N], hi[N], mean[N];
    for (int t = 0; t < BRICK_TYPE_STORED_COUNT; t++) {
        enum brick_type type = (enum brick_type)t;
        size_t width = brick_type_bytes(type), n = 150;
        noise(type, 77, a, ROWS * n);
        noise(type, 78, b, ROWS * n);
        kernels_plain()->fold[t](lo, hi, a, b, n, ROWS, n);
        for (size_t i = 0; i < n; i++) {
            double least = INFINITY, most = -INFINITY;
            for (size_t r = 0; r < ROWS; r++) {
                double va = brick_type_load(type, a, r * n + i), vb = brick_type_load(type, b, r * n + i);
                least = isfinite(va) ? fmin(least, va) : least;
                most = isfinite(vb) ? fmax(most, vb) : most;
            }
            assert_true(brick_type_load(type, lo, i) == least && brick_type_load(type, hi, i) == most);
        }
        const void *rows[4];
        for (size_t r = 0; r < 4; r++)
            rows[r] = (const unsigned char *)a + r * 2 * n * width;
        kernels_plain()->range_pairs[t](lo, hi, rows, rows, n);
        kernels_plain()->mean_pairs[t](mean, rows, n);
        for (size_t i = 0; i < n; i++) {
            double least = INFINITY, most = -INFINITY, sum = 0.0, count = 0.0;
            for (size_t v = 0; v < 8; v++) {
                double value = brick_type_load(type, rows[v / 2], 2 * i + v % 2);
                if (!isfinite(value))
                    continue;
                least = fmin(least, value);
                most = fmax(most, value);
                sum += value;
                count += 1.0;
            }
            double want = type == BRICK_F32 ? (double)(float)(sum / count) : nearbyint(sum / 8.0);
            double found = brick_type_load(type, mean, i);
            assert_true(count == 0.0 ? isnan(found) : found == want);
            if (count > 0.0)
                assert_true(brick_type_load(type, lo, i) == least && brick_type_load(type, hi, i) == most);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_agree),
        cmocka_unit_test(plain_is_the_definition),
    };
    return cmocka_run_group_tests_name("kernels", tests, NULL, NULL);
}
