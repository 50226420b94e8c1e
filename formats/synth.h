/* Synthetic fields: what source_synth.c (the source: threads, types, geometry) asks of a field.
 *
 * A field is a pure function of the voxel's coordinates: no state between calls, no random sequence, so the
 * bytes depend on neither the thread count nor the slabs in which the volume is read. Values are made in
 * spans: pieces of a row that start at multiples of SYNTH_SPAN, so that rounding too is the same however the
 * volume is read. */
#ifndef FORMATS_SYNTH_H
#define FORMATS_SYNTH_H

#include <stdint.h>

#include <formats/formats.h>

enum { SYNTH_SPAN = 512, SYNTH_MAX_PARTS = 2048 };

struct ct_phantom;

/* What a field needs to know of the volume. */
struct synth_volume {
    uint64_t dims[3];
    enum brick_type type;
    uint64_t seed;
    double value;               /* constant: the stored value */
    double lo, hi;              /* the type's smallest and largest value; 0 and 1 for f32 */
    double slope, intercept;    /* physical = slope * stored + intercept; a field's init may change them */
    struct ct_phantom *phantom; /* ct only; owned */
};

/* What a field may work out once for a slice. */
struct synth_slice {
    uint64_t z;
    unsigned parts; /* ct: parts of the phantom that reach this slice, in painting order */
    uint16_t part[SYNTH_MAX_PARTS];
};

struct synth_field {
    const char *name;
    /* Both may be NULL. */
    int (*init)(struct synth_volume *volume, struct brick_error *err);
    void (*slice)(const struct synth_volume *volume, struct synth_slice *slice);
    /* Stored values, not yet rounded nor clamped, of voxels [x, x + n), n <= SYNTH_SPAN. */
    void (*span)(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x, unsigned n,
                 uint64_t y, float *out);
};

/* Analytic fields, in synth_fields.c. */
int synth_constant_init(struct synth_volume *volume, struct brick_error *err);
void synth_constant_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                         unsigned n, uint64_t y, float *out);
void synth_ramp_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                     unsigned n, uint64_t y, float *out);
void synth_checker_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                        unsigned n, uint64_t y, float *out);
void synth_marschner_lobb_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                               unsigned n, uint64_t y, float *out);
void synth_shells_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x,
                       unsigned n, uint64_t y, float *out);

/* The body phantom, in synth_ct.c. */
int synth_ct_init(struct synth_volume *volume, struct brick_error *err);
void synth_ct_slice(const struct synth_volume *volume, struct synth_slice *slice);
void synth_ct_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x, unsigned n,
                   uint64_t y, float *out);
void synth_ct_finish(struct synth_volume *volume);

/* cos(2 pi turns), right to 1e-15 + 2^-52 |turns|, from additions and multiplications alone: the same bits on
 * every machine, which the C library does not promise. |turns| < 2^50. */
static inline double synth_cos_turns(double turns)
{
    const double to_integer = 6755399441055744.0;           /* 1.5 * 2^52: adding it rounds to an integer */
    double t = turns - ((turns + to_integer) - to_integer); /* [-1/2, 1/2] */
    t = t < 0 ? -t : t;
    const double sign = t > 0.25 ? -1.0 : 1.0;
    t = t > 0.25 ? 0.5 - t : t; /* [0, 1/4] */
    const double a = 6.283185307179586476925 * t, u = -a * a;
    /* Taylor's series to a^20; the next term is below 2e-17 at pi/2. */
    const double s =
        1.0 + u * (1 / 2.0 +
                   u * (1 / 24.0 +
                        u * (1 / 720.0 +
                             u * (1 / 40320.0 +
                                  u * (1 / 3628800.0 + u * (1 / 479001600.0 +
                                                            u * (1 / 87178291200.0 +
                                                                 u * (1 / 20922789888000.0 +
                                                                      u * (1 / 6402373705728000.0 +
                                                                           u / 2432902008176640000.0)))))))));
    return sign * s;
}

#endif
