/* Raw files: exact sizes, byte order, skipping, the geometry that callers give; and how endings choose a
 * format. */
#include "format_files.h"

static const uint64_t dims[3] = {3, 2, 2};
static const uint16_t voxels[12] = {0, 1, 255, 256, 65535, 43981, 7, 8, 9, 10, 11, 0x1234};

static struct fmt_source_params u16_params(void)
{
    struct fmt_source_params params = fmt_source_defaults;
    memcpy(params.dims, dims, sizeof dims);
    params.type = BRICK_U16;
    return params;
}

static void reads_both_byte_orders(void **state)
{
    (void)state;
    unsigned char big[24];
    for (int i = 0; i < 12; i++) {
        big[2 * i] = (unsigned char)(voxels[i] >> 8);
        big[2 * i + 1] = (unsigned char)voxels[i];
    }
    struct fmt_source_params params = u16_params();
    expect_voxels(put_file("v.raw", "", voxels, sizeof voxels), &params, dims, BRICK_U16, voxels);
    params.big_endian = true;
    params.skip_bytes = 5;
    const char *path =
        put_file("v.anything", "skip!", big, sizeof big); /* unknown ending, but size and type given */
    expect_voxels(path, &params, dims, BRICK_U16, voxels);
    struct brick_source *source = open_source(path, &params);
    assert_string_equal(source->provenance,
                        "format: raw\nsource_type: u16\nsource_endian: big\nencoding: raw\n");
    brick_source_destroy(&source);
}

static void size_is_exact(void **state)
{
    (void)state;
    struct fmt_source_params params = u16_params();
    const char *path = put_file("v.raw", "", voxels, 23);
    expect_failure(path, &params, BRICK_ERR_FORMAT,
                   "wrong size for --size 3x2x2 --type u16: expected 24 bytes, found 23");
    put_file("v.raw", "!", voxels, 24);
    expect_failure(path, &params, BRICK_ERR_FORMAT,
                   "expected 24 bytes, found 25; check --size and --type, or --skip");
    params.skip_bytes = 2;
    expect_failure(path, &params, BRICK_ERR_FORMAT, "expected 26 bytes, found 25");
    params.skip_bytes = UINT64_MAX;
    expect_failure(path, &params, BRICK_ERR_ARGUMENT, "cannot skip");
    params.skip_bytes = INT64_MAX;
    expect_failure(path, &params, BRICK_ERR_FORMAT, "wrong size");
    params = u16_params();
    params.dims[1] = 0;
    expect_failure(path, &params, BRICK_ERR_FORMAT, "axis 1 has size 0");
    params.dims[1] = UINT64_MAX;
    expect_failure(path, &params, BRICK_ERR_FORMAT, "beyond any file");
    params.dims[0] = params.dims[1] = params.dims[2] = UINT64_C(1) << 40;
    expect_failure(path, &params, BRICK_ERR_FORMAT, "beyond any file");
    params.dims[0] = params.dims[1] = UINT64_C(1) << 30;
    params.dims[2] = 1;
    expect_failure(path, &params, BRICK_ERR_FORMAT, "expected 2305843009213693952 bytes");
}

static void endings_choose(void **state)
{
    (void)state;
    struct fmt_source_params params = u16_params();
    expect_failure(in_folder("missing.nrrd"), NULL, BRICK_ERR_IO, "missing.nrrd");
    expect_failure(in_folder("missing.xyz"), &params, BRICK_ERR_IO, "missing.xyz");
    expect_failure(put_file("v.xyz", "", voxels, 24), NULL, BRICK_ERR_UNSUPPORTED,
                   "NRRD (.nrrd .nhdr), MetaImage");
    expect_failure(put_file("v.raw", "", voxels, 24), NULL, BRICK_ERR_ARGUMENT, "needs --size and --type");
    expect_failure(put_file("v.nrrd", "", voxels, 24), &params, BRICK_ERR_ARGUMENT, "are for raw files");
    expect_voxels(put_file("v.IMG", "", voxels, 24), &params, dims, BRICK_U16, voxels);
}

static void geometry_is_the_callers(void **state)
{
    (void)state;
    const char *path = put_file("v.raw", "", voxels, 24);
    struct fmt_source_params params = u16_params();
    static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    expect_affine(path, &params, identity, 0);
    params.has_spacing = params.has_origin = true;
    memcpy(params.spacing_mm, (double[3]){0.5, 2, 3}, sizeof params.spacing_mm);
    memcpy(params.origin_mm, (double[3]){-7, 8, 9}, sizeof params.origin_mm);
    static const double lps[3][4] = {{0.5, 0, 0, -7}, {0, 2, 0, 8}, {0, 0, 3, 9}};
    expect_affine(path, &params, lps, 0);
    strcpy(params.axes, "SAR"); /* x to superior, y to anterior, z to the right */
    static const double sar[3][4] = {{0, 0, -3, -7}, {0, -2, 0, 8}, {0.5, 0, 0, 9}};
    expect_affine(path, &params, sar, 0);
    strcpy(params.axes, "LRS");
    expect_failure(path, &params, BRICK_ERR_ARGUMENT, "LRS");
    params.has_affine = true;
    expect_failure(path, &params, BRICK_ERR_ARGUMENT, "not both");
    params = u16_params();
    params.has_affine = true;
    params.affine[2][2] = 0; /* singular */
    expect_failure(path, &params, BRICK_ERR_FORMAT, "v.raw");
    params = u16_params();
    params.has_spacing = true;
    params.spacing_mm[1] = -1;
    expect_failure(path, &params, BRICK_ERR_ARGUMENT, "spacing");
    params = u16_params();
    params.has_slope = true;
    params.slope = 0;
    expect_failure(path, &params, BRICK_ERR_FORMAT, "slope");
}

static void reads_stay_inside(void **state)
{
    (void)state;
    struct fmt_source_params params = u16_params();
    struct brick_source *source = open_source(put_file("v.raw", "", voxels, 24), &params);
    uint16_t got[12];
    assert_int_equal(source->read(source, 1, 2, got, NULL), BRICK_ERR_ARGUMENT);
    assert_int_equal(source->read(source, 3, 0, got, NULL), BRICK_ERR_ARGUMENT);
    assert_int_equal(source->read(source, 0, UINT64_MAX, got, NULL), BRICK_ERR_ARGUMENT);
    assert_int_equal(source->read(source, 1, 1, got, NULL), 0);
    assert_memory_equal(got, voxels + 6, 12);
    brick_source_destroy(&source);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(reads_both_byte_orders, empty_folder),
        cmocka_unit_test_teardown(size_is_exact, empty_folder),
        cmocka_unit_test_teardown(endings_choose, empty_folder),
        cmocka_unit_test_teardown(geometry_is_the_callers, empty_folder),
        cmocka_unit_test_teardown(reads_stay_inside, empty_folder),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
