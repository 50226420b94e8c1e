/* Codecs alone: what is lossless comes back bit for bit, what is lossy within its tolerance voxel by voxel,
 * and bytes from an enemy end in an error. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <blosc.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include <brick/codec.h>

#include "../support/memory_source.h"

static struct brick_codec_shape shape_of(enum brick_type type, uint32_t x, uint32_t y, uint32_t z,
                                         size_t ranges)
{
    size_t width = brick_type_bytes(type), voxels = (size_t)x * y * z;
    return (struct brick_codec_shape){type, {x, y, z}, voxels * width, (voxels + 2 * ranges) * width};
}

static const double lowest[] = {0, -128, 0, -32768, -(double)FLT_MAX},
                    highest[] = {255, 127, 65535, 32767, (double)FLT_MAX};

enum pattern { NOISE, SPIKES, SMOOTH, STEP, HUGE_AND_TINY, DENORMAL, SMALL_NOISE, PATTERNS };

/* u in [0, 1) of the type's whole range (of f32: a range in which differences are finite). */
static double hard(enum pattern pattern, enum brick_type type, size_t i, const uint32_t n[3])
{
    double lo = lowest[type], hi = highest[type], u = (double)(noise64(pattern, i) >> 11) * 0x1p-53;
    size_t x = i % n[0], y = i / n[0] % n[1], z = i / n[0] / n[1];
    if (type == BRICK_F32) {
        if (pattern == HUGE_AND_TINY)
            return (double)(float)((u < 0.5 ? -1 : 1) * ldexp(0.5 + u / 2, (int)(noise64(9, i) % 250) - 124));
        if (pattern == DENORMAL)
            return (double)(float)ldexp(u, -130);
        if (pattern == SPIKES)
            return u < 0.02 ? hi : lo;
        lo = -1000;
        hi = 1000;
    }
    double v;
    switch (pattern) {
    case SPIKES:
        return u < 0.02 ? hi : lo;
    case SMOOTH:
        v = lo + (hi - lo) * (0.5 + 0.49 * sin(0.1 * (double)x) * cos(0.07 * (double)(y + z)));
        break;
    case STEP:
        return x < n[0] / 2 ? lo : hi;
    case SMALL_NOISE:
        v = lo + (hi - lo) * 0.5 + 20 * u;
        break;
    default:
        v = lo + (hi - lo) * u;
        break;
    }
    return type == BRICK_F32 ? (double)(float)v : floor(v);
}

static const uint32_t sizes[][3] = {{36, 36, 36}, {5, 6, 13}, {20, 9, 36}};

static void lossless_codecs_give_back_every_bit(void **state)
{
    (void)state;
    for (int codec = 0; codec < BRICK_CODEC_COUNT; codec++) {
        if (brick_codec_is_lossy((enum brick_codec)codec))
            continue;
        assert_int_equal(brick_codec_from_name(brick_codec_name((enum brick_codec)codec)), codec);
        for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++)
            for (int pattern = 0; pattern < PATTERNS; pattern++)
                for (int level = 1; level <= 9; level += 4) {
                    struct brick_codec_shape s = shape_of((enum brick_type)type, 20, 9, 36, 7);
                    size_t n = s.bytes / brick_type_bytes(s.type), written,
                           room = brick_codec_bound((enum brick_codec)codec, s.bytes);
                    void *src = malloc(s.bytes), *dst = malloc(room), *back = malloc(s.bytes);
                    struct brick_error err = {0};
                    for (size_t i = 0; i < n; i++)
                        store_voxel(s.type, src, i, hard((enum pattern)pattern, s.type, i, s.voxels));
                    if (brick_codec_encode((enum brick_codec)codec, level, &s, src, dst, room, &written,
                                           &err) ||
                        brick_codec_decode((enum brick_codec)codec, &s, dst, written, back, &err))
                        fail_msg("%s", err.message);
                    assert_memory_equal(src, back, s.bytes);
                    assert_int_equal(
                        brick_codec_decode((enum brick_codec)codec, &s, dst, written - 1, back, &err),
                        BRICK_ERR_FORMAT);
                    free(src);
                    free(dst);
                    free(back);
                }
    }
}

/* zstd-delta as docs/FORMAT.md has it: 0, -1, 1, -2, ... folded to 0, 1, 2, 3, ..., each against the element
 * before. */
static void differences_are_folded(void **state)
{
    (void)state;
    const int16_t values[8] = {5, 4, 6, 6, -32768, 32767, 0, -1};
    const uint16_t folded[8] = {10, 1, 4, 0, 65524, 1, 65533, 1};
    uint16_t found[8];
    unsigned char chunk[256];
    struct brick_codec_shape s = {BRICK_I16, {2, 2, 2}, 16, 16};
    size_t written;
    struct brick_error err = {0};
    assert_int_equal(
        brick_codec_encode(BRICK_CODEC_ZSTD_DELTA, 1, &s, values, chunk, sizeof chunk, &written, &err), 0);
    assert_int_equal(blosc_decompress_ctx(chunk, found, sizeof found, 1), 16);
    for (int i = 0; i < 8; i++)
        assert_int_equal(found[i], folded[i]);
}

static void tolerances_in_stored_values(void **state)
{
    (void)state;
    assert_true(brick_codec_tolerance(BRICK_U16, 1.0, 2.0) == 2.0);
    assert_true(brick_codec_tolerance(BRICK_U16, -1.0, 2.9) == 2.0);
    assert_true(brick_codec_tolerance(BRICK_U8, 4.0, 3.9) == 0.0);
    assert_true(brick_codec_tolerance(BRICK_I16, 1e-30, 1.0) == 65535.0);
    assert_true(brick_codec_tolerance(BRICK_F32, 1e-300, 1e300) == (double)FLT_MAX);
    for (uint64_t i = 0; i < 100000; i++) {
        double slope = ldexp((double)(noise64(1, i) >> 11), -(int)(noise64(2, i) % 70)),
               physical = ldexp((double)(noise64(3, i) >> 11) + 1.0, -(int)(noise64(2, i + 7) % 70));
        if (slope == 0.0)
            continue;
        double whole = brick_codec_tolerance(BRICK_U16, slope, physical),
               real = brick_codec_tolerance(BRICK_F32, slope, physical);
        assert_true(whole == floor(whole) && whole * slope <= physical && real * slope <= physical);
        assert_true(whole == 65535.0 || (whole + 1.0) * slope > physical);
        assert_true(real * slope >= physical * (1.0 - 0x1p-50));
    }
}

/* Every voxel of hard data, for tolerances from too small to larger than the range. */
static void zfp_keeps_its_bound(void **state)
{
    (void)state;
    if (!brick_codec_is_built(BRICK_CODEC_ZFP))
        skip();
    const double tolerances[2][8] = {{0, 1, 2, 3, 7, 100, 5000, 65535},
                                     {1e-44, 1e-30, 1e-7, 1e-3, 1, 1e5, 1e30, 3e38}};
    for (int type = 0; type < BRICK_TYPE_STORED_COUNT; type++) {
        int kept = 0;
        for (int pattern = 0; pattern < PATTERNS; pattern++)
            for (int k = 0; k < 8; k++)
                for (size_t size = 0; size < 3; size++) {
                    const uint32_t *n = sizes[size];
                    double tolerance = tolerances[type == BRICK_F32][k];
                    struct brick_codec_shape s = shape_of((enum brick_type)type, n[0], n[1], n[2], 3);
                    size_t count = (size_t)n[0] * n[1] * n[2], width = brick_type_bytes(s.type),
                           room = brick_codec_bound(BRICK_CODEC_ZFP, s.bytes), written;
                    void *src = malloc(s.bytes), *decoded = malloc(s.bytes), *back = malloc(s.bytes);
                    unsigned char *dst = malloc(room);
                    struct brick_error err = {0};
                    for (size_t i = 0; i < s.bytes / width; i++)
                        store_voxel(s.type, src, i, hard((enum pattern)pattern, s.type, i, n));
                    memcpy(decoded, src, s.bytes);
                    if (brick_codec_encode_lossy(BRICK_CODEC_ZFP, tolerance, &s, decoded, dst, room, &written,
                                                 &err))
                        fail_msg("%s", err.message);
                    /* Values at both ends of the type: rounding must not wrap around. */
                    if (pattern == STEP && size == 0 && k >= 3 && k <= 5)
                        assert_true(written > 0);
                    if (!written)
                        assert_memory_equal(src, decoded, s.bytes);
                    else {
                        kept++;
                        assert_true(written < s.voxel_bytes);
                        memcpy(dst + written, (char *)decoded + s.voxel_bytes, s.bytes - s.voxel_bytes);
                        written += s.bytes - s.voxel_bytes;
                        assert_int_equal(brick_codec_decode(BRICK_CODEC_ZFP, &s, dst, written, back, &err),
                                         0);
                        assert_memory_equal(back, decoded, s.bytes);
                        for (size_t i = 0; i < count; i++) {
                            double a = brick_type_load(s.type, src, i),
                                   b = brick_type_load(s.type, decoded, i);
                            if (!(fabs(a - b) <= tolerance))
                                fail_msg("%s pattern %d: %.9g became %.9g, tolerance %g",
                                         brick_type_name(s.type), pattern, a, b, tolerance);
                        }
                    }
                    free(src);
                    free(decoded);
                    free(back);
                    free(dst);
                }
        assert_true(kept > 20); /* most of the bounds above were not kept by giving up */
    }
}

/* A buffer of n bytes that ends where memory ends. */
static unsigned char *guarded(size_t n, void **map, size_t *map_bytes)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE), whole = (n + page - 1) / page * page;
    *map_bytes = whole + page;
    *map = mmap(NULL, *map_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(*map != MAP_FAILED);
    assert_int_equal(mprotect((char *)*map + whole, page, PROT_NONE), 0);
    return (unsigned char *)*map + whole - n;
}

/* Cut, flipped, random: an error or some voxels, but never a step outside the buffers. */
static void hostile_payloads(void **state)
{
    (void)state;
    struct brick_codec_shape s = shape_of(BRICK_U16, 20, 9, 12, 4);
    size_t n = s.bytes / 2, written, map_bytes[2], refused = 0, tries = 0;
    void *maps[2];
    uint16_t *src = malloc(s.bytes);
    unsigned char *dst = malloc(s.bytes + 64), *to = guarded(s.bytes, &maps[0], &map_bytes[0]);
    struct brick_error err = {0};
    for (int codec = 0; codec < BRICK_CODEC_COUNT; codec++) {
        if (!brick_codec_is_built((enum brick_codec)codec))
            continue;
        for (size_t i = 0; i < n; i++)
            src[i] = (uint16_t)hard(SMOOTH, BRICK_U16, i, s.voxels);
        if (brick_codec_is_lossy((enum brick_codec)codec)) {
            assert_int_equal(brick_codec_encode_lossy((enum brick_codec)codec, 3, &s, src, dst, s.bytes + 64,
                                                      &written, &err),
                             0);
            assert_true(written > 0);
            written += s.bytes - s.voxel_bytes;
        } else
            assert_int_equal(
                brick_codec_encode((enum brick_codec)codec, 5, &s, src, dst, s.bytes + 64, &written, &err),
                0);
        if (codec == BRICK_CODEC_ZFP) {
            struct brick_codec_shape turned = {BRICK_U16, {9, 20, 12}, s.voxel_bytes, s.bytes};
            assert_int_equal(brick_codec_decode(BRICK_CODEC_ZFP, &turned, dst, written, to, &err),
                             BRICK_ERR_FORMAT);
        }
        for (uint64_t i = 0; i < 4000; i++) {
            /* Every cut, then flips, then noise behind a header that is right. */
            size_t bytes = i < written ? (size_t)i : written;
            unsigned char *from = guarded(bytes, &maps[1], &map_bytes[1]);
            memcpy(from, dst, bytes);
            if (i >= written)
                for (uint64_t k = 0; k < 1 + i % 5; k++)
                    from[noise64(k, i) % bytes] ^= (unsigned char)(1u << (noise64(k + 9, i) & 7));
            for (size_t k = 20; i > 3000 && k < bytes; k++)
                from[k] = (unsigned char)noise64(i, k);
            int code = brick_codec_decode((enum brick_codec)codec, &s, from, bytes, to, &err);
            assert_true(code == 0 || code == BRICK_ERR_FORMAT);
            assert_true(i >= written || code != 0); /* a cut is always noticed */
            refused += code != 0;
            tries++;
            munmap(maps[1], map_bytes[1]);
        }
    }
    assert_true(refused > tries / 4);
    munmap(maps[0], map_bytes[0]);
    free(src);
    free(dst);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lossless_codecs_give_back_every_bit),
        cmocka_unit_test(differences_are_folded),
        cmocka_unit_test(tolerances_in_stored_values),
        cmocka_unit_test(zfp_keeps_its_bound),
        cmocka_unit_test(hostile_payloads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
