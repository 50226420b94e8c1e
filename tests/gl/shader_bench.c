#include "shader_bench.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "buffer.h"

int bench_setup(void **state)
{
    struct brick_error err = {0};
    struct shader_bench *b = calloc(1, sizeof *b);
    *state = b;
    if (vr_context_create(&b->context, VR_CONTEXT_AUTO, &err)) {
        print_message("no context: %s\n", err.message);
        return 0;
    }
    assert_int_equal(vr_context_bind(b->context, &err), 0);
    assert_int_equal(vr_target_init(&b->target, b->context, BENCH_EDGE, BENCH_EDGE, false, &err), 0);
    return 0;
}

int bench_teardown(void **state)
{
    struct shader_bench *b = *state;
    if (b->context) {
        vr_target_finish(&b->target, b->context);
        vr_context_unbind(b->context);
        vr_context_destroy(&b->context);
    }
    free(b);
    return 0;
}

void bench_run(struct shader_bench *b, const char *defines, const struct vr_shader_part *parts,
               int part_count, uint32_t words, const uint32_t *input, float *output)
{
    struct brick_error err = {0};
    static uint32_t numbers[2 * BENCH_COUNT];
    static uint32_t flags[BENCH_EDGE / VR_TARGET_TILE * (BENCH_EDGE / VR_TARGET_TILE)];
    GLuint program;
    struct vr_buffer buffer = {0};
    memset(flags, 1, sizeof flags);
    if (vr_program_create(b->context, defines,
                          &(struct vr_program_source){.fragment = parts, .fragment_count = part_count},
                          &program, &err))
        fail_msg("%s", err.message);
    assert_int_equal(vr_buffer_write(&buffer, b->context, GL_R32UI, input,
                                     BENCH_COUNT * (uint64_t)words * sizeof *input, "test", &err),
                     0);
    vr_buffer_use(&buffer, b->context, 0);
    b->context->gl.UseProgram(program);
    if (b->prepare)
        b->prepare(b->data, program);
    vr_target_use(&b->target, b->context, 0, 1);
    vr_target_draw(&b->target, b->context, BENCH_EDGE, BENCH_EDGE, flags, BENCH_EDGE / VR_TARGET_TILE,
                   VR_TARGET_DEPTH_OFF);
    vr_target_read(&b->target, b->context, BENCH_EDGE, BENCH_EDGE, output, BENCH_EDGE, numbers);
    b->context->gl.UseProgram(0);
    b->context->gl.DeleteProgram(program);
    vr_buffer_finish(&buffer, b->context);
    assert_int_equal(vr_context_check(b->context, "test", &err), 0);
}
