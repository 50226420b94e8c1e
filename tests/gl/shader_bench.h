/* Shader functions run over an array, to hold their results against the C library's double precision. */
#ifndef TESTS_SHADER_BENCH_H
#define TESTS_SHADER_BENCH_H

#include "program.h"
#include "target.h"

#define BENCH_EDGE  256
#define BENCH_COUNT (BENCH_EDGE * BENCH_EDGE)

struct shader_bench {
    struct vr_context *context; /* NULL when this machine has none; bound otherwise */
    struct vr_target target;
    void (*prepare)(void *data, GLuint program); /* NULL, or called with the program in use */
    void *data;
};

/* For cmocka. */
int bench_setup(void **state);
int bench_teardown(void **state);

/* Run the shader whose last part has main() once for each of BENCH_COUNT results, four floats each. The
 * shader finds `words` words of input for each in a usamplerBuffer at unit 0 and writes to the image at unit
 * 0. */
void bench_run(struct shader_bench *bench, const char *defines, const struct vr_shader_part *parts,
               int part_count, uint32_t words, const uint32_t *input, float *output);

#endif
