/* EXR bit for bit, files of other programs, and what is refused. */
#include "image_files.h"

#include <fcntl.h>
#include <math.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <openexr.h>

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

/* Noise, of which more and more is nothing: there are pictures that compression makes neither smaller nor
 * larger, to the byte. */
static void exr_hardly_compressible(void **state)
{
    (void)state;
    enum { WIDTH = 20, HEIGHT = 16, WORDS = 4 * WIDTH * HEIGHT };
    const char *path = in_folder("a.exr");
    struct brick_image image = make_image(WIDTH, HEIGHT), back;
    for (uint32_t seed = 1; seed <= 20; seed++)
        for (size_t nothing = 0; nothing < 60; nothing++) {
            uint32_t bits = seed;
            for (size_t i = 0; i < WORDS; i++) {
                bits = bits * 1664525u + 1013904223u;
                const uint32_t word = i < nothing ? 0 : bits ^ bits >> 15;
                memcpy(image.rgba + i, &word, sizeof word);
            }
            write_image(path, &image, &fmt_image_defaults);
            assert_int_equal(fmt_image_read(&back, path, NULL), 0);
            assert_memory_equal(back.rgba, image.rgba, WORDS * sizeof(float));
            brick_image_finish(&back);
        }
    brick_image_finish(&image);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exr_bit_exact), cmocka_unit_test(exr_foreign),
        cmocka_unit_test(exr_refused),   cmocka_unit_test(exr_corrupt),
        cmocka_unit_test(exr_bomb),      cmocka_unit_test(exr_hardly_compressible),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
