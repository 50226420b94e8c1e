/* Rays in modes iso, mip and shaded, and through the other fields, against slow and simple answers. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "field.h"
#include "memory_cells.h"
#include "trace.h"

#define TOLERANCE 1e-10

static const struct brick_grid grid = {.dims = {NX, NY, NZ}};

static void near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance))
        fail_msg("%.17g is not %.17g: %.3g off, %.3g allowed", a, b, a - b, tolerance);
}

static const double identity[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
/* A sheared voxel, in mm, and its inverse transposed times the determinant. */
static const double sheared[3][3] = {{0.8, -0.35, 0.1}, {0.6, 0.75, -0.2}, {0.05, 0.2, 1.6}};

static struct vr_look look_of(enum brick_mode mode, const struct brick_transfer *transfer,
                              const double m[3][3])
{
    struct vr_look look = {.mode = mode,
                           .transfer = transfer,
                           .tolerance = TOLERANCE,
                           .surface = {1.0, 0.5, 0.25},
                           .ambient = 0.2,
                           .diffuse = 0.7,
                           .specular = 0.3,
                           .shininess = 20.0};
    memcpy(look.linear, m, sizeof look.linear);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) { /* cofactors: the inverse transposed, but for a factor */
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            look.normal[i][k] = m[i1][k1] * m[i2][k2] - m[i1][k2] * m[i2][k1];
        }
    return look;
}

static struct brick_ray random_ray(unsigned long long *seed, const double m[3][3])
{
    struct brick_ray ray;
    double length = 0.0;
    for (int a = 0; a < 3; a++) {
        double target = (reference_random(seed) * 1.1 - 0.05) * (double)grid.dims[a] - 0.5;
        ray.origin[a] = reference_random(seed) * 14.0 - 4.0;
        ray.direction[a] = target - ray.origin[a];
    }
    for (int i = 0; i < 3; i++) {
        double mm = 0.0;
        for (int a = 0; a < 3; a++)
            mm += m[i][a] * ray.direction[a];
        length = hypot(length, mm);
    }
    for (int a = 0; a < 3; a++)
        ray.direction[a] /= length;
    return ray;
}

/* The field on tetrahedra by brute force: of all five, the one that holds the point, by determinants. */
static long double determinant(const long double a[3], const long double b[3], const long double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

static long double tetrahedra_value(const struct memory_cells *m, const long double p[3])
{
    static const int even[5][4] = {{0, 3, 5, 6}, {1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}};
    long double x[3], best = -1.0L, value = 0.0L;
    int64_t cell[3], sum = 0;
    for (int a = 0; a < 3; a++) {
        long double q = fminl(fmaxl(p[a], 0.0L), (long double)m->cells.dims[a] - 1.0L);
        cell[a] = (int64_t)floorl(q);
        x[a] = q - (long double)cell[a];
        sum += cell[a];
    }
    for (int n = 0; n < 5; n++) {
        long double corner[4][3], f[4], total = 0.0L, weight[4], least = 1.0L;
        for (int k = 0; k < 4; k++) {
            int bits = even[n][k] ^ (int)(sum & 1) * 7; /* an odd cell has the opposite corners */
            int64_t at[3];
            for (int a = 0; a < 3; a++) {
                corner[k][a] = bits >> a & 1;
                at[a] = reference_clamp(cell[a] + (bits >> a & 1), (int64_t)m->cells.dims[a]);
            }
            f[k] = m->voxels[(at[2] * NY + at[1]) * NX + at[0]];
        }
        for (int k = 0; k < 4; k++) {
            long double e[3][3];
            for (int j = 0; j < 3; j++)
                for (int a = 0; a < 3; a++)
                    e[j][a] = corner[(k + 1 + j) % 4][a] - x[a];
            weight[k] = determinant(e[0], e[1], e[2]) * (k % 2 ? -1.0L : 1.0L);
            total += weight[k];
        }
        for (int k = 0; k < 4; k++)
            least = fminl(least, weight[k] / total);
        if (least > best) {
            best = least;
            value = 0.0L;
            for (int k = 0; k < 4; k++)
                value += weight[k] / total * f[k];
        }
    }
    assert_true(best > -1e-12L);
    return value;
}

/* The field at t. */
static double value_at(const struct memory_cells *m, enum vr_field field, const struct brick_ray *ray,
                       double t)
{
    struct reference_volume v = volume_of(m);
    long double p[3];
    v.ray = ray;
    reference_position(&v, t, p);
    return (double)(field == VR_FIELD_TETRAHEDRA ? tetrahedra_value(m, p) : reference_value(&v, p));
}

static const enum vr_field fields[] = {VR_FIELD_TRILINEAR, VR_FIELD_TETRAHEDRA};

struct segments_seen {
    const struct memory_cells *m;
    enum vr_field field;
    const struct brick_ray *ray;
    double last; /* value at the end of the segment before */
    int count;
};

static int check_segments(void *context, struct vr_cells *cells, const struct vr_step *step,
                          struct brick_error *err)
{
    struct segments_seen *seen = context;
    struct vr_segment segments[VR_MAX_SEGMENTS];
    int n = vr_field_segments(seen->field, cells, step, segments);
    double at = 0.0;
    (void)err;
    assert_true(n > 0);
    for (int i = 0; i < n; i++) {
        assert_true(segments[i].a == at && segments[i].b > at);
        at = segments[i].b;
        for (int k = 0; k <= 4; k++) {
            double s = segments[i].a + k / 4.0 * (segments[i].b - segments[i].a);
            double t = step->t0_mm + s * (step->t1_mm - step->t0_mm);
            near(vr_cubic_eval(&segments[i].f, k / 4.0), value_at(seen->m, seen->field, seen->ray, t), 1e-12);
        }
        near(segments[i].from, vr_cubic_eval(&segments[i].f, 0.0), 1e-14);
        near(segments[i].to, vr_cubic_eval(&segments[i].f, 1.0), 1e-14);
        if (seen->count++)
            near(segments[i].from, seen->last, 1e-12);
        seen->last = segments[i].to;
    }
    assert_true(at == 1.0);
    return 0;
}

static void segments_are_the_field(void **state)
{
    struct brick_ray rays[MAX_AWKWARD];
    struct memory_cells m;
    unsigned long long seed = 8;
    size_t count = awkward_rays(rays), hits = 0;
    (void)state;
    for (size_t i = 0; i < count + 3000; i++) {
        struct brick_ray ray = i < count ? rays[i] : random_ray(&seed, identity);
        double enter, leave;
        if (!brick_ray_span(&ray, &grid, &enter, &leave))
            continue;
        for (int f = 0; f < 2; f++) {
            struct segments_seen seen = {&m, fields[f], &ray, 0.0, 0};
            fill(&m, i);
            assert_int_equal(vr_march(&m.cells, &ray, enter, leave, check_segments, &seen, NULL), BRICK_OK);
            assert_true(seen.count > 0);
            hits++;
        }
    }
    assert_true(hits > 3000);
}

/* No surface is passed, none invented: up to the hit no sample lies on the other side, by more than rounding;
 * at the hit the field has the isovalue. Random values, and volumes of 0, 1 and 2 with the isovalue 1. */
static void no_ray_slips_through(void **state)
{
    enum { SAMPLES = 300 };
    struct brick_ray rays[MAX_AWKWARD];
    struct vr_look look = look_of(BRICK_MODE_ISO, NULL, identity);
    struct memory_cells m;
    unsigned long long seed = 9;
    size_t count = awkward_rays(rays), hits = 0, misses = 0;
    (void)state;
    for (size_t i = 0; i < 2 * count + 4000; i++) {
        struct brick_ray ray = i < 2 * count ? rays[i / 2] : random_ray(&seed, identity);
        double enter, leave;
        struct vr_traced traced;
        fill(&m, i);
        look.isovalue = 0.15 + 0.7 * reference_random(&seed);
        if (i % 2) {
            look.isovalue = 1.0;
            for (int k = 0; k < NX * NY * NZ; k++)
                m.voxels[k] = floor(3.0 * m.voxels[k]);
        }
        if (!brick_ray_span(&ray, &grid, &enter, &leave))
            continue;
        for (int f = 0; f < 2; f++) {
            look.field = fields[f];
            m.loads = 0;
            assert_int_equal(vr_trace(&look, &m.cells, &ray, enter, leave, &traced, NULL), BRICK_OK);
            bool hit = isfinite(traced.hit_mm);
            double start = value_at(&m, fields[f], &ray, enter) - look.isovalue;
            double end = hit ? traced.hit_mm : leave;
            hits += hit;
            misses += !hit;
            assert_true(end >= enter && end <= leave);
            assert_true(hit == isinf(traced.light.depth));
            if (hit)
                near(value_at(&m, fields[f], &ray, end), look.isovalue, 1e-12);
            for (int k = 1; k < SAMPLES && fabs(start) > 1e-12; k++) {
                double value = value_at(&m, fields[f], &ray, enter + (end - enter) * k / SAMPLES);
                assert_true((value - look.isovalue) * copysign(1.0, start) > -1e-12);
            }
        }
    }
    print_message("%zu rays hit, %zu do not\n", hits, misses);
    assert_true(hits > 5000 && misses > 500);
}

/* Sides of constant cells and of cells that are not finite. */
static void sides_by_the_rule(void **state)
{
    enum { RAYS = 20 }; /* all but the first meet voxels at places that are not binary */
    struct vr_look look = look_of(BRICK_MODE_ISO, NULL, identity);
    static const struct {
        double along_x[NX], hit_x; /* NaN: none */
    } cases[] = {
        {{0, 0, 1, 2, 2}, 2.0},   {{0, 0, 1, 1, 1}, 2.0},   /* arriving at a plateau is a hit */
        {{1, 1, 1, 1, 1}, NAN},   {{1, 1, 1, 2, 2}, NAN},   /* the plateau is above */
        {{1, 1, 1, 0, 0}, 2.0},                             /* leaving it downwards is one */
        {{2, 2, 1, 2, 2}, NAN},                             /* touched from above */
        {{0, 0, 1, 0, 0}, 2.0},                             /* touched from below */
        {{0, NAN, 2, 2, 2}, NAN}, {{2, 2, NAN, 0, 0}, NAN}, /* no side, no surface */
        {{NAN, 2, 0, 0, 0}, 1.5}, {{0, 0, INFINITY, 0, 2}, 3.5},
    };
    (void)state;
    for (size_t n = 0; n < 2 * RAYS * sizeof cases / sizeof cases[0]; n++) {
        double number = (double)(n / 2 % RAYS), hit_x = cases[n / 2 / RAYS].hit_x, enter, leave;
        const struct brick_ray ray = {{-3.0 - 0.1 * number, 1.5, 2.5},
                                      {1.0 / (1.0 + 0.037 * number), 0.0, 0.0}};
        struct memory_cells m;
        struct vr_traced traced;
        fill(&m, 1);
        for (int i = 0; i < NX * NY * NZ; i++)
            m.voxels[i] = cases[n / 2 / RAYS].along_x[i % NX];
        look.isovalue = 1.0;
        look.field = fields[n % 2];
        assert_true(brick_ray_span(&ray, &grid, &enter, &leave));
        assert_int_equal(vr_trace(&look, &m.cells, &ray, enter, leave, &traced, NULL), BRICK_OK);
        assert_true(isfinite(traced.hit_mm) == !isnan(hit_x));
        if (!isnan(hit_x))
            near(ray.origin[0] + traced.hit_mm * ray.direction[0], hit_x, 1e-14);
    }
}

/* A transfer function whose colour says the value: values in [0,1]. */
static struct brick_transfer_knot value_knots[2] = {{0, 0, 1, 0.5, 2}, {1, 1, 0, 0.5, 2}};
static const struct brick_transfer value_transfer = {.knots = value_knots, .count = 2, .unit_mm = 1.5};

static void mip_is_the_largest(void **state)
{
    enum { SAMPLES = 2000 };
    struct vr_look look = look_of(BRICK_MODE_MIP, &value_transfer, identity);
    unsigned long long seed = 10;
    (void)state;
    for (int round = 0; round < 800; round++) {
        struct brick_ray ray = random_ray(&seed, identity);
        struct memory_cells m;
        struct vr_traced traced;
        double enter, leave, largest = 0.0;
        if (!brick_ray_span(&ray, &grid, &enter, &leave))
            continue;
        fill(&m, (unsigned long long)round);
        look.field = fields[round % 2];
        assert_int_equal(vr_trace(&look, &m.cells, &ray, enter, leave, &traced, NULL), BRICK_OK);
        near(traced.light.depth, 3.0, 1e-15);
        double alpha = -expm1(-3.0), found = traced.light.rgb[0] / alpha;
        for (int k = 0; k <= SAMPLES; k++)
            largest = fmax(largest, value_at(&m, look.field, &ray, enter + (leave - enter) * k / SAMPLES));
        /* Values in [0,1] and |direction| = 1: slopes are at most sqrt(3), so no sample is further below the
         * maximum than half a sample's distance times that. */
        double h = (leave - enter) / SAMPLES;
        assert_true(found >= largest - 1e-14);
        near(found, largest, 0.5 * h * sqrt(3.0));
    }
}

static void mip_of_nothing_is_clear(void **state)
{
    const struct brick_ray ray = {{-3.0, 1.5, 2.5}, {1.0, 0.0, 0.0}};
    const struct vr_look look = look_of(BRICK_MODE_MIP, &value_transfer, identity);
    struct memory_cells m;
    struct vr_traced traced;
    (void)state;
    fill(&m, 1);
    for (int i = 0; i < NX * NY * NZ; i++)
        m.voxels[i] = NAN;
    assert_int_equal(vr_trace(&look, &m.cells, &ray, 2.5, 7.5, &traced, NULL), BRICK_OK);
    assert_true(traced.light.depth == 0.0 && traced.light.rgb[0] == 0.0);
}

/* The reference's light: gradients by shifting the point, cosines as the definition has them. */
struct lit_volume {
    struct reference_volume volume; /* the context's first member */
    const struct vr_look *look;
    const struct brick_transfer *transfer; /* pre-classified */
};

static long double shade(void *context, long double t, long double rgb[3])
{
    const struct lit_volume *v = context;
    long double p[3], g[3], n2 = 0.0L, along = 0.0L;
    reference_position(&v->volume, t, p);
    for (int a = 0; a < 3; a++) {
        long double ahead[3] = {p[0], p[1], p[2]}, behind[3] = {p[0], p[1], p[2]};
        ahead[a] += 1.0L;
        behind[a] -= 1.0L;
        g[a] = 0.5L * (reference_value(&v->volume, ahead) - reference_value(&v->volume, behind));
    }
    for (int i = 0; i < 3; i++) {
        long double n = 0.0L, view = 0.0L;
        for (int a = 0; a < 3; a++) {
            n += (long double)v->look->normal[i][a] * g[a];
            view += (long double)v->look->linear[i][a] * v->volume.ray->direction[a];
        }
        n2 += n * n;
        along += n * view;
    }
    long double facing = n2 > 0.0L ? fabsl(along) / sqrtl(n2) : 0.0L;
    for (int c = 0; c < 3; c++)
        rgb[c] = rgb[c] * (v->look->ambient + v->look->diffuse * facing) +
                 v->look->specular * powl(facing, v->look->shininess);
    return along;
}

static long double classified(void *context, long double t, long double rgb[3])
{
    const struct lit_volume *v = context;
    long double p[3], weight[8], sigma = 0.0L;
    int64_t voxel[8];
    reference_position(&v->volume, t, p);
    reference_corners(&v->volume, p, weight, voxel);
    rgb[0] = rgb[1] = rgb[2] = 0.0L;
    for (int i = 0; i < 8; i++) {
        double colour[3], extinction;
        brick_transfer_eval(v->transfer, v->volume.voxels[voxel[i]], colour, &extinction);
        sigma += weight[i] * extinction;
        for (int c = 0; c < 3; c++)
            rgb[c] += weight[i] * colour[c];
    }
    return sigma;
}

static struct brick_transfer_knot tents[] = {
    {0.1, 0.9, 0.0, 0.1, 0.0}, {0.25, 0.1, 0.7, 0.2, 0.9}, {0.4, 0.5, 0.5, 0.9, 0.0},
    {0.5, 0.0, 1.0, 0.0, 0.0}, {0.5, 1.0, 0.0, 0.0, 2.0},  {0.9, 1.0, 1.0, 1.0, 0.5},
};
static const struct brick_transfer tent_transfer = {.knots = tents, .count = sizeof tents / sizeof tents[0]};

/* Shaded or not, classified before or after interpolation, on voxels that are cubes or sheared. */
static void integrals_are_right(void **state)
{
    static const double shininess[] = {20.0, 1.0, 3.5};
    unsigned long long seed = 12;
    double worst[2][2] = {{0}};
    int hits = 0;
    (void)state;
    for (int round = 0; round < 90; round++) {
        bool lit = round % 3 > 0, before = round % 2;
        const double(*m3)[3] = round % 4 < 2 ? identity : sheared;
        struct vr_look look = look_of(lit ? BRICK_MODE_SHADED : BRICK_MODE_DVR, &tent_transfer, m3);
        struct brick_ray ray = random_ray(&seed, m3);
        struct memory_cells m;
        struct vr_traced traced;
        double enter, leave;
        look.shininess = shininess[round / 3 % 3];
        look.field = before ? VR_FIELD_PRECLASSIFIED : VR_FIELD_TRILINEAR;
        fill(&m, (unsigned long long)round);
        if (!brick_ray_span(&ray, &grid, &enter, &leave))
            continue;
        hits++;
        assert_int_equal(vr_trace(&look, &m.cells, &ray, enter, leave, &traced, NULL), BRICK_OK);
        struct lit_volume v = {volume_of(&m), &look, &tent_transfer};
        struct reference r = {.field = reference_field,
                              .context = &v,
                              .transfer = &tent_transfer,
                              .classify = before ? classified : NULL,
                              .shade = lit ? shade : NULL};
        reference_along(&r, &v.volume, &ray, enter, leave, 250);
        double *most = &worst[lit][before];
        *most = fmax(*most, fabs((double)(expl(-r.depth) - expl(-(long double)traced.light.depth))));
        for (int c = 0; c < 3; c++)
            *most = fmax(*most, fabs((double)(r.rgb[c] - traced.light.rgb[c])));
    }
    print_message(
        "%d rays; largest difference from the reference: dvr %.2g, pre-classified %.2g; shaded %.2g, "
        "pre-classified %.2g\n",
        hits, worst[0][0], worst[0][1], worst[1][0], worst[1][1]);
    assert_true(hits > 60);
    for (int i = 0; i < 4; i++)
        near(worst[i / 2][i % 2], 0.0, TOLERANCE);
}

/* The gradient turns round on the ray, or almost does: |N.V| / |N| falls from 1 to 0 and back over a width
 * that no rule of fixed points would see. Extinction is constant; the shading along the ray is known. */
static void turning_normals(void **state)
{
    struct brick_transfer_knot knot = {0.0, 0.0, 0.0, 0.0, 0.5};
    const struct brick_transfer transfer = {.knots = &knot, .count = 1};
    (void)state;
    for (int n = 0; n <= 12; n++) {
        double width = n == 12 ? 0.0 : pow(10.0, -n);
        /* normal (s - 1/3, width, 0) seen along x: cosine |x| / sqrt(x^2 + w^2), exponent 1 */
        const struct vr_light light = {.normal = {{{-1.0 / 3.0, 1.0, 0, 0}}, {{width, 0, 0, 0}}, {{0}}},
                                       .facing = {{-1.0 / 3.0, 1.0, 0, 0}},
                                       .specular = 1.0,
                                       .shininess = 1.0};
        const struct vr_cubic f = {{0.0}};
        struct vr_ray_integral ray = {0};
        long double sum = 0.0L;
        vr_ray_add(&ray, &transfer, &f, &light, 1.0, TOLERANCE);
        /* by substitution x = w sinh(u), which makes the integrand smooth; Simpson */
        enum { STEPS = 20000 };
        for (int side = 0; side < 2 && width > 0.0; side++) {
            long double end = asinhl((side ? 2.0L / 3.0L : 1.0L / 3.0L) / width), h = end / STEPS;
            for (int i = 0; i <= STEPS; i++) {
                long double u = h * i, s = 1.0L / 3.0L + (side ? 1 : -1) * width * sinhl(u);
                long double y = sinhl(u) * width * 0.5L * expl(-0.5L * s);
                sum += (i == 0 || i == STEPS ? 1.0L : i % 2 ? 4.0L : 2.0L) * y * h / 3.0L;
            }
        }
        if (width == 0.0)
            sum = -expm1l(-0.5L);
        near(ray.rgb[0], (double)sum, TOLERANCE);
    }
}

/* A normal of one direction that vanishes at an end: the facing ratio is the same everywhere, but near that
 * end it is computed as a quotient of what rounding left. Right, and for no more work than a zero is worth:
 * some 60 halvings. */
static void vanishing_normals(void **state)
{
    struct brick_transfer_knot knot = {0.0, 0.0, 0.0, 0.0, 0.5};
    const struct brick_transfer transfer = {.knots = &knot, .count = 1};
    (void)state;
    for (int i = 0; i < 50; i++) {
        const double n = 1.47 + 0.003 * i, ratio = 0.27 + 0.013 * i, bend = 0.1 * (i % 7);
        const struct vr_cubic falling = {{n, -n - bend, bend, 0.0}};
        const struct vr_light light = {.normal = {falling, {{0}}, {{0}}},
                                       .facing = {{ratio * n, -ratio * n - ratio * bend, ratio * bend, 0.0}},
                                       .specular = 1.0,
                                       .shininess = 20.0};
        const struct vr_cubic f = {{0.0}};
        struct vr_ray_integral ray = {0};
        vr_ray_add(&ray, &transfer, &f, &light, 1.0, TOLERANCE);
        near(ray.rgb[0], -expm1(-0.5) * pow(ratio, 20.0), TOLERANCE);
        assert_in_range(ray.evaluations, 15, 60 * 15);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(segments_are_the_field),  cmocka_unit_test(no_ray_slips_through),
        cmocka_unit_test(sides_by_the_rule),       cmocka_unit_test(mip_is_the_largest),
        cmocka_unit_test(mip_of_nothing_is_clear), cmocka_unit_test(integrals_are_right),
        cmocka_unit_test(turning_normals),         cmocka_unit_test(vanishing_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
