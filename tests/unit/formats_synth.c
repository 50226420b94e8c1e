/* Synthetic volumes: the same bytes however they are read, and the values their formulas give. */
#include "format_files.h"

#include <math.h>

static const uint64_t odd_dims[3] = {700, 37, 11}; /* a row is two spans; nothing divides anything */

static struct brick_source *open_synth(const char *name, const uint64_t dims[3], enum brick_type type,
                                       uint64_t seed, unsigned threads, double value)
{
    struct fmt_synth_params params = {.type = type, .seed = seed, .threads = threads, .value = value};
    struct brick_source *source = NULL;
    struct brick_error err = {.message = ""};
    memcpy(params.dims, dims, sizeof params.dims);
    if (fmt_synth_open(&source, name, &params, &err))
        fail_msg("%s", err.message);
    return source;
}

/* All voxels, as bytes; free them. */
static unsigned char *synth_bytes(const char *name, const uint64_t dims[3], enum brick_type type,
                                  uint64_t seed, unsigned threads, uint64_t slab, size_t *bytes)
{
    struct brick_source *source = open_synth(name, dims, type, seed, threads, 3);
    *bytes = voxel_count(source) * brick_type_bytes(type);
    unsigned char *voxels = malloc(*bytes);
    struct brick_error err = {.message = ""};
    assert_non_null(voxels);
    if (read_all(source, slab, voxels, &err))
        fail_msg("%s", err.message);
    brick_source_destroy(&source);
    return voxels;
}

static void same_bytes_however_read(void **state)
{
    (void)state;
    for (int i = 0; fmt_synth_names[i]; i++)
        for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++) {
            const char *name = fmt_synth_names[i];
            size_t bytes, again_bytes;
            unsigned char *voxels =
                synth_bytes(name, odd_dims, (enum brick_type)type, 5, 1, odd_dims[2], &bytes);
            static const unsigned threads[3] = {3, 1, 3};
            static const uint64_t slabs[3] = {11, 1, 4};
            for (int k = 0; k < 3; k++) {
                unsigned char *again =
                    synth_bytes(name, odd_dims, (enum brick_type)type, 5, threads[k], slabs[k], &again_bytes);
                if (bytes != again_bytes || memcmp(voxels, again, bytes) != 0)
                    fail_msg("%s %s differs for %u threads, slabs of %d", name,
                             brick_type_name((enum brick_type)type), threads[k], (int)slabs[k]);
                free(again);
            }
            free(voxels);
        }
}

static void geometry_and_provenance(void **state)
{
    (void)state;
    struct brick_source *source = open_synth("ct", odd_dims, BRICK_U16, 42, 1, 0);
    assert_string_equal(source->provenance, "synth: ct\nseed: 42\n");
    assert_int_equal(source->input_bytes, 0);
    assert_int_equal(source->type, BRICK_U16);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            assert_true(source->geometry.affine[r][c] == (r == c));
    assert_true(source->geometry.slope == 1 && source->geometry.intercept == -1000);
    brick_source_destroy(&source);
    assert_null(source);
}

static void *whole(const char *name, const uint64_t dims[3], enum brick_type type)
{
    size_t bytes;
    return synth_bytes(name, dims, type, 1, 2, dims[2], &bytes);
}

static void marschner_lobb(void **state)
{
    (void)state;
    const uint64_t dims[3] = {33, 21, 15};
    const double pi = acos(-1.0);
    float *f = whole("marschner-lobb", dims, BRICK_F32);
    uint16_t *u = whole("marschner-lobb", dims, BRICK_U16);
    int8_t *s = whole("marschner-lobb", dims, BRICK_I8);
    size_t i = 0;
    for (uint64_t z = 0; z < dims[2]; z++)
        for (uint64_t y = 0; y < dims[1]; y++)
            for (uint64_t x = 0; x < dims[0]; x++, i++) {
                const double px = -1 + 2 * (double)x / 32, py = -1 + 2 * (double)y / 20,
                             pz = -1 + 2 * (double)z / 14;
                const double rho = cos(2 * pi * 6 * cos(pi * sqrt(px * px + py * py) / 2));
                const double v = (1 - sin(pi * pz / 2) + 0.25 * (1 + rho)) / (2 * 1.25);
                assert_true(fabs(f[i] - v) <= 1e-7); /* half a unit of float32 below 1, and double's noise */
                assert_true(fabs(u[i] - 65535 * v) <= 0.5 + 0.005);
                assert_true(fabs(s[i] - 127 * v) <= 0.5 + 1e-4);
            }
    free(f);
    free(u);
    free(s);
}

static void shells(void **state)
{
    (void)state;
    const uint64_t dims[3] = {65, 33, 17};
    const double pi = acos(-1.0);
    float *f = whole("shells", dims, BRICK_F32);
    size_t i = 0;
    for (int z = 0; z < 17; z++)
        for (int y = 0; y < 33; y++)
            for (int x = 0; x < 65; x++, i++) {
                const double r = sqrt((x - 32) * (x - 32) + (y - 16) * (y - 16) + (z - 8) * (z - 8)) / 32.5;
                assert_true(fabs(f[i] - 0.5 * (1 - cos(2 * pi * 8 * r))) <= 1e-7);
            }
    assert_true(f[(8 * 33 + 16) * 65 + 32] == 0);
    free(f);
}

static void ramp_and_checker(void **state)
{
    (void)state;
    const uint64_t dims[3] = {9, 7, 5};
    float *f = whole("ramp", dims, BRICK_F32), *fc = whole("checker", dims, BRICK_F32);
    int16_t *s = whole("ramp", dims, BRICK_I16);
    uint8_t *u = whole("ramp", dims, BRICK_U8), *c = whole("checker", dims, BRICK_U8);
    size_t i = 0;
    for (int z = 0; z < 5; z++)
        for (int y = 0; y < 7; y++)
            for (int x = 0; x < 9; x++, i++) {
                const int sum = x + y + z; /* 18 at the last voxel */
                assert_true(f[i] == (float)sum);
                assert_true(fabs(s[i] - (-32768 + 65535.0 * sum / 18)) <= 0.5);
                assert_true(fabs(u[i] - 255.0 * sum / 18) <= 0.5);
                assert_int_equal(c[i], sum % 2 ? 200 : 0);
                assert_true(fc[i] == (float)(sum % 2));
            }
    assert_int_equal(s[0], -32768);
    assert_int_equal(s[i - 1], 32767);
    free(f);
    free(fc);
    free(s);
    free(u);
    free(c);
    const uint64_t one[3] = {1, 1, 1};
    uint16_t *single = whole("ramp", one, BRICK_U16);
    assert_int_equal(single[0], 0);
    free(single);
}

static void constant(void **state)
{
    (void)state;
    const uint64_t dims[3] = {3, 2, 1};
    struct brick_error err = {.message = ""};
    int16_t s[6];
    float f[6];
    struct brick_source *source = open_synth("constant", dims, BRICK_I16, 0, 1, -321);
    assert_int_equal(source->read(source, 0, 1, s, &err), 0);
    brick_source_destroy(&source);
    source = open_synth("constant", dims, BRICK_F32, 0, 1, NAN);
    assert_int_equal(source->read(source, 0, 1, f, &err), 0);
    brick_source_destroy(&source);
    for (int i = 0; i < 6; i++) {
        assert_int_equal(s[i], -321);
        assert_true(isnan(f[i]));
    }
}

static void ct_looks_like_ct(void **state)
{
    (void)state;
    const uint64_t dims[3] = {128, 128, 128};
    const size_t count = 128 * 128 * 128;
    int16_t *hu = whole("ct", dims, BRICK_I16);
    uint16_t *offset = whole("ct", dims, BRICK_U16);
    uint8_t *coarse = whole("ct", dims, BRICK_U8);
    size_t air = 0, bone = 0, lung = 0, soft = 0, differ = 0;
    double sum = 0, squares = 0;
    for (size_t i = 0; i < count; i++) {
        air += hu[i] == -1000;
        bone += hu[i] > 600;
        lung += hu[i] > -900 && hu[i] < -800;
        soft += hu[i] > 0 && hu[i] < 150;
        assert_true(hu[i] >= -1000 && hu[i] <= 1500);
        /* Each is one rounding, of at most half a unit, away from the same field. */
        assert_true(abs(hu[i] + 1000 - offset[i]) <= 1);
        differ += hu[i] + 1000 != offset[i];
        assert_true(abs(hu[i] + 1000 - 10 * coarse[i]) <= 6);
    }
    assert_true(differ < count / 1000); /* ties only */
    assert_true(air > count * 30 / 100 && air < count * 55 / 100);
    assert_true(bone > count / 200 && bone < count / 20);
    assert_true(lung > count / 25 && soft > count / 5);
    for (int z = 0; z < 128; z++) /* outside the body there is nothing but air */
        assert_int_equal(hu[(size_t)z * 128 * 128], -1000);
    /* The noise: fat below the skin in front, 12 HU about -100. */
    int n = 0;
    for (int z = 51; z < 77; z++)
        for (int y = 16; y < 18; y++)
            for (int x = 58; x < 70; x++, n++) {
                const double v = hu[((size_t)z * 128 + (size_t)y) * 128 + (size_t)x];
                sum += v;
                squares += v * v;
            }
    const double mean = sum / n, deviation = sqrt(squares / n - mean * mean);
    /* 576 samples: the standard error is 12/24 of the mean and 12/sqrt(2 * 576) of the deviation; five of
     * them. */
    assert_true(fabs(mean + 100) < 2.4);
    assert_true(fabs(deviation - 12) < 1.7);
    /* The seed changes noise, not anatomy. */
    size_t bytes, changed = 0;
    float *one = (float *)synth_bytes("ct", dims, BRICK_F32, 1, 2, 128, &bytes);
    float *two = (float *)synth_bytes("ct", dims, BRICK_F32, 2, 2, 128, &bytes);
    for (size_t i = 0; i < count; i++) {
        changed += one[i] != two[i];
        assert_true((one[i] == -1000) == (two[i] == -1000));
        assert_true(fabsf(one[i] - two[i]) < 84); /* four bytes' sum is within 510 of its mean: 41.4 HU */
        assert_true(fabs(one[i] - hu[i]) <= 0.5);
    }
    assert_true(changed > count / 2);
    free(one);
    free(two);
    free(hu);
    free(offset);
    free(coarse);
}

static void refusals(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        struct fmt_synth_params params;
        const char *says;
    } cases[] = {
        {"teapot", {.dims = {4, 4, 4}}, "no field 'teapot'"},
        {"ct", {.dims = {4, 0, 4}}, "0 voxels"},
        {"ct", {.dims = {4, 4, (UINT64_C(1) << 40) + 1}}, "1 to"},
        {"ramp", {.dims = {UINT64_C(1) << 40, UINT64_C(1) << 40, 1}}, "2^63"},
        {"ramp", {.dims = {4, 4, 4}, .type = BRICK_F64}, "type must be"},
        {"constant", {.dims = {4, 4, 4}, .type = BRICK_U8, .value = 256}, "256 is not a value of type u8"},
        {"constant", {.dims = {4, 4, 4}, .type = BRICK_I16, .value = 0.5}, "not a value"},
        {"constant", {.dims = {4, 4, 4}, .type = BRICK_I8, .value = NAN}, "not a value"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct brick_source *source = NULL;
        struct brick_error err = {.message = ""};
        assert_int_equal(fmt_synth_open(&source, cases[i].name, &cases[i].params, &err), BRICK_ERR_ARGUMENT);
        assert_null(source);
        if (!strstr(err.message, cases[i].says))
            fail_msg("expected '%s' in: %s", cases[i].says, err.message);
    }
    struct brick_source *source = open_synth("ramp", odd_dims, BRICK_U8, 0, 1, 0);
    unsigned char byte;
    assert_int_equal(source->read(source, 11, 1, &byte, NULL), BRICK_ERR_ARGUMENT);
    assert_int_equal(source->read(source, UINT64_MAX, 1, &byte, NULL), BRICK_ERR_ARGUMENT);
    brick_source_destroy(&source);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_bytes_however_read), cmocka_unit_test(geometry_and_provenance),
        cmocka_unit_test(marschner_lobb),          cmocka_unit_test(shells),
        cmocka_unit_test(ramp_and_checker),        cmocka_unit_test(constant),
        cmocka_unit_test(ct_looks_like_ct),        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
