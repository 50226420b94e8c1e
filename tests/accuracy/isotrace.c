/* Hits of isotrace against the long double reference and against planes and spheres, ray by ray: hit or miss,
 * and where. Rays are random, grazing, along the axes, in faces and along edges of cells; volumes are noise,
 * plateaus at the isovalue, and have NaN cells. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <brick/cache.h>

#include "../support/memory_source.h"
#include "iso_reference.h"
#include "map.h"
#include "pins.h"
#include "split.h"
#include "walk.h"

/* One ray at a time through an open volume. */
struct tracer {
    const struct brick_volume *volume;
    struct brick_cache *cache;
    struct vr_iso_frame frame;
    struct vr_iso_activity activity;
    struct vr_iso_pin pin;
    struct vr_iso_walk walk;
    struct vr_iso_map map;
};

static void tracer_init(struct tracer *t, const struct brick_volume *volume, uint32_t level, double isovalue)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_level *l = &grid->level[level];
    memset(t, 0, sizeof *t);
    t->volume = volume;
    assert_int_equal(brick_cache_create(&t->cache, volume, brick_grid_max_payload_bytes(grid), NULL),
                     BRICK_OK);
    t->frame = (struct vr_iso_frame){.grid = grid,
                                     .level = l,
                                     .kernel = vr_iso_kernel_of(grid->type, false),
                                     .surface = {{.isovalue = isovalue, .opacity = 1.0}},
                                     .surfaces = 1,
                                     .map = &t->map,
                                     .skip = true};
    vr_iso_split(grid, &t->frame.surface[0]);
    assert_int_equal(vr_iso_map_make(&t->map, volume, &t->frame, NULL), BRICK_OK);
    t->pin = (struct vr_iso_pin){.grid = grid, .cache = t->cache};
    t->walk = (struct vr_iso_walk){.frame = &t->frame, .activity = &t->activity, .want_gradient = true};
}

static void tracer_finish(struct tracer *t)
{
    vr_iso_pin_release(&t->pin);
    vr_iso_walk_finish(&t->walk);
    brick_cache_destroy(&t->cache);
    vr_iso_map_finish(&t->map);
}

/* Distance of the first hit, or -1. */
static double first_hit(struct tracer *t, const struct brick_ray *ray, double enter, double leave)
{
    struct brick_error err;
    vr_iso_start(&t->walk, ray, enter, leave);
    if (vr_iso_trace(&t->walk, 1, &t->pin, &err))
        fail_msg("%s", err.message);
    return t->walk.hit_count ? t->walk.hits[0].t : -1.0;
}

static double *read_level(const struct brick_volume *volume, uint32_t level, struct reference_volume *v)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_level *l = &grid->level[level];
    size_t count = (size_t)(l->dims[0] * l->dims[1] * l->dims[2]);
    void *stored = malloc(count * brick_type_bytes(grid->type));
    double *physical = malloc(count * sizeof *physical);
    assert_int_equal(brick_volume_read_box(volume, level, (uint64_t[3]){0, 0, 0}, l->dims, stored, NULL),
                     BRICK_OK);
    for (size_t i = 0; i < count; i++)
        physical[i] = grid->slope * brick_type_load(grid->type, stored, i) + grid->intercept;
    for (int i = 0; i < 3; i++) {
        v->dims[i] = (int64_t)l->dims[i];
        v->scale[i] = l->scale[i];
        v->offset[i] = l->offset[i];
    }
    v->voxels = physical;
    free(stored);
    return physical;
}

/* Rays in index0 coordinates, at a pace of one voxel: anywhere, or through lattice points, along axes, in
 * faces. */
static struct brick_ray random_ray(unsigned long long *seed, const struct brick_grid *grid, int kind)
{
    struct brick_ray ray;
    double norm = 0.0;
    int along = (int)(3.0 * reference_random(seed));
    for (int i = 0; i < 3; i++) {
        double n = (double)grid->dims[i], at = n * reference_random(seed) - 0.5;
        double towards = 2.0 * reference_random(seed) - 1.0;
        switch (kind) {
        case 0: /* anywhere */
            break;
        case 1: /* along an axis, anywhere */
            towards = i == along ? (towards < 0.0 ? -1.0 : 1.0) : 0.0;
            break;
        case 2: /* along an axis, in faces and edges of cells and bricks */
            at = floor(at + 0.5);
            towards = i == along ? (towards < 0.0 ? -1.0 : 1.0) : 0.0;
            break;
        default: /* through voxels, along diagonals: through corners and edges all the way */
            at = floor(at + 0.5);
            towards = towards < -0.3 ? -1.0 : towards < 0.3 ? 0.0 : 1.0;
        }
        ray.origin[i] = at;
        ray.direction[i] = towards;
        norm += towards * towards;
    }
    if (norm == 0.0)
        ray.direction[along] = 1.0;
    if (kind == 0)
        for (int i = 0; i < 3; i++)
            ray.direction[i] /= sqrt(norm);
    for (int i = 0; i < 3; i++)
        ray.origin[i] -= 64.0 * ray.direction[i];
    return ray;
}

struct tally {
    int hits, misses, undecidable;
    double worst;
};

/* Every ray of every kind. Where an extremum comes within rounding of the isovalue either answer is right. */
static void compare(const struct brick_volume *volume, uint32_t level, double isovalue, double scale,
                    int kinds, int rays, struct tally *tally)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    struct tracer t;
    struct reference_volume v = {0};
    double *physical = read_level(volume, level, &v);
    unsigned long long seed = 11;
    tracer_init(&t, volume, level, isovalue);
    for (int i = 0; i < rays; i++) {
        struct brick_ray ray = random_ray(&seed, grid, i % kinds);
        double enter, leave;
        if (!brick_ray_span(&ray, grid, &enter, &leave))
            continue;
        double t_hit = first_hit(&t, &ray, enter, leave);
        struct iso_reference r = iso_reference_ray(&v, &ray, isovalue, enter, leave, (long double)scale);
        bool hit = t_hit >= 0.0;
        if (hit == r.hit && (!hit || fabs(t_hit - (double)r.t) < 1e-6)) {
            tally->hits += hit;
            tally->misses += !hit;
            if (hit)
                tally->worst = fmax(tally->worst, fabs(t_hit - (double)r.t));
        } else if (r.nearest < 1e-13L * (long double)scale) {
            tally->undecidable++;
        } else {
            /* A root that a touching extremum has spread: the field there must be the isovalue to rounding.
             */
            long double f = hit ? iso_reference_field(&v, (long double)t_hit) : INFINITY;
            if (!(hit && r.hit && fabsl(f - isovalue) < 1e-12L * (long double)scale &&
                  fabs(t_hit - (double)r.t) < 1e-3))
                fail_msg("ray %d: %s at %.12g, reference %s at %.12g (nearest %.3g)", i, hit ? "hit" : "miss",
                         t_hit, r.hit ? "hit" : "miss", (double)r.t, (double)r.nearest);
        }
    }
    tracer_finish(&t);
    free(physical);
}

enum { NX = 37, NY = 22, NZ = 29, COUNT = NX * NY * NZ };

static struct brick_volume *make(enum brick_type type, const void *voxels, double slope, double intercept,
                                 uint32_t edge)
{
    struct memory_source source;
    struct brick_build_params params = brick_build_defaults;
    memory_source_init(&source, type, NX, NY, NZ, voxels);
    source.base.geometry.slope = slope;
    source.base.geometry.intercept = intercept;
    params.edge = edge;
    return build_and_open(&source, "iso.brick", &params);
}

static void noise_agrees(void **state)
{
    static int16_t voxels[COUNT];
    struct tally tally = {0};
    (void)state;
    for (uint64_t i = 0; i < COUNT; i++)
        voxels[i] = (int16_t)(noise64(7, i) % 2001);
    for (uint32_t edge = 8; edge <= 16; edge += 8) {
        struct brick_volume *volume = make(BRICK_I16, voxels, -0.37, 100.1, edge);
        for (int k = 0; k < 3;
             k++) /* few, half and nearly all of the voxels above: rays that graze, rays that hit */
            compare(volume, 0, -0.37 * (k == 0 ? 40 : k == 1 ? 1000 : 1960) + 100.1, 640.0, 4, 3000, &tally);
        compare(volume, 1, -0.37 * 1000 + 100.1, 640.0, 4, 2000, &tally);
        brick_volume_close(&volume);
    }
    print_message("%d hits, %d misses, %d undecidable, worst %.3g voxels\n", tally.hits, tally.misses,
                  tally.undecidable, tally.worst);
    assert_true(tally.hits > 5000 && tally.misses > 500);
    assert_int_equal(tally.undecidable, 0);
}

/* Values 0 to 3, isovalue 2: whole faces and cells lie at it, on it and touching it. Touching from below is a
 * change of side, from above is none, and double is exact for rays along axes. */
static void plateaus_agree(void **state)
{
    static uint8_t voxels[COUNT];
    struct tally tally = {0};
    (void)state;
    for (uint64_t i = 0; i < COUNT; i++)
        voxels[i] = (uint8_t)(noise64(5, i / 3) % 4);
    struct brick_volume *volume = make(BRICK_U8, voxels, 1.0, 0.0, 8);
    for (int v = 1; v <= 3; v++)
        compare(volume, 0, v, 3.0, 3, 4000, &tally);
    print_message("%d hits, %d misses, %d undecidable, worst %.3g voxels\n", tally.hits, tally.misses,
                  tally.undecidable, tally.worst);
    assert_true(tally.hits > 5000);
    assert_true(tally.undecidable < 20);
    brick_volume_close(&volume);
}

/* Sparse NaN and Inf, and values over sixty decades: cells with one have no side and bound no surface. */
static void nan_cells_have_no_side(void **state)
{
    static float voxels[COUNT];
    struct tally tally = {0};
    (void)state;
    for (uint64_t i = 0; i < COUNT; i++) {
        uint64_t r = noise64(9, i);
        voxels[i] = r % 25 == 0 ? (r & 64 ? NAN : -INFINITY) : (float)(r % 1000);
    }
    struct brick_volume *volume = make(BRICK_F32, voxels, 1.0, 0.0, 8);
    compare(volume, 0, 70.0, 1000.0, 1, 4000, &tally);
    compare(volume, 0, 500.0, 1000.0, 1, 4000, &tally);
    brick_volume_close(&volume);
    for (uint64_t i = 0; i < COUNT; i++)
        voxels[i] = (float)((double)(noise64(9, i) % 1000) * 1e27);
    volume = make(BRICK_F32, voxels, 1.0, 0.0, 8);
    compare(volume, 0, 5e29, 1e30, 4, 4000, &tally);
    brick_volume_close(&volume);
    for (uint64_t i = 0; i < COUNT; i++)
        voxels[i] = (float)(noise64(9, i) % 1000) * 1.4e-45f;
    volume = make(BRICK_F32, voxels, 1.0, 0.0, 8);
    compare(volume, 0, 500 * 1.401298464324817e-45, 1e-42, 3, 4000, &tally);
    brick_volume_close(&volume);
    print_message("%d hits, %d misses, %d undecidable, worst %.3g voxels\n", tally.hits, tally.misses,
                  tally.undecidable, tally.worst);
    assert_true(tally.hits > 5000);
    assert_true(tally.undecidable < 20);
}

/* A skipped block with NaN inside must not make a surface at its end: above, then NaN, then below. */
static void nothing_between_nan(void **state)
{
    static float voxels[COUNT];
    (void)state;
    for (uint64_t i = 0; i < COUNT; i++) {
        uint64_t x = i % NX;
        voxels[i] = x < 15 ? 10.0f : x == 15 ? NAN : -10.0f;
    }
    struct brick_volume *volume = make(BRICK_F32, voxels, 1.0, 0.0, 8);
    struct tracer t;
    unsigned long long seed = 3;
    tracer_init(&t, volume, 0, 0.0);
    for (int i = 0; i < 1000; i++) {
        struct brick_ray ray = random_ray(&seed, brick_volume_grid(volume), i % 4);
        double enter, leave;
        if (brick_ray_span(&ray, brick_volume_grid(volume), &enter, &leave))
            assert_true(first_hit(&t, &ray, enter, leave) < 0.0);
    }
    tracer_finish(&t);
    brick_volume_close(&volume);
}

/* A linear field is its own trilinear interpolant. */
static void planes_are_exact(void **state)
{
    static float voxels[COUNT];
    double worst = 0.0;
    int hits = 0;
    (void)state;
    for (int i = 0; i < COUNT; i++)
        voxels[i] = (float)(3 * (i % NX) - 5 * (i / NX % NY) + 2 * (i / (NX * NY)));
    struct brick_volume *volume = make(BRICK_F32, voxels, 0.5, 1.0, 16);
    struct tracer t;
    unsigned long long seed = 17;
    tracer_init(&t, volume, 0, 4.125);
    for (int i = 0; i < 4000; i++) {
        struct brick_ray ray = random_ray(&seed, brick_volume_grid(volume), i % 2);
        /* Not across the border of half a voxel, where the field is constant on an axis. */
        struct brick_grid inner = *brick_volume_grid(volume);
        double enter, leave, lo = 0.0, hi = 1e9;
        for (int k = 0; k < 3; k++) {
            double a = (0.0 - ray.origin[k]) / ray.direction[k];
            double b = ((double)inner.dims[k] - 1.0 - ray.origin[k]) / ray.direction[k];
            if (ray.direction[k] == 0.0) {
                if (ray.origin[k] < 0.0 || ray.origin[k] > (double)inner.dims[k] - 1.0)
                    hi = -1e9;
            } else {
                lo = fmax(lo, fmin(a, b));
                hi = fmin(hi, fmax(a, b));
            }
        }
        if (!brick_ray_span(&ray, &inner, &enter, &leave) || fmax(lo, enter) >= fmin(hi, leave))
            continue;
        double d = 3 * ray.direction[0] - 5 * ray.direction[1] + 2 * ray.direction[2];
        lo = fmax(lo, enter);
        hi = fmin(hi, leave);
        double at = (6.25 - (3 * ray.origin[0] - 5 * ray.origin[1] + 2 * ray.origin[2])) / d;
        double found = first_hit(&t, &ray, lo, hi);
        if (fabs(at - lo) < 1e-9 || fabs(at - hi) < 1e-9 || fabs(d) < 1e-3)
            continue;
        assert_true((found >= 0.0) == (at > lo && at < hi));
        if (found >= 0.0) {
            worst = fmax(worst, fabs(found - at) * fabs(d));
            hits++;
        }
    }
    print_message("%d hits, worst %.3g of the field\n", hits, worst);
    assert_true(hits > 500);
    assert_true(worst < 1e-11); /* rounding of t (64 + voxels) and of values to 200 */
    tracer_finish(&t);
    brick_volume_close(&volume);
}

/* x^2 + y^2 + z^2 lies below its trilinear interpolant by at most 1/4 a dimension: the hit's radius is in a
 * narrow ring, and its gradient is radial but for the interpolation. */
static void spheres_are_round(void **state)
{
    static uint16_t voxels[COUNT];
    const double c[3] = {18, 10, 14}, r2 = 9.5 * 9.5;
    int hits = 0;
    (void)state;
    for (int i = 0; i < COUNT; i++) {
        double x = i % NX - c[0], y = i / NX % NY - c[1], z = i / (NX * NY) - c[2];
        voxels[i] = (uint16_t)(x * x + y * y + z * z);
    }
    struct brick_volume *volume = make(BRICK_U16, voxels, 1.0, 0.0, 8);
    struct tracer t;
    unsigned long long seed = 23;
    tracer_init(&t, volume, 0, r2);
    for (int i = 0; i < 4000; i++) {
        struct brick_ray ray = random_ray(&seed, brick_volume_grid(volume), i % 4);
        double enter, leave, p2 = 0.0, pg = 0.0, g2 = 0.0, od = 0.0, dd = 0.0, oo = 0.0;
        if (!brick_ray_span(&ray, brick_volume_grid(volume), &enter, &leave))
            continue;
        double found = first_hit(&t, &ray, enter, leave);
        for (int k = 0; k < 3; k++) {
            double o = ray.origin[k] - c[k], p = o + found * ray.direction[k],
                   g = t.walk.hits ? t.walk.hits[0].gradient[k] : 0;
            od += o * ray.direction[k];
            dd += ray.direction[k] * ray.direction[k];
            oo += o * o;
            p2 += p * p;
            pg += p * g;
            g2 += g * g;
        }
        double closest2 = oo - od * od / dd;
        assert_true(found >= 0.0 || closest2 > r2 - 0.75 || od > 0.0);
        assert_true(found < 0.0 || closest2 <= r2);
        if (found >= 0.0) {
            assert_true(p2 <= r2 + 1e-9 && p2 >= r2 - 0.75 - 1e-9);
            assert_true(pg / sqrt(p2 * g2) > 0.999);
            hits++;
        }
    }
    assert_true(hits > 800);
    tracer_finish(&t);
    brick_volume_close(&volume);
}

/* A ragged wall between below and above, of values over sixty decades, so that every interpolation rounds;
 * rays through voxels, along edges and diagonals, and beside them by a hair, from one side to the other. Each
 * must change side an odd number of times: one lost between two cells makes it even. All hits are kept, as
 * nothing is opaque. */
static void no_ray_slips_through(void **state)
{
    enum { S = 40 };
    static float voxels[S * S * S];
    unsigned long long seed = 31;
    int rays = 0, many = 0;
    (void)state;
    for (uint64_t i = 0; i < S * S * S; i++) {
        uint64_t x = i % S, wall = 14 + noise64(41, i / S) % 12;
        double size = pow(10.0, (double)(noise64(42, i) % 60) - 29.0);
        voxels[i] = (float)(x < wall ? -size : size);
    }
    struct memory_source source;
    struct brick_build_params params = brick_build_defaults;
    memory_source_init(&source, BRICK_F32, S, S, S, voxels);
    params.edge = 8;
    params.macrocell = 4;
    struct brick_volume *volume = build_and_open(&source, "wall.brick", &params);
    struct tracer t;
    tracer_init(&t, volume, 0, 1e-35);
    t.frame.surface[0].opacity = 0.0;
    for (int i = 0; i < 60000; i++) {
        struct brick_ray ray;
        double enter, leave;
        int kind = i % 4;
        for (int k = 0; k < 3; k++) { /* through a voxel in the wall, mostly along x */
            ray.origin[k] = floor(14.0 + 12.0 * reference_random(&seed));
            ray.direction[k] = floor(3.0 * reference_random(&seed)) - 1.0;
            if (kind == 1)
                ray.direction[k] *= 0.1 * floor(1.0 + 9.0 * reference_random(&seed));
            if (kind == 2 && k)
                ray.direction[k] *= 1e-16;
            if (kind == 3)
                ray.origin[k] += 0x1p-48 * floor(3.0 * reference_random(&seed) - 1.0);
        }
        ray.direction[0] = reference_random(&seed) < 0.5 ? -1.0 : 1.0;
        for (int k = 0; k < 3; k++)
            ray.origin[k] -= 64.0 * ray.direction[k];
        if (!brick_ray_span(&ray, brick_volume_grid(volume), &enter, &leave))
            continue;
        double x0 = ray.origin[0] + enter * ray.direction[0], x1 = ray.origin[0] + leave * ray.direction[0];
        if (fmin(x0, x1) > 12.0 || fmax(x0, x1) < 27.0)
            continue; /* not all the way through */
        first_hit(&t, &ray, enter, leave);
        if (t.walk.hit_count % 2 == 0)
            fail_msg("ray %d of kind %d changes side %zu times", i, kind, t.walk.hit_count);
        rays++;
        many += t.walk.hit_count > 1;
    }
    print_message("%d rays, %d of them change side more than once\n", rays, many);
    assert_true(rays > 10000 && many > 1000);
    tracer_finish(&t);
    brick_volume_close(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_agrees),           cmocka_unit_test(plateaus_agree),
        cmocka_unit_test(nan_cells_have_no_side), cmocka_unit_test(nothing_between_nan),
        cmocka_unit_test(planes_are_exact),       cmocka_unit_test(spheres_are_round),
        cmocka_unit_test(no_ray_slips_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
