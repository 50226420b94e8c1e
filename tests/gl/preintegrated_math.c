/* Pre-integrated classification of one piece of a ray, as the shader does it, against quadrature in double
 * precision of the transfer function itself: any pair of values, peaks and jumps between them, front = back
 * included. */
#include <float.h>
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
#include "gl_scene.h"
#include "prefixes.h"
#include "shader_bench.h"
#include "shaders.h"

/* What a colour linear in the optical depth leaves out of a stretch of depth D, for colours in [0,1]: half
 * the integral of |exp(-t) - its best linear fit|, as the sign of a colour's deviation can be chosen against
 * it. */
static double left_out(double d)
{
    enum { N = 400 };
    double mean = -expm1(-d) / d, moment = 0.0, sum = 0.0;
    for (int i = 0; i < N; i++) {
        double x = (i + 0.5) / N - 0.5;
        moment += x * exp(-d * (x + 0.5)) * 12.0 / N;
    }
    for (int i = 0; i < N; i++) {
        double x = (i + 0.5) / N - 0.5;
        sum += fabs(exp(-d * (x + 0.5)) - mean - moment * x) * d / N;
    }
    return 0.5 * sum;
}

struct reference {
    double depth, rgb[3]; /* premultiplied */
    double most;          /* extinction in the pieces touched */
    double variation;     /* of extinction on the way */
    double range[3];      /* of the colour on the way */
};

/* A stretch of the way on which the function is linear, from a to b. */
static void add_linear(struct reference *r, double length, const struct brick_transfer_knot *a,
                       const struct brick_transfer_knot *b)
{
    static const double node[5] = {0.0, -0.538469310105683091, 0.538469310105683091, -0.906179845938663993,
                                   0.906179845938663993};
    static const double weight[5] = {0.568888888888888889, 0.478628670499366468, 0.478628670499366468,
                                     0.236926885056189088, 0.236926885056189088};
    double steepness = length * fmax(a->sigma, b->sigma);
    int n = 1 + (int)ceil(4.0 * steepness);
    for (int i = 0; i < n; i++)
        for (int g = 0; g < 5; g++) {
            double t = (i + 0.5 + 0.5 * node[g]) / n, sigma = a->sigma + t * (b->sigma - a->sigma);
            double depth = length * t * (a->sigma + 0.5 * t * (b->sigma - a->sigma));
            double w = 0.5 * weight[g] * length / n * sigma * exp(-(r->depth + depth));
            r->rgb[0] += w * (a->r + t * (b->r - a->r));
            r->rgb[1] += w * (a->g + t * (b->g - a->g));
            r->rgb[2] += w * (a->b + t * (b->b - a->b));
        }
    r->depth += 0.5 * length * (a->sigma + b->sigma);
}

static struct brick_transfer_knot between(const struct brick_transfer_knot *a,
                                          const struct brick_transfer_knot *b, double v)
{
    double s = a->value == b->value ? 0.0 : (v - a->value) / (b->value - a->value);
    return (struct brick_transfer_knot){v, a->r + s * (b->r - a->r), a->g + s * (b->g - a->g),
                                        a->b + s * (b->b - a->b), a->sigma + s * (b->sigma - a->sigma)};
}

/* Linear pieces of the function, those outside the first and the last knot included, in the order of the way.
 */
static struct reference integrate(const struct brick_transfer *t, double front, double back, double length)
{
    struct reference r = {0};
    double lo = fmin(front, back), hi = fmax(front, back), least[3] = {1, 1, 1}, most[3] = {0, 0, 0};
    size_t n = t->count;
    if (lo == hi) {
        struct brick_transfer_knot at = {.value = lo};
        double rgb[3];
        brick_transfer_eval(t, lo, rgb, &at.sigma);
        at.r = rgb[0], at.g = rgb[1], at.b = rgb[2];
        add_linear(&r, length, &at, &at);
        for (size_t i = 0; i < n; i++) /* knots on both sides of it, or at it */
            if ((i + 1 == n || t->knots[i + 1].value >= lo) && (i == 0 || t->knots[i - 1].value <= lo))
                r.most = fmax(r.most, t->knots[i].sigma);
        return r;
    }
    for (size_t i = 0; i <= n; i++) {
        size_t k = back > front ? i : n - i; /* the piece before knot k */
        const struct brick_transfer_knot *a = &t->knots[k ? k - 1 : 0], *b = &t->knots[k < n ? k : n - 1];
        double from = fmax(lo, k ? a->value : lo), to = fmin(hi, k < n ? b->value : hi);
        if (!(from < to) && !(k && k < n && from == to && a->value == b->value))
            continue;
        struct brick_transfer_knot p = k && k < n ? between(a, b, from) : *a;
        struct brick_transfer_knot q = k && k < n ? between(a, b, to) : *b;
        if (!k)
            p = q = t->knots[0];
        else if (k == n)
            p = q = t->knots[n - 1];
        const double c[2][3] = {{p.r, p.g, p.b}, {q.r, q.g, q.b}};
        for (int e = 0; e < 6; e++) {
            least[e % 3] = fmin(least[e % 3], c[e / 3][e % 3]);
            most[e % 3] = fmax(most[e % 3], c[e / 3][e % 3]);
        }
        r.most = fmax(r.most, fmax(a->sigma, b->sigma));
        r.variation += fabs(a->sigma - b->sigma);
        if (k && k < n && a->value == b->value)
            continue;
        add_linear(&r, length * (to - from) / (hi - lo), back > front ? &p : &q, back > front ? &q : &p);
    }
    for (int c = 0; c < 3; c++)
        r.range[c] = fmax(most[c] - least[c], 0.0);
    return r;
}

struct tables {
    struct vr_context *context;
    struct vr_transfer_table table;
    struct vr_buffer pieces, bins, prefixes;
};

static void use_tables(void *data, GLuint program)
{
    struct tables *t = data;
    const struct vr_gl *gl = &t->context->gl;
    vr_buffer_use(&t->pieces, t->context, 1);
    vr_buffer_use(&t->bins, t->context, 2);
    vr_buffer_use(&t->prefixes, t->context, 3);
    gl->Uniform1i(gl->GetUniformLocation(program, "pieces"), 1);
    gl->Uniform1i(gl->GetUniformLocation(program, "bins"), 2);
    gl->Uniform1i(gl->GetUniformLocation(program, "prefixes"), 3);
    gl->Uniform1f(gl->GetUniformLocation(program, "bin_origin"), t->table.bin_origin);
    gl->Uniform1f(gl->GetUniformLocation(program, "bin_scale"), t->table.bin_scale);
    gl->Uniform1f(gl->GetUniformLocation(program, "bin_last"), (float)(t->table.bin_count - 1));
}

static void run(struct shader_bench *b, const struct brick_transfer *transfer, const float *in, float *out)
{
    static const char text[] =
        "uniform usamplerBuffer inputs;\n"
        "layout(rgba32ui, binding = 0) uniform uimage2D words;\n"
        "float word(int i) { return uintBitsToFloat(texelFetch(inputs, i).r); }\n"
        "void main() {\n"
        "    int i = 3 * (int(gl_FragCoord.y) * 256 + int(gl_FragCoord.x));\n"
        "    Stretch s = stretch_of(end_of(word(i)), end_of(word(i + 1)), word(i + 2));\n"
        "    float alpha = opacity(s.depth);\n"
        "    vec3 rgb = s.depth > 0.0 ? alpha * stretch_colour(s, alpha) : vec3(0.0);\n"
        "    imageStore(words, ivec2(gl_FragCoord.xy), floatBitsToUint(vec4(rgb, s.depth)));\n"
        "}\n";
    const struct vr_shader_part parts[] = {{"exponential", vr_shader_exponential},
                                           {"transfer", vr_shader_transfer},
                                           {"preintegrated", vr_shader_preintegrated},
                                           {"test", text}};
    const struct brick_grid grid = {.slope = 1.0};
    struct tables t = {.context = b->context};
    struct vr_prefix *prefixes;
    char defines[64];
    assert_int_equal(vr_transfer_table_init(&t.table, transfer, &grid, NULL), 0);
    assert_int_equal(vr_prefixes_create(&prefixes, &t.table, NULL), 0);
    assert_int_equal(vr_buffer_write(&t.pieces, b->context, GL_RGBA32F, t.table.pieces,
                                     t.table.count * sizeof *t.table.pieces, "test", NULL),
                     0);
    assert_int_equal(vr_buffer_write(&t.bins, b->context, GL_RG32UI, t.table.bins,
                                     t.table.bin_count * sizeof *t.table.bins, "test", NULL),
                     0);
    assert_int_equal(vr_buffer_write(&t.prefixes, b->context, GL_RGBA32UI, prefixes,
                                     t.table.count * sizeof *prefixes, "test", NULL),
                     0);
    snprintf(defines, sizeof defines, "#define PREINTEGRATED\n#define SEARCH_STEPS %u\n",
             t.table.search_steps);
    b->prepare = use_tables;
    b->data = &t;
    uint32_t *bits = malloc(3 * BENCH_COUNT * sizeof *bits);
    memcpy(bits, in, 3 * BENCH_COUNT * sizeof *bits);
    bench_run(b, defines, parts, 4, 3, bits, out);
    free(bits);
    free(prefixes);
    vr_buffer_finish(&t.pieces, b->context);
    vr_buffer_finish(&t.bins, b->context);
    vr_buffer_finish(&t.prefixes, b->context);
    vr_transfer_table_finish(&t.table);
}

static double uniform(uint64_t seed, uint64_t i)
{
    return (double)(noise64(seed, i) >> 11) * 0x1p-53;
}

/* Values at quarters, so that floats hold them: peaks a quarter wide and more, jumps, transparent stretches,
 * opaque ones. */
static struct brick_transfer *random_transfer(uint64_t seed)
{
    struct brick_transfer_point points[24];
    size_t n = 2 + noise64(seed, 0) % 11, count = 0;
    double v = -300.0;
    for (size_t i = 0; i < n; i++) {
        uint64_t kind = noise64(seed, 10 * i + 1) % 8;
        double a = kind < 3 ? 0.0 : kind == 3 ? 1.0 : pow(uniform(seed, 10 * i + 2), 4.0);
        struct brick_transfer_point p = {v, uniform(seed, 10 * i + 3), uniform(seed, 10 * i + 4),
                                         uniform(seed, 10 * i + 5), a};
        points[count++] = p;
        if (kind & 1 && i + 1 < n) { /* a jump */
            p.a = noise64(seed, 10 * i + 6) % 2 ? uniform(seed, 10 * i + 7) : 0.0;
            p.r = uniform(seed, 10 * i + 8);
            points[count++] = p;
        }
        v += 0.25 * ceil(pow(2000.0, uniform(seed, 10 * i + 9)));
    }
    return transfer_of(points, count);
}

static void random_pairs(uint64_t seed, const struct brick_transfer *t, float *in)
{
    const double first = t->knots[0].value - 20.0, width = t->knots[t->count - 1].value + 20.0 - first;
    for (uint64_t i = 0; i < BENCH_COUNT; i++) {
        float *p = in + 3 * i;
        uint64_t kind = noise64(seed, 4 * i) % 8;
        p[0] = (float)(first + width * uniform(seed, 4 * i + 1));
        p[1] = (float)(first + width * uniform(seed, 4 * i + 2));
        p[2] = (float)pow(10.0, 3.5 * uniform(seed, 4 * i + 3) - 3.0);
        if (kind == 0) /* both at knots, or next to them */
            p[0] = (float)t->knots[noise64(seed, 4 * i + 1) % t->count].value;
        if (kind <= 1)
            p[1] = (float)t->knots[noise64(seed, 4 * i + 2) % t->count].value;
        if (kind == 2)
            p[1] = p[0];
        if (kind == 3)
            p[1] = nextafterf(p[0], i & 1 ? FLT_MAX : -FLT_MAX);
        if (kind == 4) /* across a knot by a few units in the last place */
            for (int n = 0; n < 3; n++)
                p[0] = nextafterf(n ? p[0] : p[1], -FLT_MAX);
        if (kind == 5)
            p[1] = p[0] + (float)(0.01 * (uniform(seed, 4 * i + 2) - 0.5));
    }
}

#define DEPTHS 2000

static void test_stretches(void **state)
{
    struct shader_bench *b = *state;
    static float in[3 * BENCH_COUNT], out[4 * BENCH_COUNT];
    static double bound[DEPTHS + 1]; /* of left_out, at depths from 1e-6 to 1e3 */
    double worst_depth = 0.0, worst[3] = {0.0}, tightest = 0.0;
    if (!b->context)
        skip();
    for (int i = 0; i <= DEPTHS; i++)
        bound[i] = left_out(pow(10.0, 9.0 * i / DEPTHS - 6.0));
    for (uint64_t seed = 1; seed <= 12; seed++) {
        struct brick_transfer *transfer = random_transfer(seed);
        random_pairs(seed + 1000, transfer, in);
        run(b, transfer, in, out);
        for (size_t i = 0; i < BENCH_COUNT; i++) {
            const float *p = in + 3 * i, *got = out + 4 * i;
            struct reference r = integrate(transfer, (double)p[0], (double)p[1], (double)p[2]);
            /* An extinction is right to 2^-24 of its piece's largest for each of slope, product, sum and the
             * value's distance; ends, mean, length and sums round as often again. */
            double rounding = 12.0 * 0x1p-24, depth_slack = rounding * (double)p[2] * r.most;
            /* Knots move to the next float. */
            if (p[0] != p[1])
                depth_slack += (double)p[2] / fabs((double)p[1] - (double)p[0]) * 0x1p-23 *
                               fabs((double)fmaxf(fabsf(p[0]), fabsf(p[1]))) * r.variation;
            double error = fabs((double)got[3] - r.depth);
            if (r.depth > 0.0 && !(error <= depth_slack))
                fail_msg("function %d: %.9g to %.9g, %g mm: depth %.9g, not %.9g", (int)seed, (double)p[0],
                         (double)p[1], (double)p[2], (double)got[3], r.depth);
            if (r.depth == 0.0 && got[3] != 0.0f)
                fail_msg("function %d: %.9g to %.9g: nothing there, but depth %g", (int)seed, (double)p[0],
                         (double)p[1], (double)got[3]);
            worst_depth = fmax(worst_depth, r.depth > 0.0 ? error / depth_slack : 0.0);
            int at = (int)ceil((log10(fmax(r.depth, 1e-6)) + 6.0) * DEPTHS / 9.0);
            double model = bound[at < DEPTHS ? at : DEPTHS];
            for (int c = 0; c < 3; c++) {
                double e = fabs((double)got[c] - r.rgb[c]);
                /* Of the colour: mean, moment and weight round like the depth, and all that there is is the
                 * opacity. */
                double slack = 2.0 * rounding * -expm1(-r.depth) + fmin(depth_slack, 1.0);
                if (!(e <= model * r.range[c] + slack))
                    fail_msg(
                        "function %d: %.9g to %.9g, %g mm, depth %g: colour %d is %.9g, not %.9g; bound %g",
                        (int)seed, (double)p[0], (double)p[1], (double)p[2], r.depth, c, (double)got[c],
                        r.rgb[c], model * r.range[c] + slack);
                for (int k = 0; k < 3; k++)
                    if (r.depth < (double[]){0.1, 0.5, 1.0}[k])
                        worst[k] = fmax(worst[k], e);
                if (model * r.range[c] > 10.0 * slack)
                    tightest = fmax(tightest, e / (model * r.range[c]));
            }
        }
        brick_transfer_destroy(&transfer);
    }
    print_message(
        "depth off by up to %.1f x 2^-24 of the largest; colour by up to %.2e, %.2e, %.2e below depths of "
        "0.1, 0.5, 1; by %.2f of the bound\n",
        worst_depth, worst[0], worst[1], worst[2], tightest);
    print_message("bound: %.2e, %.2e, %.2e, %.2e at depths of 0.1, 0.5, 1, 2\n", left_out(0.1), left_out(0.5),
                  left_out(1.0), left_out(2.0));
    for (double d = 0.05; d <= 2.0; d += 0.05) /* what shaders/preintegrated.glsl promises */
        assert_true(left_out(d) <= d * d * d * exp(-d / 2.0) / 56.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_stretches, bench_setup, bench_teardown),
    };
    return cmocka_run_group_tests_name("preintegrated_math", tests, NULL, NULL);
}
