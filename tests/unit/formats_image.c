/* Pictures: names and disks that are refused, and PNG by sRGB's definition. */
#include "image_files.h"

#include <math.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#ifdef HAVE_PNG
#include <png.h>
#endif

static void expect_refused(const char *path, int code, const char *says)
{
    struct brick_image image = make_image(2, 2);
    struct brick_error check = {.message = ""}, write = {.message = ""};
    const unsigned files = count_files();
    const int checked = fmt_image_check_path(path, &check);
    const int written = fmt_image_write(path, &image, &fmt_image_defaults, &write);
    if (checked != code || written != code || !strstr(check.message, says) || !strstr(write.message, says))
        fail_msg("%s: expected %d '%s': %d %s; %d %s", path, code, says, checked, check.message, written,
                 write.message);
    assert_int_equal(count_files(), files);
    brick_image_finish(&image);
}

static void bad_paths(void **state)
{
    (void)state;
    expect_refused(in_folder("a.jpg"), BRICK_ERR_UNSUPPORTED, "must end in .exr or .png");
    expect_refused(in_folder("exr"), BRICK_ERR_UNSUPPORTED, "must end in .exr or .png");
    expect_refused(in_folder(".png"), BRICK_ERR_UNSUPPORTED, "must end in .exr or .png");
    expect_refused("/nowhere.exr/a", BRICK_ERR_UNSUPPORTED, "must end in .exr or .png");
#ifdef HAVE_PNG
    expect_refused(in_folder("missing/a.png"), BRICK_ERR_IO, "missing");
    put_file("file", "x", NULL, 0);
    expect_refused(in_folder("file/a.png"), BRICK_ERR_IO, "cannot be written");
    assert_int_equal(mkdir(in_folder("folder.png"), 0700), 0);
    expect_refused(in_folder("folder.png"), BRICK_ERR_IO, "it is a folder");
    assert_int_equal(rmdir(in_folder("folder.png")), 0);
    assert_int_equal(fmt_image_check_path(in_folder("A.PNG"), NULL), 0);
    assert_int_equal(fmt_image_check_path("plain.png", NULL), 0);
    struct brick_image image = make_image(1, 1);
    const struct fmt_image_params params = {{0, NAN, 0}};
    assert_int_equal(fmt_image_write(in_folder("a.png"), &image, &params, NULL), BRICK_ERR_ARGUMENT);
    brick_image_finish(&image);
    image = (struct brick_image){0};
    assert_int_equal(fmt_image_write(in_folder("a.png"), &image, &fmt_image_defaults, NULL),
                     BRICK_ERR_ARGUMENT);
    expect_unreadable(put_file("a.png", "x", NULL, 0), "written only");
#else
    expect_refused(in_folder("a.png"), BRICK_ERR_UNSUPPORTED, "libpng");
#endif
#ifndef HAVE_OPENEXR
    expect_refused(in_folder("a.exr"), BRICK_ERR_UNSUPPORTED, "OpenEXR");
#endif
}

/* A file may grow to no more than `bytes`, as on a full disk. */
static void write_with_room_for(rlim_t bytes, const char *path, const struct brick_image *image)
{
    struct rlimit old, small;
    struct brick_error err = {.message = ""};
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small = old;
    small.rlim_cur = bytes;
    signal(SIGXFSZ, SIG_IGN);
    const unsigned files = count_files();
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const int code = fmt_image_write(path, image, &fmt_image_defaults, &err);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    signal(SIGXFSZ, SIG_DFL);
    if (code != BRICK_ERR_IO || strchr(err.message, '\n') || !strstr(err.message, path))
        fail_msg("room for %d: %d %s", (int)bytes, code, err.message);
    assert_int_equal(count_files(), files);
}

static void full_disk(void **state)
{
    (void)state;
    struct brick_image image = make_image(200, 100);
    fill(&image);
    static const char *const names[] = {"full.exr", "full.png"};
    for (int i = 0; i < 2; i++) {
        const char *path = in_folder(names[i]);
        const int code = fmt_image_check_path(path, NULL);
        if (code == BRICK_ERR_UNSUPPORTED)
            continue; /* not in this build */
        assert_int_equal(code, 0);
        write_with_room_for(0, path, &image);
        write_with_room_for(100, path, &image);
        write_with_room_for(2000, path, &image);
        /* What was there before stays. */
        put_file(names[i], "before", NULL, 0);
        write_with_room_for(2000, path, &image);
        size_t bytes;
        unsigned char *data = load(path, &bytes);
        assert_int_equal(bytes, 6);
        free(data);
        unlink(path);
    }
    brick_image_finish(&image);
}

#ifdef HAVE_PNG
static void png_srgb(void **state)
{
    (void)state;
    /* premultiplied r g b A; background 0.5, 0, 1; what an 8-bit sRGB picture of it holds. */
    static const struct {
        float rgba[4];
        unsigned char want[3];
    } pixels[] = {
        {{0, 0, 0, 1}, {0, 0, 0}},
        {{1, 1, 1, 1}, {255, 255, 255}},
        {{0.5f, 0.21404114f, 0.0031308f, 1},
         {188, 128, 10}},                           /* 0.214041 is sRGB 1/2; 12.92 * 0.0031308 * 255 = 10.3 */
        {{0, 0, 0, 0}, {188, 0, 255}},              /* the background */
        {{0.25f, 0.25f, 0, 0.5f}, {188, 137, 188}}, /* over: 0.5, 0.25, 0.5 */
        {{NAN, -1, 7, 1}, {0, 0, 255}},
        {{INFINITY, -INFINITY, 0.0001f, 1}, {255, 0, 0}}, /* 12.92 * 0.0001 * 255 = 0.33 */
        {{0.00016f, 0.0003f, 0.0005f, 1}, {1, 1, 2}},     /* 0.53, 0.99, 1.65 */
    };
    enum { N = sizeof pixels / sizeof *pixels };
    struct brick_image image = make_image(N, 2);
    for (size_t i = 0; i < N; i++)
        for (int c = 0; c < 4; c++) {
            image.rgba[4 * i + (size_t)c] = pixels[i].rgba[c];
            image.rgba[4 * (N + N - 1 - i) + (size_t)c] = pixels[i].rgba[c]; /* second row: backwards */
        }
    const struct fmt_image_params params = {{0.5, 0, 1}};
    const char *path = in_folder("s.png");
    write_image(path, &image, &params);
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&png, path));
    assert_int_equal(png.width, N);
    assert_int_equal(png.height, 2);
    assert_int_equal(png.format, PNG_FORMAT_RGB);
    unsigned char got[2 * N * 3];
    png.format = PNG_FORMAT_RGB;
    assert_true(png_image_finish_read(&png, NULL, got, 0, NULL));
    for (size_t i = 0; i < N; i++) {
        assert_memory_equal(got + 3 * i, pixels[i].want, 3);
        assert_memory_equal(got + 3 * (N + N - 1 - i), pixels[i].want, 3);
    }
    size_t bytes;
    unsigned char *data = load(path, &bytes);
    assert_non_null(memmem(data, bytes, "sRGB", 4));
    assert_null(memmem(data, bytes, "tIME", 4));
    free(data);
    assert_int_equal(count_files(), 1); /* no .part */
    brick_image_finish(&image);
    empty_folder(state);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
#ifdef HAVE_PNG
        cmocka_unit_test(png_srgb),
#endif
        cmocka_unit_test(bad_paths),
        cmocka_unit_test(full_disk),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
