/* What a damaged, cut, foreign or hostile file is answered with: one line, never a picture of it, never a
 * crash. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include <brick/writer.h>

#include "../support/memory_source.h"

static unsigned char *good;
static size_t good_bytes;

static int make_good_file(void **state)
{
    (void)state;
    static uint16_t voxels[40 * 20 * 20];
    for (size_t i = 0; i < 40 * 20 * 20; i++)
        voxels[i] = i % 40 < 12 ? 5 : (uint16_t)(noise64(1, i) % 60);
    struct memory_source source;
    memory_source_init(&source, BRICK_U16, 40, 20, 20, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.edge = 8;
    struct brick_volume *v = build_and_open(&source, "good.brick", &params);
    brick_volume_close(&v);
    good = read_file(test_path("good.brick"), &good_bytes);
    return !good;
}

/* Open and check; the first error, or 0. */
static int judge(const char *path, struct brick_error *err)
{
    struct brick_volume *v;
    int code = brick_volume_open(&v, path, err);
    if (code) {
        assert_null(v);
        return code;
    }
    code = brick_check(v, 1, NULL, NULL, err);
    brick_volume_close(&v);
    return code;
}

static void every_flipped_bit_is_reported(void **state)
{
    (void)state;
    const char *path = test_path("flipped.brick");
    unsigned char *bytes = malloc(good_bytes);
    memcpy(bytes, good, good_bytes);
    struct brick_error err;
    write_file(path, bytes, good_bytes);
    assert_int_equal(judge(path, &err), 0);
    FILE *f = fopen(path, "r+b");
    setvbuf(f, NULL, _IONBF, 0);
    for (size_t i = 0; i < good_bytes; i += 1 + (i > 512) * (noise64(2, i) % 15)) {
        unsigned char flipped = good[i] ^ (unsigned char)(1u << (noise64(3, i) & 7));
        fseek(f, (long)i, SEEK_SET);
        fputc(flipped, f);
        memset(&err, 0, sizeof err);
        if (judge(path, &err) == 0)
            fail_msg("a flipped bit in byte %zu of %zu goes unnoticed", i, good_bytes);
        assert_true(strlen(err.message) > 10);
        fseek(f, (long)i, SEEK_SET);
        fputc(good[i], f);
    }
    fclose(f);
    free(bytes);
}

static void every_cut_is_reported(void **state)
{
    (void)state;
    const char *path = test_path("cut.brick");
    struct brick_error err;
    for (size_t n = 0; n < good_bytes; n += 1 + good_bytes / 300) {
        write_file(path, good, n);
        assert_int_not_equal(judge(path, &err), 0);
    }
    unsigned char *longer = calloc(1, good_bytes + 1);
    memcpy(longer, good, good_bytes);
    write_file(path, longer, good_bytes + 1);
    assert_int_equal(judge(path, &err), BRICK_ERR_FORMAT);
    free(longer);
}

/* Numbers in the header with a correct checksum: refused before memory is taken. */
static void hostile_headers(void **state)
{
    (void)state;
    const char *path = test_path("hostile.brick");
    const uint64_t values[] = {
        0, 1, 3, UINT32_MAX, UINT64_C(1) << 31, UINT64_C(1) << 40, UINT64_C(1) << 62, UINT64_MAX};
    unsigned char *bytes = malloc(good_bytes);
    struct brick_error err;
    for (size_t at = 8; at < 288; at += 4)
        for (size_t k = 0; k < sizeof values / sizeof values[0]; k++) {
            memcpy(bytes, good, good_bytes);
            size_t width = at < 56 && at != 16 ? 4 : 8;
            if (at % width)
                continue;
            memcpy(bytes + at, &values[k], width);
            if (memcmp(bytes, good, 512) == 0)
                continue;
            uint64_t sum = XXH3_64bits(bytes, 504);
            memcpy(bytes + 504, &sum, 8);
            write_file(path, bytes, good_bytes);
            /* another place in the world is no contradiction (80..192: slope, intercept, affine); all else is
             */
            if (judge(path, &err) == 0 && !(at >= 80 && at < 192))
                fail_msg("value %llu at byte %zu is accepted", (unsigned long long)values[k], at);
        }
    free(bytes);
}

/* Index entries that lie, under a correct checksum. */
static void hostile_index(void **state)
{
    (void)state;
    const char *path = test_path("index.brick");
    uint64_t index_at, index_bytes;
    memcpy(&index_at, good + 192 + 24, 8);
    memcpy(&index_bytes, good + 192 + 32, 8);
    unsigned char *bytes = malloc(good_bytes);
    struct brick_error err;
    for (size_t at = 0; at < 48 * 3; at++)
        for (int bit = 0; bit < 8; bit += 3) {
            memcpy(bytes, good, good_bytes);
            bytes[index_at + at] ^= (unsigned char)(1 << bit);
            uint64_t sum = XXH3_64bits(bytes + index_at, index_bytes);
            memcpy(bytes + 192 + 40, &sum, 8);
            sum = XXH3_64bits(bytes, 504);
            memcpy(bytes + 504, &sum, 8);
            write_file(path, bytes, good_bytes);
            if (judge(path, &err) == 0)
                fail_msg("a lie in byte %zu of the index goes unnoticed", at);
        }
    free(bytes);
}

static void foreign_files(void **state)
{
    (void)state;
    struct brick_error err;
    const char *path = test_path("foreign.brick");
    char text[2000];
    memset(text, 'x', sizeof text);
    write_file(path, text, sizeof text);
    assert_int_equal(judge(path, &err), BRICK_ERR_FORMAT);
    assert_non_null(strstr(err.message, "not a .brick file"));
    write_file(path, "", 0);
    assert_int_equal(judge(path, &err), BRICK_ERR_FORMAT);
    memset(text, 0, sizeof text);
    write_file(path, text, sizeof text);
    assert_int_equal(judge(path, &err), BRICK_ERR_FORMAT);
    assert_non_null(strstr(err.message, "unfinished"));
    assert_int_equal(judge("/nonexistent/x.brick", &err), BRICK_ERR_IO);
    assert_int_equal(judge("/tmp", &err), BRICK_ERR_IO);
    memcpy(text, good, 512);
    text[8] = 2;
    write_file(path, text, sizeof text);
    assert_int_equal(judge(path, &err), BRICK_ERR_UNSUPPORTED);
}

static void an_unfinished_writer_leaves_nothing(void **state)
{
    (void)state;
    struct brick_error err;
    struct brick_grid grid;
    struct brick_geometry geometry = {.dims = {8, 8, 8}, .affine = {{1}, {0, 1}, {0, 0, 1}}, .slope = 1};
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &geometry, 8, 2, 8, &err), 0);
    const char *path = test_path("w.brick"), *part = test_path("w.brick.part");
    write_file(path, "keep", 4);
    struct brick_writer *w, *second;
    assert_int_equal(brick_writer_create(&w, path, &grid, &err), 0);
    assert_int_equal(access(part, F_OK), 0);
    assert_int_equal(brick_writer_create(&second, path, &grid, &err), BRICK_ERR_IO);
    assert_non_null(strstr(err.message, "another process"));
    struct brick_stats stats = {0};
    uint64_t n;
    assert_int_equal(brick_writer_finish(w, &stats, "", &n, &err), BRICK_ERR_ARGUMENT);
    struct brick_entry entry = {0};
    assert_int_equal(brick_writer_put(w, 1, &entry, "x", 1, &err), BRICK_ERR_ARGUMENT);
    brick_writer_destroy(&w);
    assert_int_not_equal(access(part, F_OK), 0);
    FILE *f = fopen(path, "rb");
    char word[5] = {0};
    assert_int_equal(fread(word, 1, 4, f), 4);
    fclose(f);
    assert_string_equal(word, "keep");
}

static void boxes_outside_are_refused(void **state)
{
    (void)state;
    struct brick_error err;
    struct brick_volume *v;
    assert_int_equal(brick_volume_open(&v, test_path("good.brick"), &err), 0);
    uint16_t one;
    assert_int_equal(brick_volume_read_box(v, 9, (uint64_t[]){0, 0, 0}, (uint64_t[]){1, 1, 1}, &one, &err),
                     BRICK_ERR_ARGUMENT);
    assert_int_equal(brick_volume_read_box(v, 0, (uint64_t[]){0, 0, 0}, (uint64_t[]){41, 1, 1}, &one, &err),
                     BRICK_ERR_ARGUMENT);
    assert_int_equal(brick_volume_read_box(v, 0, (uint64_t[]){3, 0, 0}, (uint64_t[]){3, 1, 1}, &one, &err),
                     BRICK_ERR_ARGUMENT);
    brick_volume_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_flipped_bit_is_reported),
        cmocka_unit_test(every_cut_is_reported),
        cmocka_unit_test(hostile_headers),
        cmocka_unit_test(hostile_index),
        cmocka_unit_test(foreign_files),
        cmocka_unit_test(an_unfinished_writer_leaves_nothing),
        cmocka_unit_test(boxes_outside_are_refused),
    };
    return cmocka_run_group_tests_name("store", tests, make_good_file, NULL);
}
