/* What a sink writes, the source of the same format reads back: voxels bit for bit, geometry exactly or
 * nearly. */
#include "format_files.h"

#include <math.h>

static const uint64_t dims[3] = {5, 4, 3};

/* Oblique, anisotropic, mirrored: no element of it is special. */
static const struct brick_geometry oblique = {
    .dims = {5, 4, 3},
    .affine = {{0.7, -0.1, 0.33, -101.25}, {0.2, -0.9, 1.0 / 3.0, 17.125}, {-0.05, 0.3, 2.9, 1e3}},
    .slope = 0.1,
    .intercept = -1024.5,
};

static void fill(unsigned char *voxels, size_t n)
{
    uint32_t state = 12345; /* any bits, NaN among the floats included */
    for (size_t i = 0; i < n; i++) {
        state = state * 1664525u + 1013904223u;
        voxels[i] = (unsigned char)(state >> 24);
    }
}

static void write_volume(const char *path, enum brick_type type, const struct brick_geometry *geometry,
                         const void *voxels)
{
    struct brick_sink *sink = NULL;
    struct brick_error err = {.message = ""};
    const unsigned char *p = voxels;
    size_t slice = (size_t)(geometry->dims[0] * geometry->dims[1]) * brick_type_bytes(type);
    if (fmt_sink_create(&sink, path, type, geometry, &err) || sink->write(sink, 0, 2, p, &err) ||
        sink->write(sink, 2, 1, p + 2 * slice, &err) || sink->finish(sink, &err))
        fail_msg("%s", err.message);
    brick_sink_destroy(&sink);
}

static void every_type_and_format(void **state)
{
    (void)state;
    static const struct {
        const char *ending;
        unsigned files;
        double tolerance; /* of the affine: exact, or the rounding of a direction times a spacing */
    } formats[] = {{"raw", 1, 0}, {"nrrd", 1, 0}, {"mha", 1, 1e-15}, {"mhd", 2, 1e-15}};
    unsigned char voxels[5 * 4 * 3 * 8];
    fill(voxels, sizeof voxels);
    for (int type = 0; type < BRICK_TYPE_COUNT; type++)
        for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
            char name[64];
            snprintf(name, sizeof name, "v.%s", formats[i].ending);
            const char *path = in_folder(name);
            write_volume(path, (enum brick_type)type, &oblique, voxels);
            assert_int_equal(count_files(), formats[i].files);
            struct fmt_source_params params = fmt_source_defaults;
            bool raw = strcmp(formats[i].ending, "raw") == 0;
            if (raw) {
                memcpy(params.dims, dims, sizeof dims);
                params.type = (enum brick_type)type;
                params.has_affine = params.has_slope = params.has_intercept = true;
                memcpy(params.affine, oblique.affine, sizeof params.affine);
                params.slope = oblique.slope;
                params.intercept = oblique.intercept;
            }
            expect_voxels(path, &params, dims, (enum brick_type)type, voxels);
            struct brick_source *source = open_source(path, &params);
            assert_true(source->geometry.slope == oblique.slope);
            assert_true(source->geometry.intercept == oblique.intercept);
            assert_int_equal(source->input_bytes, 60 * brick_type_bytes((enum brick_type)type));
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 4; c++)
                    assert_true(fabs(source->geometry.affine[r][c] - oblique.affine[r][c]) <=
                                formats[i].tolerance * fabs(oblique.affine[r][c]));
            brick_source_destroy(&source);
            empty_folder(NULL);
        }
}

static void unfinished_leaves_nothing(void **state)
{
    (void)state;
    static const char *const names[] = {"v.raw", "v.nrrd", "v.mha", "v.mhd"};
    unsigned char voxels[60] = {0};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        struct brick_sink *sink = NULL;
        struct brick_error err;
        assert_int_equal(fmt_sink_create(&sink, in_folder(names[i]), BRICK_U8, &oblique, &err), 0);
        assert_int_equal(sink->write(sink, 0, 2, voxels, &err), 0);
        assert_int_equal(access(in_folder(names[i]), F_OK), -1);
        /* Too early, out of order and too much are refused. */
        assert_int_equal(sink->finish(sink, &err), BRICK_ERR_ARGUMENT);
        assert_int_equal(sink->write(sink, 0, 1, voxels, &err), BRICK_ERR_ARGUMENT);
        assert_int_equal(sink->write(sink, 2, 2, voxels, &err), BRICK_ERR_ARGUMENT);
        brick_sink_destroy(&sink);
        assert_null(sink);
        assert_int_equal(count_files(), 0);
    }
}

static void sinks_say_what_is_wrong(void **state)
{
    (void)state;
    struct brick_sink *sink = NULL;
    struct brick_error err;
    assert_int_equal(fmt_sink_create(&sink, in_folder("v.jpg"), BRICK_U8, &oblique, &err),
                     BRICK_ERR_UNSUPPORTED);
    assert_non_null(strstr(err.message, ".nrrd"));
    assert_int_equal(fmt_sink_create(&sink, in_folder("none/v.nrrd"), BRICK_U8, &oblique, &err),
                     BRICK_ERR_IO);
    assert_non_null(strstr(err.message, "none/v.nrrd"));
    /* Voxels of a new .mhd never replace a .raw that was there without one. */
    put_file("v.raw", "precious", NULL, 0);
    assert_int_equal(fmt_sink_create(&sink, in_folder("v.mhd"), BRICK_U8, &oblique, &err),
                     BRICK_ERR_ARGUMENT);
    assert_non_null(strstr(err.message, "v.raw"));
    assert_int_equal(count_files(), 1);
    assert_null(sink);
    unsigned char voxels[60] = {0};
    put_file("v.mhd", "old", NULL, 0);
    write_volume(in_folder("v.mhd"), BRICK_U8, &oblique, voxels);
    expect_voxels(in_folder("v.mhd"), NULL, dims, BRICK_U8, voxels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(every_type_and_format, empty_folder),
        cmocka_unit_test_teardown(unfinished_leaves_nothing, empty_folder),
        cmocka_unit_test_teardown(sinks_say_what_is_wrong, empty_folder),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
