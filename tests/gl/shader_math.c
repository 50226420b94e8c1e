/* The shaders' own arithmetic against the C library's double precision: exp and 1 - exp(-x), 32.64 fixed
 * point. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "memory_source.h"
#include "shader_bench.h"
#include "shaders.h"

static double ulps(float got, double want)
{
    float near = (float)want;
    double unit = fabs((double)nextafterf(near, INFINITY) - (double)near);
    return fabs((double)got - want) / unit;
}

/* Depths from 1e-30 to 85, uniform in the logarithm, and all eighths around reduction steps. */
static void test_exponential(void **state)
{
    struct shader_bench *b = *state;
    static float x[BENCH_COUNT], out[4 * BENCH_COUNT];
    static uint32_t bits[BENCH_COUNT];
    static const char text[] =
        "uniform usamplerBuffer inputs;\n"
        "layout(rgba32ui, binding = 0) uniform uimage2D words;\n"
        "void main() {\n"
        "    float x = uintBitsToFloat(texelFetch(inputs, int(gl_FragCoord.y) * 256 + "
        "int(gl_FragCoord.x)).r);\n"
        "    imageStore(words, ivec2(gl_FragCoord.xy),\n"
        "               floatBitsToUint(vec4(exponential(-x), opacity(x), exp(-x), 0.0)));\n"
        "}\n";
    const struct vr_shader_part parts[] = {{"exponential", vr_shader_exponential}, {"test", text}};
    double worst_exp = 0.0, worst_opacity = 0.0, worst_builtin = 0.0;
    if (!b->context)
        skip();
    for (int i = 0; i < BENCH_COUNT; i++)
        x[i] = i < BENCH_COUNT / 2 ? (float)exp(log(1e-30) + (log(85.0) - log(1e-30)) * i / (BENCH_COUNT / 2))
                                   : (float)(i - BENCH_COUNT / 2) * (85.0f / (BENCH_COUNT / 2));
    memcpy(bits, x, sizeof bits);
    bench_run(b, "", parts, 2, 1, bits, out);
    for (int i = 0; i < BENCH_COUNT; i++) {
        worst_exp = fmax(worst_exp, ulps(out[4 * i], exp(-(double)x[i])));
        worst_builtin = fmax(worst_builtin, ulps(out[4 * i + 2], exp(-(double)x[i])));
        worst_opacity = fmax(worst_opacity, ulps(out[4 * i + 1], -expm1(-(double)x[i])));
    }
    print_message("units in the last place: exp %.2f, opacity %.2f; built-in exp %.2f\n", worst_exp,
                  worst_opacity, worst_builtin);
    assert_true(worst_exp <= 2.0);
    assert_true(worst_opacity <= 2.0);
}

/* The words of a 32.64 number as floats are not exact, so the shader hands them out in halves of 16 bits. */
static __int128 from_words(uint32_t cell, uint32_t fraction, uint32_t tail)
{
    return (__int128)(int32_t)cell * ((__int128)1 << 64) + (((__int128)fraction << 32) | tail);
}

/* first + k * step, by leaps and by single steps, first - step, and half of it, against 128-bit integers. */
static void test_fixed(void **state)
{
    struct shader_bench *b = *state;
    static float out[4 * BENCH_COUNT];
    static uint32_t in[BENCH_COUNT];
    static const char text[] =
        "uniform usamplerBuffer inputs;\n"
        "uint word(int i) { return texelFetch(inputs, i).r; }\n"
        "layout(rgba32ui, binding = 0) uniform uimage2D words;\n"
        "void main() {\n"
        "    int i = int(gl_FragCoord.y) * 256 + int(gl_FragCoord.x), j = i / 8 * 8;\n"
        "    Fixed3 a = Fixed3(ivec3(word(j)), uvec3(word(j + 1)), uvec3(word(j + 2)));\n"
        "    Fixed3 s = Fixed3(ivec3(word(j + 3)) >> 24, uvec3(word(j + 4)), uvec3(word(j + 5)));\n"
        "    uint k = word(j + 6) >> 12;\n"
        "    Fixed3 r = a;\n"
        "    switch (i - j >> 1) {\n"
        "    case 0: r = fixed_add(a, fixed_times(s, k)); break;\n"
        "    case 1: for (uint n = 0u; n < (k & 63u); n++) r = fixed_add(r, s); break;\n"
        "    case 2: r = fixed_subtract(a, s); break;\n"
        "    case 3: r = fixed_half(a); break;\n"
        "    }\n"
        "    int axis = j / 8 % 3;\n"
        "    uvec3 w = uvec3(uint(r.cell[axis]), r.fraction[axis], r.tail[axis]);\n"
        "    uint rest = (i & 1) == 0 ? w.x >> 16 | (w.y >> 16 << 16) : (w.x & 65535u) | w.y << 16;\n"
        "    imageStore(words, ivec2(gl_FragCoord.xy),\n"
        "               floatBitsToUint(vec4(rest & 65535u, rest >> 16, w.z & 65535u, w.z >> 16)));\n"
        "}\n";
    const struct vr_shader_part parts[] = {{"fixed", vr_shader_fixed}, {"test", text}};
    if (!b->context)
        skip();
    for (uint32_t i = 0; i < BENCH_COUNT; i++)
        in[i] = (uint32_t)noise64(7, i);
    bench_run(b, "", parts, 2, 1, in, out);
    for (uint32_t j = 0; j < BENCH_COUNT; j += 8) {
        const uint32_t *w = in + j;
        __int128 a = from_words(w[0], w[1], w[2]),
                 s = from_words((uint32_t)((int32_t)w[3] >> 24), w[4], w[5]);
        uint32_t k = w[6] >> 12;
        const __int128 want[4] = {a + s * k, a + s * (k & 63), a - s, a >> 1};
        for (int c = 0; c < 4; c++) {
            const float *high = out + 4 * (j + 2 * (uint32_t)c), *low = high + 4;
            uint32_t cell = (uint32_t)high[0] << 16 | (uint32_t)low[0];
            uint32_t fraction = (uint32_t)high[1] << 16 | (uint32_t)low[1];
            uint32_t tail = (uint32_t)low[3] << 16 | (uint32_t)low[2];
            uint32_t expected[3] = {(uint32_t)(want[c] >> 64), (uint32_t)(want[c] >> 32), (uint32_t)want[c]};
            if (cell != expected[0] || fraction != expected[1] || tail != expected[2])
                fail_msg("operation %d of input %u: %08x.%08x.%08x, not %08x.%08x.%08x", c, j, cell, fraction,
                         tail, expected[0], expected[1], expected[2]);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_exponential, bench_setup, bench_teardown),
        cmocka_unit_test_setup_teardown(test_fixed, bench_setup, bench_teardown),
    };
    return cmocka_run_group_tests_name("shader_math", tests, NULL, NULL);
}
