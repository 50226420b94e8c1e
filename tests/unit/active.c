/* What is culled is invisible: bricks and macrocells, every stored type, levels, NaN, negative slopes. Points
 * are interpolated in float32, as shaders do. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/active.h>

#include "../support/memory_source.h"

enum { NX = 52, NY = 44, NZ = 37, EDGE = 16, MACRO = 4, BORDER = 2, ROOM = EDGE / MACRO + 1, POINTS = 24 };

static const double maps[][2] = {{1, 0}, {1, -24}, {-0.37, 11.5}, {1e-3, 4e3}};
enum { MAPS = 4 };

/* A slab; the lowest voxel of a brick, which cells of seven others reach; eight voxels that make one of
 * level 1. */
static bool is_hole(int x, int y, int z)
{
    return (x > 18 && x < 23 && y > 20) || (x == 48 && y == 16 && z == 16) ||
           (x / 2 == 25 && y / 2 == 1 && z / 2 == 17);
}

/* Shells around a corner, flat air outside; values from -1000 to 1000, or 0 to 200 in types of 8 bits and u16
 * x 7. */
static struct brick_volume *make_volume(enum brick_type type, bool holes, double slope, double intercept)
{
    static unsigned char voxels[NX * NY * NZ * 4];
    size_t i = 0;
    for (int z = 0; z < NZ; z++)
        for (int y = 0; y < NY; y++)
            for (int x = 0; x < NX; x++, i++) {
                double r = sqrt((double)(x * x + y * y + z * z));
                double f = r > 48 ? -1.0 : cos(r * 0.15);
                switch (type) {
                case BRICK_U8:
                    voxels[i] = (uint8_t)(100 + 100 * f);
                    break;
                case BRICK_I8:
                    ((int8_t *)voxels)[i] = (int8_t)(100 * f);
                    break;
                case BRICK_U16:
                    ((uint16_t *)voxels)[i] = (uint16_t)(30000 + 30000 * f);
                    break;
                case BRICK_I16:
                    ((int16_t *)voxels)[i] = (int16_t)(1000 * f);
                    break;
                default:
                    ((float *)voxels)[i] =
                        holes && is_hole(x, y, z) ? (x % 2 ? NAN : INFINITY) : (float)(1000 * f);
                    break;
                }
            }
    struct memory_source source;
    memory_source_init(&source, type, NX, NY, NZ, voxels);
    source.base.geometry.slope = slope;
    source.base.geometry.intercept = intercept;
    struct brick_build_params params = brick_build_defaults;
    params.edge = EDGE;
    params.border = BORDER;
    params.macrocell = MACRO;
    return build_and_open(&source, "active.brick", &params);
}

/* Two narrow peaks, at 62% and 90% of the volume's range. */
static struct brick_transfer *make_transfer(const struct brick_volume *v)
{
    double range[2];
    brick_volume_value_range(v, range);
    struct brick_transfer_point points[] = {{0.60, 1, 1, 1, 0}, {0.62, 1, 1, 1, 0.5}, {0.64, 1, 1, 1, 0},
                                            {0.89, 1, 1, 1, 0}, {0.90, 1, 0, 0, 0.3}, {0.91, 1, 0, 0, 0}};
    struct brick_transfer_spec spec = {.points = points, .count = 6, .unit = 1.0, .range_values = true};
    struct brick_transfer *t;
    struct brick_error err;
    if (brick_transfer_create(&t, &spec, 1.0, range, &err))
        fail_msg("%s", err.message);
    return t;
}

/* One brick decoded, and its macrocells' bits. */
struct look {
    const struct brick_grid *grid;
    struct brick_place place;
    unsigned char *payload;
    struct brick_scratch scratch;
    uint32_t active[(ROOM * ROOM * ROOM + 31) / 32], above[(ROOM * ROOM * ROOM + 31) / 32];
    uint64_t count;
};

static void look_at(struct look *l, const struct brick_volume *v, const struct brick_active_query *query,
                    uint64_t id, bool whole)
{
    struct brick_error err;
    l->grid = brick_volume_grid(v);
    if (!l->payload)
        l->payload = malloc(brick_grid_max_payload_bytes(l->grid));
    brick_grid_place(l->grid, id, &l->place);
    if (brick_volume_read(v, id, l->payload, &l->scratch, &err))
        fail_msg("%s", err.message);
    memset(l->active, 0, sizeof l->active);
    memset(l->above, 0, sizeof l->above);
    l->count = brick_active_macrocells(
        l->grid, query, whole, l->grid->type, l->payload + brick_place_voxel_bytes(l->grid, &l->place),
        l->place.macrocells, (uint32_t[]){ROOM, ROOM * ROOM}, l->active, l->above);
    uint64_t bits = 0;
    for (size_t w = 0; w < sizeof l->active / 4; w++) {
        bits += (uint64_t)__builtin_popcount(l->active[w]);
        assert_int_equal(l->active[w] & l->above[w], 0);
    }
    assert_int_equal(bits, l->count);
}

static bool bit(const uint32_t *plane, const uint32_t at[3])
{
    uint32_t i = (at[2] * ROOM + at[1]) * ROOM + at[0];
    return plane[i / 32] >> i % 32 & 1;
}

static void finish(struct look *l)
{
    free(l->payload);
    brick_scratch_finish(&l->scratch);
}

/* Physical value of point i of a macrocell; false where a corner is not finite. Every third point is a voxel.
 */
static bool sample(const struct look *l, const uint32_t at[3], uint64_t i, double *value)
{
    float u[3], c[8];
    int64_t cell[3];
    for (int a = 0; a < 3; a++) {
        uint32_t first = at[a] * MACRO,
                 wide = l->place.core[a] - first < MACRO ? l->place.core[a] - first : MACRO;
        double p =
            (double)(noise64(at[0] + 9 * at[1] + 81 * at[2], 3 * i + (uint64_t)a) >> 11) * 0x1p-53 * wide;
        cell[a] = first + (int64_t)p;
        u[a] = i % 3 ? (float)(p - floor(p)) : i % 2 ? 1.0f : 0.0f;
    }
    for (int k = 0; k < 8; k++) {
        size_t x = (size_t)(cell[0] + BORDER + (k & 1)), y = (size_t)(cell[1] + BORDER + (k >> 1 & 1)),
               z = (size_t)(cell[2] + BORDER + (k >> 2));
        c[k] = (float)brick_type_load(l->grid->type, l->payload,
                                      (z * l->place.stored[1] + y) * l->place.stored[0] + x);
        if (!isfinite(c[k]))
            return false;
    }
    for (int k = 0; k < 4; k++)
        c[k] = c[2 * k] + u[0] * (c[2 * k + 1] - c[2 * k]);
    for (int k = 0; k < 2; k++)
        c[k] = c[2 * k] + u[1] * (c[2 * k + 1] - c[2 * k]);
    float f = c[0] + u[2] * (c[1] - c[0]);
    *value = (double)((float)l->grid->slope * f + (float)l->grid->intercept);
    return true;
}

static void check_brick(const struct look *l, const struct brick_active_query *query, uint8_t state)
{
    uint32_t at[3];
    for (at[2] = 0; at[2] < l->place.macrocells[2]; at[2]++)
        for (at[1] = 0; at[1] < l->place.macrocells[1]; at[1]++)
            for (at[0] = 0; at[0] < l->place.macrocells[0]; at[0]++) {
                bool active = bit(l->active, at), above = bit(l->above, at);
                if (state < BRICK_STATE_ACTIVE)
                    assert_true(!active &&
                                above == (state == BRICK_STATE_ABOVE)); /* never contradicts its brick */
                if (active)
                    continue;
                for (uint64_t i = 0; i < POINTS; i++) {
                    double value, rgb[3], sigma = 0.0;
                    if (!sample(l, at, i, &value))
                        continue;
                    if (query->mode == BRICK_MODE_ISO) {
                        assert_true((value >= query->isovalue) == above);
                    } else {
                        brick_transfer_eval(query->transfer, value, rgb, &sigma);
                        assert_true(sigma == 0.0);
                    }
                }
            }
}

static void check_query(const struct brick_volume *v, const struct brick_active_query *query)
{
    const struct brick_level *level = &brick_volume_grid(v)->level[query->level];
    uint64_t n = level->bricks[0] * level->bricks[1] * level->bricks[2], macrocells = 0, active = 0,
             inside = 0;
    uint8_t *states = malloc(n);
    struct look look = {0};
    uint64_t set = brick_active_set(v, query, states);
    for (uint64_t b = 0; b < n; b++) {
        look_at(&look, v, query, level->first_brick + b, states[b] == BRICK_STATE_WHOLE);
        check_brick(&look, query, states[b]);
        macrocells +=
            (uint64_t)look.place.macrocells[0] * look.place.macrocells[1] * look.place.macrocells[2];
        if (states[b] >= BRICK_STATE_ACTIVE) {
            active += look.count;
            inside += look.count > 0;
        }
    }
    /* The test would pass if nothing were culled; something must be, and not all. */
    if (query->level == 0 && !brick_volume_stats(v)->nonfinite)
        assert_true(active > 0 && active < macrocells * 4 / 5);
    struct brick_active_summary s;
    struct brick_error err;
    if (brick_active_summarise(v, query, true, 2, &s, &err))
        fail_msg("%s", err.message);
    assert_int_equal(s.bricks, n);
    assert_int_equal(s.bricks_active, set);
    assert_true(s.bricks_interval >= s.bricks_active);
    assert_int_equal(s.macrocells, macrocells);
    assert_int_equal(s.macrocells_active, active);
    assert_int_equal(s.bricks_macrocells, inside);
    assert_true((s.bytes_read > 0) == (set > 0));
    finish(&look);
    free(states);
}

static void what_is_culled_is_invisible(void **state)
{
    (void)state;
    for (int type = 0; type <= BRICK_TYPE_STORED_COUNT; type++)
        for (int m = 0; m < MAPS; m++) {
            const bool holes = type == BRICK_TYPE_STORED_COUNT; /* f32 once more */
            struct brick_volume *v =
                make_volume(holes ? BRICK_F32 : (enum brick_type)type, holes, maps[m][0], maps[m][1]);
            struct brick_transfer *t = make_transfer(v);
            double range[2];
            brick_volume_value_range(v, range);
            for (uint32_t level = 0; level < 2; level++) {
                check_query(v, &(struct brick_active_query){BRICK_MODE_DVR, t, 0, level});
                check_query(v, &(struct brick_active_query){BRICK_MODE_ISO, NULL,
                                                            0.3 * range[0] + 0.7 * range[1], level});
            }
            brick_transfer_destroy(&t);
            brick_volume_close(&v);
        }
}

static void iso_states_tell_the_side(void **state)
{
    (void)state;
    for (int m = 0; m < MAPS; m++) {
        struct brick_volume *v = make_volume(BRICK_I16, false, maps[m][0], maps[m][1]);
        const struct brick_grid *g = brick_volume_grid(v);
        uint8_t *states = malloc(g->bricks);
        struct brick_active_query query = {.mode = BRICK_MODE_ISO,
                                           .isovalue = maps[m][0] * -999.5 + maps[m][1]};
        uint64_t active = brick_active_set(v, &query, states);
        for (uint64_t id = 0; id < g->level[1].first_brick; id++) {
            double lo, hi;
            brick_volume_physical_range(v, id, &lo, &hi);
            if (states[id] == BRICK_STATE_EMPTY)
                assert_true(hi < query.isovalue);
            if (states[id] == BRICK_STATE_ABOVE)
                assert_true(lo > query.isovalue);
        }
        assert_true(active > 0 && active < g->level[1].first_brick);
        /* At the value of air itself air is above, and not active: a value is above when it is not below. */
        if (maps[m][0] == 1.0) {
            query.isovalue = -1000.0 + maps[m][1];
            brick_active_set(v, &query, states);
            assert_int_equal(states[g->level[1].first_brick - 1], BRICK_STATE_ABOVE);
        }
        free(states);
        brick_volume_close(&v);
    }
}

/* Every brick with a cell that is not finite, at every level, is whole for an isosurface. */
static void nan_makes_bricks_whole(void **state)
{
    (void)state;
    struct brick_volume *v = make_volume(BRICK_F32, true, 1.0, 0.0);
    const struct brick_grid *g = brick_volume_grid(v);
    struct look look = {0};
    unsigned found = 0;
    for (uint32_t l = 0; l < g->levels; l++) {
        const struct brick_level *level = &g->level[l];
        uint64_t n = level->bricks[0] * level->bricks[1] * level->bricks[2], whole = 0, active = 0;
        struct brick_active_query query = {.mode = BRICK_MODE_ISO, .isovalue = 50.0, .level = l};
        uint8_t *states = malloc(n);
        uint64_t set = brick_active_set(v, &query, states);
        for (uint64_t b = 0; b < n; b++) {
            bool hole = false;
            uint32_t at[3];
            look_at(&look, v, &query, level->first_brick + b, states[b] == BRICK_STATE_WHOLE);
            for (at[2] = 0; at[2] <= look.place.core[2]; at[2]++)
                for (at[1] = 0; at[1] <= look.place.core[1]; at[1]++)
                    for (at[0] = 0; at[0] <= look.place.core[0]; at[0]++)
                        hole |= !isfinite(
                            ((float *)
                                 look.payload)[((at[2] + BORDER) * look.place.stored[1] + at[1] + BORDER) *
                                                   look.place.stored[0] +
                                               at[0] + BORDER]);
            if (hole)
                assert_int_equal(states[b], BRICK_STATE_WHOLE);
            if (states[b] == BRICK_STATE_WHOLE)
                assert_int_equal(look.count, look.place.macrocells[0] * look.place.macrocells[1] *
                                                 look.place.macrocells[2]);
            found |= hole ? 1u << l : 0;
            whole += states[b] == BRICK_STATE_WHOLE;
            active += states[b] >= BRICK_STATE_ACTIVE;
        }
        assert_int_equal(active, set);
        if (l == 0)
            assert_true(whole > 0 && whole < n);
        free(states);
    }
    assert_true(found & 1 && found & 2);
    finish(&look);
    brick_volume_close(&v);
}

/* A continuous field takes every value of its range; a wall of NaN lets a brick hold two ranges, and the mask
 * tells. */
static void the_mask_sees_what_nan_separates(void **state)
{
    (void)state;
    static float voxels[16 * 8 * 8];
    for (size_t i = 0; i < 16 * 8 * 8; i++)
        voxels[i] = i % 16 < 3   ? (float)(i % 2)
                    : i % 16 < 6 ? NAN
                    : i % 16 < 8 ? 100.0f + (float)(i % 2)
                                 : 7.0f;
    struct memory_source source;
    memory_source_init(&source, BRICK_F32, 16, 8, 8, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.edge = 8;
    struct brick_volume *v = build_and_open(&source, "mask.brick", &params);
    const struct brick_entry *e = brick_volume_entry(v, 0);
    assert_true(e->min == 0.0f && e->max == 101.0f);
    assert_int_equal(e->mask & 1, 1);
    assert_int_equal(e->mask >> 63, 1);
    assert_int_equal(e->mask >> 2 & 1, 0); /* bins of 1.58: values 3.2 to 4.7, between 0..1 and 7..101 */
    struct brick_error err;
    struct brick_transfer_point points[] = {
        {0, 1, 1, 1, 0}, {3.3, 1, 1, 1, 0}, {3.9, 1, 1, 1, 0.5}, {4.6, 1, 1, 1, 0}, {9, 1, 1, 1, 0}};
    struct brick_transfer_spec spec = {.points = points, .count = 5, .unit = 1.0};
    struct brick_transfer *t;
    assert_int_equal(brick_transfer_create(&t, &spec, 1.0, (double[]){0, 1}, &err), 0);
    uint8_t states[2];
    struct brick_active_query query = {.mode = BRICK_MODE_DVR, .transfer = t};
    brick_active_set(v, &query, states);
    assert_int_equal(states[0], BRICK_STATE_EMPTY);
    assert_int_equal(brick_active_by_interval(v, &query, states), 1);
    assert_int_equal(states[0], BRICK_STATE_ACTIVE);
    brick_transfer_destroy(&t);
    if (brick_check(v, 1, NULL, NULL, &err))
        fail_msg("%s", err.message);
    brick_volume_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_culled_is_invisible),
        cmocka_unit_test(iso_states_tell_the_side),
        cmocka_unit_test(nan_makes_bricks_whole),
        cmocka_unit_test(the_mask_sees_what_nan_separates),
    };
    return cmocka_run_group_tests_name("active", tests, NULL, NULL);
}
