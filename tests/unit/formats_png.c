/* Why: PNG in memory comes back from libpng sample for sample, for every number of channels. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#ifdef HAVE_PNG
#include <png.h>
#endif

#include <formats/formats.h>

#ifdef HAVE_PNG
static void round_trip(void **state)
{
    (void)state;
    static const uint32_t formats[] = {[1] = PNG_FORMAT_GRAY, [3] = PNG_FORMAT_RGB, [4] = PNG_FORMAT_RGBA};
    enum { WIDTH = 67, HEIGHT = 31, BYTES = WIDTH * HEIGHT * 4 };
    static uint8_t data[BYTES], got[BYTES];
    uint32_t noise = 1;
    for (size_t i = 0; i < BYTES; i++)
        data[i] = (uint8_t)((noise = noise * 1664525u + 1013904223u) >> 24);
    for (uint32_t channels = 1; channels <= 4; channels++) {
        const struct fmt_samples samples = {WIDTH, HEIGHT, channels, data};
        void *png = NULL, *again = NULL;
        size_t bytes = 0, again_bytes = 0;
        if (channels == 2) {
            assert_int_equal(fmt_png_encode(&samples, &png, &bytes, NULL), BRICK_ERR_ARGUMENT);
            continue;
        }
        assert_int_equal(fmt_png_encode(&samples, &png, &bytes, NULL), 0);
        assert_int_equal(fmt_png_encode(&samples, &again, &again_bytes, NULL), 0);
        assert_int_equal(bytes, again_bytes);
        assert_memory_equal(png, again, bytes);

        png_image image = {.version = PNG_IMAGE_VERSION};
        assert_true(png_image_begin_read_from_memory(&image, png, bytes));
        assert_int_equal(image.width, WIDTH);
        assert_int_equal(image.height, HEIGHT);
        assert_int_equal(image.format, formats[channels]);
        assert_true(png_image_finish_read(&image, NULL, got, 0, NULL));
        assert_memory_equal(got, data, WIDTH * HEIGHT * channels);
        free(png);
        free(again);
    }
}
#endif

static void refused(void **state)
{
    (void)state;
    const uint8_t pixel = 7;
    void *png;
    size_t bytes;
    const struct fmt_samples empty = {0, 1, 1, &pixel}, one = {1, 1, 1, &pixel};
    assert_int_equal(fmt_png_encode(&empty, &png, &bytes, NULL), BRICK_ERR_ARGUMENT);
    assert_null(png);
#ifdef HAVE_PNG
    assert_int_equal(fmt_png_encode(&one, &png, &bytes, NULL), 0);
    free(png);
#else
    struct brick_error err;
    assert_int_equal(fmt_png_encode(&one, &png, &bytes, &err), BRICK_ERR_UNSUPPORTED);
    assert_non_null(strstr(err.message, "libpng"));
#endif
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#ifdef HAVE_PNG
        cmocka_unit_test(round_trip),
#endif
        cmocka_unit_test(refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
