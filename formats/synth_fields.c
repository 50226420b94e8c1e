/* The analytic test fields: constant, ramp, checker, marschner-lobb, shells. Each is a formula of the voxel's
 * coordinates, so that a test can hold any voxel against it. */
#include <math.h>

#include "synth.h"

int synth_constant_init(struct synth_volume *volume, struct brick_error *err)
{
    const double value = volume->value;
    if (!brick_type_is_integer(volume->type))
        return BRICK_OK; /* any float, NaN and infinity included */
    if (!(value >= volume->lo && value <= volume->hi) || value != floor(value))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "constant: %g is not a value of type %s (%g to %g)", value,
                          brick_type_name(volume->type), volume->lo, volume->hi);
    return BRICK_OK;
}

void synth_constant_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                         unsigned n, uint64_t y, float *out)
{
    (void)slice, (void)x, (void)y;
    for (unsigned i = 0; i < n; i++)
        out[i] = (float)volume->value;
}

/* x + y + z. f32: that sum itself, exact below 2^24. Integers: from the type's smallest value at the first
 * voxel to its largest at the last, rounded to nearest. */
void synth_ramp_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                     unsigned n, uint64_t y, float *out)
{
    const uint64_t base = x + y + slice->z;
    const uint64_t last = volume->dims[0] + volume->dims[1] + volume->dims[2] - 3;
    const uint64_t steps = (uint64_t)(volume->hi - volume->lo);
    for (unsigned i = 0; i < n; i++) {
        const uint64_t sum = base + i;
        if (!brick_type_is_integer(volume->type))
            out[i] = (float)sum;
        else /* sum < 2^42, steps < 2^16: no overflow */
            out[i] = (float)volume->lo + (float)(last ? (2 * sum * steps + last) / (2 * last) : 0);
    }
}

/* Single voxels alternate between 0 and a high value: 200 (u8), 100 (i8), 50000 (u16), 20000 (i16), 1 (f32).
 */
void synth_checker_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                        unsigned n, uint64_t y, float *out)
{
    static const float high[BRICK_TYPE_STORED_COUNT] = {200, 100, 50000, 20000, 1};
    for (unsigned i = 0; i < n; i++)
        out[i] = (x + i + y + slice->z) & 1 ? high[volume->type] : 0;
}

/* Sample i of n on [-1, 1], the ends included; 0 when there is but one. */
static double unit_coordinate(uint64_t i, uint64_t n)
{
    return n > 1 ? (2.0 * (double)i - (double)(n - 1)) / (double)(n - 1) : 0;
}

/* S. Marschner, R. Lobb, "An evaluation of reconstruction filters for volume rendering", Visualization '94:
 *   (1 - sin(pi z / 2) + alpha (1 + rho(sqrt(x^2 + y^2)))) / (2 (1 + alpha)),  rho(r) = cos(2 pi f_M cos(pi r
 * / 2)) on [-1, 1]^3 with f_M = 6, alpha = 1/4. It takes values in [0, 1], here scaled to [0, the type's
 * largest]. */
void synth_marschner_lobb_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                               unsigned n, uint64_t y, float *out)
{
    const double frequency = 6, alpha = 0.25, scale = volume->hi / (2 * (1 + alpha));
    const double v = unit_coordinate(y, volume->dims[1]), w = unit_coordinate(slice->z, volume->dims[2]);
    const double along_z = 1 - synth_cos_turns((w - 1) / 4); /* cos(a - pi/2) = sin(a) */
    for (unsigned i = 0; i < n; i++) {
        const double u = unit_coordinate(x + i, volume->dims[0]);
        const double rho = synth_cos_turns(frequency * synth_cos_turns(sqrt(u * u + v * v) / 4));
        out[i] = (float)(scale * (along_z + alpha * (1 + rho)));
    }
}

/* Eight spherical shells about the volume's centre out to half its longest edge, (1 - cos(2 pi 8 r)) / 2 with
 * r = 1 there, scaled to [0, the type's largest]: smooth everywhere, 0 at the centre, and on past r = 1. */
void synth_shells_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                       unsigned n, uint64_t y, float *out)
{
    uint64_t longest = volume->dims[0];
    for (int i = 1; i < 3; i++)
        longest = volume->dims[i] > longest ? volume->dims[i] : longest;
    const double to_r = 1 / (double)longest; /* half an edge is `longest` half voxels */
    const double v = (2.0 * (double)y - (double)(volume->dims[1] - 1)) * to_r;
    const double w = (2.0 * (double)slice->z - (double)(volume->dims[2] - 1)) * to_r;
    for (unsigned i = 0; i < n; i++) {
        const double u = (2.0 * (double)(x + i) - (double)(volume->dims[0] - 1)) * to_r;
        out[i] = (float)(volume->hi * 0.5 * (1 - synth_cos_turns(8 * sqrt(u * u + v * v + w * w))));
    }
}
