/* Up to 10^4 slices through a homogeneous volume, where all roundings go the same way (Wilson et al. 1994,
 * section 2.1.1), in all precisions of textures and framebuffers and for extinctions of a slice from 1e-12 to
 * 1e3, against what theory says.
 *
 * Textures. A channel of n bits is off by half a unit of 2^-n at most, and by the same amount in every slice:
 * m slices of a rounded opacity A let through (1 - A)^m exactly, as far as the framebuffer goes.
 *
 * Framebuffers. Each of m blends rounds to nearest: half a unit of 1/255, or 2^-12 of a number's power of two
 * for 16-bit floats, 2^-25 for 32-bit ones. What a slice adds is lost where it is smaller than that. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "gl_scene.h"

#define N 8 /* voxels of 1 mm: rays along an axis pass m = N / spacing slices */

struct setting {
    struct memory_source source;
    struct brick_volume *volume;
    struct vr_renderer *renderer;
    struct brick_transfer *transfer; /* its one knot is set at will */
    struct vr_scene scene;
    struct vr_quality quality;
};

static int set_up(void **state)
{
    static struct setting s;
    static int16_t voxels[N * N * N];
    static const struct brick_transfer_point point = {0, 0.5, 0.25, 1, 0.5};
    memory_source_init(&s.source, BRICK_I16, N, N, N, voxels);
    s.volume = volume_of(&s.source, 8);
    s.renderer = try_renderer(s.volume, VR_CONTEXT_AUTO);
    s.transfer = transfer_of(&point, 1);
    s.scene = vr_scene_defaults;
    s.scene.width = s.scene.height = 3;
    s.scene.transfer = s.transfer;
    brick_camera_orbit(&s.scene.camera, brick_volume_grid(s.volume), 0, 0, 0, 3, 1.0);
    *state = &s;
    return 0;
}

static int tear_down(void **state)
{
    struct setting *s = *state;
    vr_renderer_destroy(&s->renderer);
    brick_transfer_destroy(&s->transfer);
    brick_volume_close(&s->volume);
    return 0;
}

/* Planes such that `slices` lie in the volume, the first and the last one cut to their half or so. */
static void set_slices(struct setting *s, int slices)
{
    s->quality = vr_quality_defaults;
    s->quality.method = VR_METHOD_SLICES;
    s->quality.termination = 0.0;
    s->quality.slices.planes = (uint32_t)lrint(slices * sqrt(3.0));
}

static double spacing_of(const struct setting *s)
{
    return sqrt(3.0) * N / s->quality.slices.planes;
}

/* The middle pixel, for an opacity of one slice's thickness. */
static void draw(struct setting *s, double depth_of_a_slice, float rgba[4])
{
    struct brick_image image;
    s->transfer->knots[0].sigma = depth_of_a_slice / spacing_of(s);
    brick_transfer_set_emission(s->transfer, s->transfer->emission);
    render(s->renderer, &s->scene, &s->quality, &image, NULL);
    memcpy(rgba, image.rgba + 4 * 4, 4 * sizeof *rgba);
    brick_image_finish(&image);
}

/* 32 bits all the way: right to what 32-bit blends round, whatever the extinction. Emission that does not
 * depend on extinction included, where (1 - exp(-x)) / x must find its limit. */
static void extinctions(void **state)
{
    struct setting *s = *state;
    if (!s->renderer)
        skip();
    for (int order = 0; order < 2; order++)
        for (int independent = 0; independent < 2; independent++)
            for (int e = -12; e <= 3; e++) {
                float rgba[4];
                double x = pow(10.0, e), depth;
                set_slices(s, 10000);
                s->quality.slices.back_to_front = order;
                s->transfer->emission = independent ? BRICK_EMISSION_INDEPENDENT : BRICK_EMISSION_SCALED;
                draw(s, x, rgba);
                depth = x / spacing_of(s) * N;
                /* the sum's roundings, and 2^-22 of float32 in extinction and length, for all slices alike */
                double alpha = -expm1(-depth), error = 10002 * 0x1p-24 + 0x1p-22;
                double colour = independent ? N / s->transfer->unit_mm * (alpha / depth) : alpha;
                if (fabs(rgba[3] - alpha) > error * alpha || fabs(rgba[2] - colour) > error * colour)
                    fail_msg("depth of a slice %g: alpha %g is not %g, or blue %g not %g", x, rgba[3], alpha,
                             rgba[2], colour);
            }
    s->transfer->emission = BRICK_EMISSION_SCALED;
}

/* A = 1, clamped to 1 - 2^-24: opaque, and nothing that is not finite. */
static void opaque(void **state)
{
    struct setting *s = *state;
    if (!s->renderer)
        skip();
    for (int pre = 0; pre < 4; pre++)
        for (int n = 1; n <= 10000; n *= 10) {
            float rgba[4];
            set_slices(s, n);
            s->quality.classification = pre ? VR_CLASSIFY_PRE : VR_CLASSIFY_POST;
            s->quality.slices.classified_bits = pre ? 4u << pre : 32;
            draw(s, 24.0 * log(2.0) * spacing_of(s), rgba);
            /* one slice or many: the volume is 8 mm of 2^-24 */
            assert_true(rgba[3] >= 1.0f - (float)(n + 2) * 0x1p-22f && rgba[3] <= 1.0f + 0x1p-22f);
        }
}

/* Rounded textures: the error of one slice, m times. */
static void textures(void **state)
{
    struct setting *s = *state;
    if (!s->renderer)
        skip();
    print_message("error of alpha, of 1 - exp(-1): slices, textures of 8, 16, 32 bits\n");
    for (int n = 10; n <= 10000; n *= 10) {
        double off[3];
        for (int b = 0; b < 3; b++) {
            float rgba[4];
            const double most = b == 0 ? 255.0 : 65535.0;
            set_slices(s, n);
            s->quality.classification = VR_CLASSIFY_PRE;
            s->quality.slices.classified_bits = 8u << b;
            const double slices = N / spacing_of(s); /* parts of cut ones included */
            draw(s, 1.0 / slices, rgba);
            double a = -expm1(-1.0 / slices), rounded = b < 2 ? rint(a * most) / most : a;
            double predicted = -expm1(slices * log1p(-rounded)), truth = -expm1(-1.0);
            off[b] = rgba[3] - truth;
            if (fabs(rgba[3] - predicted) > (n + 2) * 0x1p-24 + 0x1p-22)
                fail_msg("%d slices, %d bits: %g is not %g", n, 8 << b, rgba[3], predicted);
            /* the paper's bound: half a unit a slice */
            assert_true(fabs(off[b]) <= (slices + 1) * (b < 2 ? 0.5 / most : 0x1p-23));
        }
        print_message("%6d  %+.2e  %+.2e  %+.2e\n", n, off[0], off[1], off[2]);
    }
}

/* What a sum of roundings to nearest leaves, in numbers with so many units in the power of two, or in all of
 * [0,1] (8 bits). */
static double simulate(double a, int slices, bool halves, bool back_to_front)
{
    double sum = 0.0;
    for (int i = 0; i < slices; i++) {
        double next = back_to_front ? a + (1.0 - a) * sum : sum + (1.0 - sum) * a;
        int exponent;
        frexp(next, &exponent);
        double unit = halves ? ldexp(1.0, exponent - 11) : 1.0 / 255.0;
        sum = rint(next / unit) * unit;
    }
    return sum;
}

/* Rounded framebuffers: what a slice adds is lost when it is less than half a unit. */
static void framebuffers(void **state)
{
    struct setting *s = *state;
    if (!s->renderer)
        skip();
    print_message("error of alpha, of 1 - exp(-1): slices, framebuffers of 8, 16f, 32f\n");
    for (int order = 0; order < 2; order++)
        for (int n = 10; n <= 10000; n *= 10) {
            double off[3];
            for (int b = 0; b < 3; b++) {
                float rgba[4];
                set_slices(s, n);
                s->quality.slices.framebuffer = (enum vr_framebuffer)b;
                s->quality.slices.back_to_front = order;
                const double slices = N / spacing_of(s), a = -expm1(-1.0 / slices), truth = -expm1(-1.0);
                draw(s, 1.0 / slices, rgba);
                off[b] = rgba[3] - truth;
                /* never more than half a unit a blend, and half of one for what is blended */
                double unit = b == 0 ? 1.0 / 255.0 : b == 1 ? 0x1p-11 : 0x1p-24;
                assert_true(fabs(off[b]) <= (slices + 2) * unit);
                /* less than half of 1/255 is nothing, however often */
                if (b == 0 && a < 0.5 / 255.0 * 0.999)
                    assert_true(rgba[3] == 0.0f);
                /* halves: a sum stands still where a unit is twice what is added, within a power of two for
                 * drivers that round towards zero */
                if (b == 1 && n == 10000)
                    assert_true(rgba[3] <= 1.01 * simulate(a, n, true, order));
            }
            print_message("%6d  %+.2e  %+.2e  %+.2e%s\n", n, off[0], off[1], off[2],
                          order ? "  (back to front)" : "");
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(extinctions),
        cmocka_unit_test(opaque),
        cmocka_unit_test(textures),
        cmocka_unit_test(framebuffers),
    };
    return cmocka_run_group_tests_name("slices_rounding", tests, set_up, tear_down);
}
