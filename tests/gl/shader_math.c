/* The shaders' own arithmetic against the C library's double precision: exp and 1 - exp(-x), 32.64 fixed
 * point. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "buffer.h"
#include "memory_source.h"
#include "program.h"
#include "shaders.h"
#include "target.h"

#define EDGE 256

struct bench {
    struct vr_context *context;
    struct vr_target target;
};

static int setup(void **state)
{
    struct brick_error err = {0};
    struct bench *b = calloc(1, sizeof *b);
    *state = b;
    if (vr_context_create(&b->context, VR_CONTEXT_AUTO, &err)) {
        print_message("no context: %s\n", err.message);
        return 0;
    }
    assert_int_equal(vr_context_bind(b->context, &err), 0);
    assert_int_equal(vr_target_init(&b->target, b->context, EDGE, EDGE, false, &err), 0);
    return 0;
}

static int teardown(void **state)
{
    struct bench *b = *state;
    if (b->context) {
        vr_target_finish(&b->target, b->context);
        vr_context_unbind(b->context);
        vr_context_destroy(&b->context);
    }
    free(b);
    return 0;
}

/* Run main_text over EDGE x EDGE words of input; each gives a vec4. */
static void run(struct bench *b, struct vr_shader_part part, const char *main_text, const uint32_t *input,
                float *output)
{
    struct brick_error err = {0};
    const struct vr_shader_part parts[2] = {part, {"test", main_text}};
    static uint32_t numbers[2 * EDGE * EDGE];
    static uint32_t flags[EDGE / VR_TARGET_TILE * (EDGE / VR_TARGET_TILE)];
    GLuint program;
    struct vr_buffer buffer = {0};
    memset(flags, 1, sizeof flags);
    if (vr_program_create(b->context, "", &(struct vr_program_source){.fragment = parts, .fragment_count = 2},
                          &program, &err))
        fail_msg("%s", err.message);
    assert_int_equal(
        vr_buffer_write(&buffer, b->context, GL_R32UI, input, EDGE * EDGE * sizeof *input, "test", &err), 0);
    vr_buffer_use(&buffer, b->context, 0);
    b->context->gl.UseProgram(program);
    vr_target_use(&b->target, b->context, 0, 1);
    vr_target_draw(&b->target, b->context, EDGE, EDGE, flags, EDGE / VR_TARGET_TILE, VR_TARGET_DEPTH_OFF);
    vr_target_read(&b->target, b->context, EDGE, EDGE, output, EDGE, numbers);
    b->context->gl.UseProgram(0);
    b->context->gl.DeleteProgram(program);
    vr_buffer_finish(&buffer, b->context);
    assert_int_equal(vr_context_check(b->context, "test", &err), 0);
}

static double ulps(float got, double want)
{
    float near = (float)want;
    double unit = fabs((double)nextafterf(near, INFINITY) - (double)near);
    return fabs((double)got - want) / unit;
}

/* Depths from 1e-30 to 85, uniform in the logarithm, and all eighths around reduction steps. */
static void test_exponential(void **state)
{
    struct bench *b = *state;
    static float x[EDGE * EDGE], out[4 * EDGE * EDGE];
    static uint32_t bits[EDGE * EDGE];
    static const char text[] =
        "uniform usamplerBuffer inputs;\n"
        "layout(rgba32ui, binding = 0) uniform uimage2D words;\n"
        "void main() {\n"
        "    float x = uintBitsToFloat(texelFetch(inputs, int(gl_FragCoord.y) * 256 + "
        "int(gl_FragCoord.x)).r);\n"
        "    imageStore(words, ivec2(gl_FragCoord.xy),\n"
        "               floatBitsToUint(vec4(exponential(-x), opacity(x), exp(-x), 0.0)));\n"
        "}\n";
    double worst_exp = 0.0, worst_opacity = 0.0, worst_builtin = 0.0;
    if (!b->context)
        skip();
    for (int i = 0; i < EDGE * EDGE; i++)
        x[i] = i < EDGE * EDGE / 2 ? (float)exp(log(1e-30) + (log(85.0) - log(1e-30)) * i / (EDGE * EDGE / 2))
                                   : (float)(i - EDGE * EDGE / 2) * (85.0f / (EDGE * EDGE / 2));
    memcpy(bits, x, sizeof bits);
    run(b, (struct vr_shader_part){"exponential", vr_shader_exponential}, text, bits, out);
    for (int i = 0; i < EDGE * EDGE; i++) {
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
    struct bench *b = *state;
    static float out[4 * EDGE * EDGE];
    static uint32_t in[EDGE * EDGE];
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
    if (!b->context)
        skip();
    for (uint32_t i = 0; i < EDGE * EDGE; i++)
        in[i] = (uint32_t)noise64(7, i);
    run(b, (struct vr_shader_part){"fixed", vr_shader_fixed}, text, in, out);
    for (uint32_t j = 0; j < EDGE * EDGE; j += 8) {
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
        cmocka_unit_test_setup_teardown(test_exponential, setup, teardown),
        cmocka_unit_test_setup_teardown(test_fixed, setup, teardown),
    };
    return cmocka_run_group_tests_name("shader_math", tests, NULL, NULL);
}
