/* Pictures in tests: made, written, loaded as bytes, and refused. */
#ifndef TESTS_IMAGE_FILES_H
#define TESTS_IMAGE_FILES_H

#include "format_files.h"

static inline struct brick_image make_image(uint32_t width, uint32_t height)
{
    struct brick_image image;
    struct brick_error err = {.message = ""};
    if (brick_image_init(&image, width, height, &err))
        fail_msg("%s", err.message);
    return image;
}

static inline void write_image(const char *path, const struct brick_image *image,
                               const struct fmt_image_params *params)
{
    struct brick_error err = {.message = ""};
    if (fmt_image_write(path, image, params, &err))
        fail_msg("%s", err.message);
}

static inline unsigned char *load(const char *path, size_t *bytes)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    assert_int_equal(fseek(f, 0, SEEK_END), 0);
    *bytes = (size_t)ftell(f);
    rewind(f);
    unsigned char *data = malloc(*bytes + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *bytes, f), *bytes);
    fclose(f);
    return data;
}

/* Every kind of float, and a stretch that compresses well. */
static inline void fill(struct brick_image *image)
{
    static const uint32_t special[] = {0x00000000, 0x80000000, 0x00000001, 0x807fffff,
                                       0x7f800000, 0xff800000, 0x7fc00000, 0x7f800001,
                                       0xffffffff, 0x3f800000, 0x7f7fffff, 0x00800000};
    uint32_t bits = 12345;
    for (size_t i = 0; i < (size_t)image->width * image->height * 4; i++) {
        bits = bits * 1664525u + 1013904223u;
        const uint32_t v = i % 5 == 0 ? special[i / 5 % 12] : i % 7 == 0 ? bits : 0x3e800000;
        memcpy(&image->rgba[i], &v, 4);
    }
}

static inline int expect_unreadable(const char *path, const char *says)
{
    struct brick_image image;
    struct brick_error err = {.message = ""};
    const int code = fmt_image_read(&image, path, &err);
    assert_null(image.rgba);
    if (code == 0 || err.message[0] == 0 || strchr(err.message, '\n') || (says && !strstr(err.message, says)))
        fail_msg("%d, expected '%s': %s", code, says ? says : "an error", err.message);
    return code;
}

#endif
