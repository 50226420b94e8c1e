/* Pictures: EXR bit for bit, PNG by sRGB's definition, and what is refused. */
#include "format_files.h"

#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#ifdef HAVE_PNG
#include <png.h>
#endif
#ifdef HAVE_OPENEXR
#include <openexr.h>
#endif

static struct brick_image make_image(uint32_t width, uint32_t height)
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

static unsigned char *load(const char *path, size_t *bytes)
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
static void fill(struct brick_image *image)
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

#ifdef HAVE_OPENEXR
static void exr_bit_exact(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {3, 1}, {1, 17}, {67, 45}, {640, 33}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        struct brick_image image = make_image(sizes[k][0], sizes[k][1]), back;
        struct brick_error err = {.message = ""};
        fill(&image);
        const char *path = in_folder("a.exr"), *again = in_folder("b.exr");
        write_image(path, &image, &fmt_image_defaults);
        write_image(again, &image, &fmt_image_defaults);
        if (fmt_image_read(&back, path, &err))
            fail_msg("%s", err.message);
        assert_int_equal(back.width, image.width);
        assert_int_equal(back.height, image.height);
        assert_memory_equal(back.rgba, image.rgba, (size_t)image.width * image.height * 16);
        size_t bytes, again_bytes;
        unsigned char *data = load(path, &bytes), *again_data = load(again, &again_bytes);
        assert_int_equal(bytes, again_bytes);
        assert_memory_equal(data, again_data, bytes);
        free(data);
        free(again_data);
        brick_image_finish(&back);
        brick_image_finish(&image);
    }
    empty_folder(state);
}

/* A picture of width x 20 whose channels are as told; every sample of channel i is i + 1 + x / 4 + y. */
struct foreign {
    exr_storage_t storage;
    exr_compression_t compression;
    exr_pixel_type_t type;
    int parts, min;
    bool cropped;
    int sampling;
    const char *channels[7]; /* NULL at the end */
};

static void put_exr(const char *path, const struct foreign *f)
{
    enum { W = 24, H = 20 };
    exr_context_t context;
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    assert_int_equal(exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &setup), 0);
    static const char *const part_names[] = {"one", "two"};
    /* The C library of 3.1 cannot write DWA: its number is put into the header afterwards. */
    const exr_compression_t compression =
        f->compression == EXR_COMPRESSION_DWAA ? EXR_COMPRESSION_ZIP : f->compression;
    for (int p = 0; p < f->parts; p++) {
        int part;
        assert_int_equal(exr_add_part(context, f->parts > 1 ? part_names[p] : NULL, f->storage, &part), 0);
        const exr_attr_box2i_t window = {.min = {.x = f->min, .y = f->min},
                                         .max = {.x = f->min + W - 1, .y = f->min + H - 1}};
        exr_attr_box2i_t display = window;
        display.max.x += f->cropped;
        const exr_attr_v2f_t centre = {.x = 0, .y = 0};
        assert_int_equal(exr_initialize_required_attr(context, part, &display, &window, 1, &centre, 1,
                                                      EXR_LINEORDER_INCREASING_Y, compression),
                         0);
        if (f->storage == EXR_STORAGE_TILED)
            assert_int_equal(
                exr_set_tile_descriptor(context, part, 8, 8, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN), 0);
        for (int i = 0; f->channels[i]; i++)
            assert_int_equal(exr_add_channel(context, part, f->channels[i], f->type,
                                             EXR_PERCEPTUALLY_LOGARITHMIC, f->sampling, f->sampling),
                             0);
    }
    assert_int_equal(exr_write_header(context), 0);
    if (f->parts == 1 && f->storage == EXR_STORAGE_SCANLINE && f->sampling == 1 &&
        compression == f->compression) {
        exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
        int32_t lines;
        float samples[6][H][W];
        uint32_t integers[H][W];
        memset(integers, 0, sizeof integers);
        for (int i = 0; i < 6; i++)
            for (int y = 0; y < H; y++)
                for (int x = 0; x < W; x++)
                    samples[i][y][x] = (float)(i + 1) + (float)x / 4 + (float)y;
        assert_int_equal(exr_get_scanlines_per_chunk(context, 0, &lines), 0);
        for (int y = 0; y < H; y += lines) {
            exr_chunk_info_t chunk;
            assert_int_equal(exr_write_scanline_chunk_info(context, 0, f->min + y, &chunk), 0);
            if (y == 0)
                assert_int_equal(exr_encoding_initialize(context, 0, &chunk, &encoder), 0);
            else
                assert_int_equal(exr_encoding_update(context, 0, &chunk, &encoder), 0);
            for (int c = 0; c < encoder.channel_count; c++) {
                exr_coding_channel_info_t *channel = &encoder.channels[c];
                int i = 0;
                while (strcmp(f->channels[i], channel->channel_name) != 0)
                    i++;
                const bool whole = f->type == EXR_PIXEL_UINT;
                channel->user_bytes_per_element = 4;
                channel->user_data_type = whole ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
                channel->user_pixel_stride = 4;
                channel->user_line_stride = 4 * W;
                channel->encode_from_ptr =
                    whole ? (const uint8_t *)&integers[y][0] : (const uint8_t *)&samples[i][y][0];
            }
            if (y == 0)
                assert_int_equal(exr_encoding_choose_default_routines(context, 0, &encoder), 0);
            assert_int_equal(exr_encoding_run(context, 0, &encoder), 0);
        }
        exr_encoding_destroy(context, &encoder);
        assert_int_equal(exr_finish(&context), 0);
        return;
    }
    /* A header is enough to be refused; the library removes an unfinished file, so put it back. */
    size_t bytes;
    unsigned char *data = load(path, &bytes);
    exr_finish(&context);
    static const char attribute[] = "compression\0compression\0\1\0\0";
    unsigned char *at = memmem(data, bytes, attribute, sizeof attribute);
    assert_non_null(at);
    at[sizeof attribute] = (unsigned char)f->compression;
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, bytes, file), bytes);
    fclose(file);
    free(data);
}

/* half and float, with and without A, other channels beside, any compression, windows that start anywhere. */
static void exr_foreign(void **state)
{
    (void)state;
    static const struct foreign files[] = {
        {.type = EXR_PIXEL_HALF, .compression = EXR_COMPRESSION_PIZ, .channels = {"R", "G", "B", "A"}},
        {.type = EXR_PIXEL_HALF, .compression = EXR_COMPRESSION_ZIPS, .min = -5, .channels = {"B", "G", "R"}},
        {.type = EXR_PIXEL_FLOAT,
         .compression = EXR_COMPRESSION_RLE,
         .channels = {"Z", "B", "A", "R", "G", "view.R"}},
        {.type = EXR_PIXEL_FLOAT,
         .compression = EXR_COMPRESSION_NONE,
         .min = 3,
         .channels = {"G", "R", "Z", "B"}},
        {.type = EXR_PIXEL_FLOAT, .compression = EXR_COMPRESSION_ZIP, .channels = {"R", "G", "B"}},
    };
    for (size_t k = 0; k < sizeof files / sizeof *files; k++) {
        struct foreign f = files[k];
        struct brick_image image;
        struct brick_error err = {.message = ""};
        const char *path = in_folder("f.exr");
        f.parts = f.sampling = 1;
        f.storage = EXR_STORAGE_SCANLINE;
        put_exr(path, &f);
        if (fmt_image_read(&image, path, &err))
            fail_msg("file %zu: %s", k, err.message);
        assert_int_equal(image.width, 24);
        assert_int_equal(image.height, 20);
        static const char *const names[4] = {"R", "G", "B", "A"};
        for (int c = 0; c < 4; c++) {
            int i = 0;
            while (f.channels[i] && strcmp(f.channels[i], names[c]) != 0)
                i++;
            for (int y = 0; y < 20; y++)
                for (int x = 0; x < 24; x++) {
                    const float want = f.channels[i] ? (float)(i + 1) + (float)x / 4 + (float)y : 1;
                    if (image.rgba[(y * 24 + x) * 4 + c] != want)
                        fail_msg("file %zu, %s at %d,%d: %g, not %g", k, names[c], x, y,
                                 (double)image.rgba[(y * 24 + x) * 4 + c], (double)want);
                }
        }
        brick_image_finish(&image);
    }
    empty_folder(state);
}

static void exr_refused(void **state)
{
    (void)state;
    static const struct {
        struct foreign file;
        const char *says;
    } cases[] = {
        {{EXR_STORAGE_TILED, EXR_COMPRESSION_ZIP, EXR_PIXEL_FLOAT, 1, 0, false, 1, {"R", "G", "B"}}, "tiled"},
        {{EXR_STORAGE_SCANLINE, EXR_COMPRESSION_ZIP, EXR_PIXEL_FLOAT, 2, 0, false, 1, {"R", "G", "B"}},
         "2 parts"},
        {{EXR_STORAGE_DEEP_SCANLINE, EXR_COMPRESSION_ZIPS, EXR_PIXEL_FLOAT, 1, 0, false, 1, {"R", "G", "B"}},
         "deep"},
        {{EXR_STORAGE_SCANLINE, EXR_COMPRESSION_ZIP, EXR_PIXEL_FLOAT, 1, 0, true, 1, {"R", "G", "B"}},
         "cropped"},
        {{EXR_STORAGE_SCANLINE, EXR_COMPRESSION_ZIP, EXR_PIXEL_UINT, 1, 0, false, 1, {"R", "G", "B"}},
         "integers"},
        {{EXR_STORAGE_SCANLINE, EXR_COMPRESSION_ZIP, EXR_PIXEL_FLOAT, 1, 0, false, 2, {"R", "G", "B"}},
         "subsampled"},
        {{EXR_STORAGE_SCANLINE, EXR_COMPRESSION_ZIP, EXR_PIXEL_FLOAT, 1, 0, false, 1, {"Y"}},
         "no channels R"},
        {{EXR_STORAGE_SCANLINE, EXR_COMPRESSION_DWAA, EXR_PIXEL_HALF, 1, 0, false, 1, {"R", "G", "B"}},
         "DWA"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const char *path = in_folder("r.exr");
        put_exr(path, &cases[k].file);
        assert_int_equal(expect_unreadable(path, cases[k].says), BRICK_ERR_UNSUPPORTED);
        unlink(path);
    }
    expect_unreadable(put_file("r.exr", "", NULL, 0), NULL);
    expect_unreadable(put_file("r.exr", "not a picture at all, but long enough", NULL, 0), NULL);
    assert_int_equal(expect_unreadable(in_folder("missing.exr"), "missing.exr"), BRICK_ERR_IO);
    empty_folder(state);
}

/* Cut anywhere: an error. A byte changed: an error or a picture, never a crash, and no chatter. */
static void exr_corrupt(void **state)
{
    (void)state;
    struct brick_image image = make_image(24, 40);
    fill(&image);
    const char *path = in_folder("c.exr"), *chatter = in_folder("chatter");
    write_image(path, &image, &fmt_image_defaults);
    size_t bytes;
    unsigned char *data = load(path, &bytes);
    fflush(stderr);
    const int old = dup(2), quiet = open(chatter, O_CREAT | O_RDWR | O_TRUNC, 0600);
    assert_true(old >= 0 && quiet >= 0 && dup2(quiet, 2) == 2);
    for (size_t n = 0; n < bytes; n += n < 600 ? 3 : 197) {
        path = put_file("c.exr", "", data, n);
        struct brick_image got;
        assert_int_not_equal(fmt_image_read(&got, path, NULL), 0);
        assert_null(got.rgba);
    }
    unsigned failures = 0;
    for (size_t i = 0; i < bytes; i += i < 600 ? 2 : 29)
        for (unsigned bit = 0; bit < 8; bit += 3) {
            struct brick_image got;
            struct brick_error err = {.message = ""};
            data[i] ^= (unsigned char)(1u << bit);
            path = put_file("c.exr", "", data, bytes);
            data[i] ^= (unsigned char)(1u << bit);
            if (fmt_image_read(&got, path, &err)) {
                failures++;
                assert_null(got.rgba);
                assert_true(err.message[0] && !strchr(err.message, '\n'));
            }
            brick_image_finish(&got);
        }
    fflush(stderr);
    assert_int_equal(dup2(old, 2), 2);
    struct stat status;
    assert_int_equal(fstat(quiet, &status), 0);
    assert_int_equal(status.st_size, 0);
    assert_true(failures > 150);
    close(old);
    close(quiet);
    free(data);
    brick_image_finish(&image);
    empty_folder(state);
}

/* A header that promises 32768 x 32768 pixels in a file of a few hundred bytes: refused before memory is
 * taken. */
static void exr_bomb(void **state)
{
    (void)state;
    struct brick_image image = make_image(1, 1);
    const char *path = in_folder("bomb.exr");
    write_image(path, &image, &fmt_image_defaults);
    size_t bytes;
    unsigned char *data = load(path, &bytes);
    static const char *const windows[] = {"dataWindow", "displayWindow"};
    for (int k = 0; k < 2; k++) {
        unsigned char *at = memmem(data, bytes, windows[k], strlen(windows[k]));
        assert_non_null(at);
        at += strlen(windows[k]) + 1 + strlen("box2i") + 1 + 4 + 8; /* name, type, size, min */
        const uint32_t max[2] = {32767, 32767};
        memcpy(at, max, sizeof max);
    }
    put_file("bomb.exr", "", data, bytes);
    struct rlimit old, small;
    assert_int_equal(getrlimit(RLIMIT_AS, &old), 0);
    small = old;
    small.rlim_cur = (rlim_t)2 << 30; /* 16 GiB would fail, with another message */
    setrlimit(RLIMIT_AS, &small);
    const int code = expect_unreadable(path, "too few");
    setrlimit(RLIMIT_AS, &old);
    assert_int_equal(code, BRICK_ERR_FORMAT);
    free(data);
    brick_image_finish(&image);
    empty_folder(state);
}
#endif

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
#ifdef HAVE_OPENEXR
        cmocka_unit_test(exr_bit_exact), cmocka_unit_test(exr_foreign), cmocka_unit_test(exr_refused),
        cmocka_unit_test(exr_corrupt),   cmocka_unit_test(exr_bomb),
#endif
#ifdef HAVE_PNG
        cmocka_unit_test(png_srgb),
#endif
        cmocka_unit_test(bad_paths),     cmocka_unit_test(full_disk),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
