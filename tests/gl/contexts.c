/* Contexts through both libraries, in either order and several at once; what programs and arrays that cannot
 * be say. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "buffer.h"
#include "program.h"
#include "target.h"

static struct vr_context *try_context(enum vr_context_kind kind)
{
    struct brick_error err = {0};
    struct vr_context *context = NULL;
    int result = vr_context_create(&context, kind, &err);
    if (result) {
        assert_int_equal(result, BRICK_ERR_UNSUPPORTED);
        assert_null(context);
        assert_true(strlen(err.message) > 0);
        print_message("%s\n", err.message);
    }
    return context;
}

/* Every pixel of a small picture is what the shader writes. */
static void draw_something(struct vr_context *context, float value)
{
    static const struct vr_shader_part part = {
        "test", "uniform float value;\n"
                "layout(rgba32ui, binding = 0) uniform uimage2D words;\n"
                "layout(rg32ui, binding = 1) uniform uimage2D numbers;\n"
                "void main() {\n"
                "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
                "    imageStore(words, at, floatBitsToUint(vec4(value, gl_FragCoord.xy, 1.0)));\n"
                "    imageStore(numbers, at, uvec4(3u, uint(gl_FragCoord.x), 0u, 0u));\n"
                "}\n"};
    struct brick_error err = {0};
    struct vr_target target;
    GLuint program;
    float rgba[5 * 7 * 4];
    uint32_t numbers[2 * 5 * 7];
    assert_int_equal(vr_context_bind(context, &err), 0);
    assert_true(context->version >= 43);
    assert_int_equal(vr_target_init(&target, context, 5, 7, false, &err), 0);
    if (vr_program_create(context, "", &(struct vr_program_source){.fragment = &part, .fragment_count = 1},
                          &program, &err))
        fail_msg("%s", err.message);
    context->gl.UseProgram(program);
    context->gl.Uniform1f(context->gl.GetUniformLocation(program, "value"), value);
    vr_target_use(&target, context, 0, 1);
    vr_target_draw(&target, context, 5, 7, &(uint32_t){1}, 1, VR_TARGET_DEPTH_OFF);
    vr_target_read(&target, context, 5, 7, rgba, 5, numbers);
    for (int i = 0; i < 5 * 7; i++) {
        assert_int_equal(numbers[2 * i], 3);
        assert_int_equal(numbers[2 * i + 1], i % 5);
        assert_true(rgba[4 * i] == value && rgba[4 * i + 3] == 1.0f);
        assert_true(rgba[4 * i + 1] == (float)(i % 5) + 0.5f && rgba[4 * i + 2] == (float)(i / 5) + 0.5f);
    }
    context->gl.UseProgram(0);
    context->gl.DeleteProgram(program);
    vr_target_finish(&target, context);
    assert_int_equal(vr_context_check(context, "drawing", &err), 0);
    vr_context_unbind(context);
}

static void test_kinds(void **state)
{
    (void)state;
    static const enum vr_context_kind order[] = {VR_CONTEXT_EGL, VR_CONTEXT_OSMESA, VR_CONTEXT_EGL,
                                                 VR_CONTEXT_AUTO};
    struct vr_context *contexts[4];
    int have = 0;
    for (int i = 0; i < 4; i++)
        have += (contexts[i] = try_context(order[i])) != NULL;
    for (int turn = 0; turn < 2; turn++)
        for (int i = 0; i < 4; i++)
            if (contexts[i])
                draw_something(contexts[i], (float)(10 * turn + i));
    /* The first goes first: the others do not notice. */
    vr_context_destroy(&contexts[0]);
    for (int i = 1; i < 4; i++) {
        if (contexts[i])
            draw_something(contexts[i], 0.25f);
        vr_context_destroy(&contexts[i]);
    }
    if (!have)
        skip();
}

static void test_program_errors(void **state)
{
    (void)state;
    struct brick_error err = {0};
    struct vr_context *context = try_context(VR_CONTEXT_AUTO);
    static const struct vr_shader_part parts[2] = {{"good.glsl", "float one() { return 1.0; }\n"},
                                                   {"bad.glsl", "void main() {\n    nonsense();\n}\n"}};
    GLuint program = 7;
    if (!context)
        skip();
    assert_int_equal(vr_context_bind(context, &err), 0);
    assert_int_equal(vr_program_create(context, "#define X 1\n",
                                       &(struct vr_program_source){.fragment = parts, .fragment_count = 2},
                                       &program, &err),
                     BRICK_ERR_UNSUPPORTED);
    assert_int_equal(program, 0);
    assert_non_null(strstr(err.message, "bad.glsl:2 "));
    assert_non_null(strstr(err.message, "nonsense"));
    assert_null(strchr(err.message, '\n'));
    assert_int_equal(vr_program_create(context, "",
                                       &(struct vr_program_source){.fragment = parts, .fragment_count = 1},
                                       &program, &err),
                     BRICK_ERR_UNSUPPORTED);

    struct vr_buffer buffer = {0};
    assert_int_equal(vr_buffer_write(&buffer, context, GL_R32UI, NULL, UINT64_C(1) << 50, "page table", &err),
                     BRICK_ERR_UNSUPPORTED);
    assert_non_null(strstr(err.message, "page table"));
    vr_context_unbind(context);
    vr_context_destroy(&context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kinds),
        cmocka_unit_test(test_program_errors),
    };
    return cmocka_run_group_tests_name("contexts", tests, NULL, NULL);
}
