/* MetaImage headers as other programs write them, and as nobody should. */
#include "header_files.h"

#include <zlib.h>

#define SHAPE "ObjectType = Image\nNDims = 3\nDimSize = 3 2 2\nElementType = MET_SHORT\n"
#define LOCAL "ElementDataFile = LOCAL\n"

static const char *put_mha(const char *header)
{
    return put_file("v.mha", header, voxels, sizeof voxels);
}

static const char *put_mhd(const char *header)
{
    return put_file("v.mhd", header, NULL, 0);
}

static void local_and_beside(void **state)
{
    (void)state;
    expect_all(put_mha(SHAPE LOCAL));
    expect_all(put_mha("Comment = a = b: c\r\nNDims = 3\r\nDimSize: 3 2 2 \r\n\r\nElementType = MET_SHORT\r\n"
                       "BinaryData = True\r\nFavouriteColour = blue\r\nElementDataFile = local\r\n"));
    put_file("d.raw", "header", voxels, sizeof voxels);
    expect_all(put_mhd(SHAPE "HeaderSize = 6\nElementDataFile = d.raw"));
    expect_all(put_mhd(SHAPE "HeaderSize = -1\nElementDataFile = ./d.raw\n"));
    struct brick_source *source = open_source(in_folder("v.mhd"), NULL);
    assert_string_equal(source->provenance,
                        "format: metaimage\nsource_type: i16\nsource_endian: little\nencoding: raw\n");
    brick_source_destroy(&source);
    expect_failure(put_mhd(SHAPE "HeaderSize = 7\nElementDataFile = d.raw\n"), NULL, BRICK_ERR_FORMAT,
                   "d.raw: truncated");
    expect_failure(put_mhd(SHAPE "ElementDataFile = gone.raw\n"), NULL, BRICK_ERR_IO, "gone.raw");
    /* Two axes make one slice. */
    static const uint64_t flat[3] = {3, 2, 1};
    expect_voxels(put_mha("NDims = 2\nDimSize = 3 2\nElementType = MET_SHORT\n" LOCAL), NULL, flat, BRICK_I16,
                  voxels);
}

static void both_byte_orders(void **state)
{
    (void)state;
    expect_all(put_file("v.mha", SHAPE "BinaryDataByteOrderMSB = True\n" LOCAL, swapped(), 24));
    expect_all(put_file("v.mha", SHAPE "ElementByteOrderMSB = true\n" LOCAL, swapped(), 24));
    expect_all(put_mha(SHAPE "BinaryDataByteOrderMSB = True\nElementByteOrderMSB = False\n" LOCAL));
}

static void all_types(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        enum brick_type type;
    } names[] = {
        {"MET_CHAR", BRICK_I8},    {"MET_UCHAR", BRICK_U8},  {"MET_SHORT", BRICK_I16},
        {"MET_USHORT", BRICK_U16}, {"MET_INT", BRICK_I32},   {"MET_UINT", BRICK_U32},
        {"MET_LONG", BRICK_I32},   {"MET_ULONG", BRICK_U32}, {"MET_FLOAT", BRICK_F32},
        {"MET_DOUBLE", BRICK_F64},
    };
    static const uint64_t three[3] = {3, 1, 1};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char header[256];
        snprintf(header, sizeof header, "NDims = 3\nDimSize = 3 1 1\nElementType = %s\n" LOCAL,
                 names[i].name);
        expect_voxels(put_mha(header), NULL, three, names[i].type, voxels);
    }
}

static void compressed(void **state)
{
    (void)state;
    unsigned char packed[256];
    uLongf n = sizeof packed;
    assert_int_equal(compress(packed, &n, (const Bytef *)voxels, sizeof voxels), Z_OK);
    char sized[256];
    snprintf(sized, sizeof sized, SHAPE "CompressedData = True\nCompressedDataSize = %lu\n" LOCAL, n);
    expect_all(put_file("v.mha", SHAPE "CompressedData = True\n" LOCAL, packed, n));
    expect_all(put_file("v.mha", sized, packed, n));
    expect_failure(put_file("v.mha", sized, packed, n - 1), NULL, BRICK_ERR_FORMAT, "truncated");
    for (size_t cut = 0; cut < n; cut++)
        expect_failure(put_file("v.mha", SHAPE "CompressedData = True\n" LOCAL, packed, cut), NULL,
                       BRICK_ERR_FORMAT, "truncated");
    put_file("v.zraw", "head", packed, n);
    snprintf(sized, sizeof sized,
             SHAPE
             "CompressedData = True\nCompressedDataSize = %lu\nHeaderSize = -1\nElementDataFile = v.zraw\n",
             n);
    expect_all(put_mhd(sized));
    expect_failure(put_mhd(SHAPE "CompressedData = True\nHeaderSize = -1\nElementDataFile = v.zraw\n"), NULL,
                   BRICK_ERR_UNSUPPORTED, "compressed size");
    /* A stream for each slice. */
    for (int i = 0; i < 2; i++) {
        n = sizeof packed;
        assert_int_equal(compress(packed, &n, (const Bytef *)(voxels + 6 * i), 12), Z_OK);
        put_file(i ? "s1.zraw" : "s0.zraw", "", packed, n);
    }
    expect_all(put_mhd(SHAPE "CompressedData = True\nElementDataFile = LIST\ns0.zraw\ns1.zraw\n"));
}

static void slices_in_files(void **state)
{
    (void)state;
    put_file("s008.raw", "", voxels, 12);
    put_file("s010.raw", "", voxels + 6, 12);
    expect_all(put_mhd(SHAPE "ElementDataFile = LIST\ns008.raw\ns010.raw\n"));
    expect_all(put_mhd(SHAPE "ElementDataFile = LIST 2\r\ns008.raw \r\ns010.raw"));
    expect_all(put_mhd(SHAPE "ElementDataFile = s%03d.raw 8 10 2\n"));
    put_file("all.raw", "", voxels, 24);
    expect_all(put_mhd(SHAPE "ElementDataFile = LIST 3\nall.raw\n"));
    expect_failure(put_mhd(SHAPE "ElementDataFile = LIST\ns008.raw\n"), NULL, BRICK_ERR_FORMAT,
                   "1 data files, its DimSize needs 2");
    expect_failure(put_mhd(SHAPE "ElementDataFile = s%03d.raw 8 10\n"), NULL, BRICK_ERR_FORMAT,
                   "3 data files");
    expect_failure(put_mhd(SHAPE "ElementDataFile = s%03d.raw 8 9\n"), NULL, BRICK_ERR_IO, "s009.raw");
}

/* Row i of the matrix is the direction of index axis i: checked by hand on a matrix that is not symmetric. */
static void world(void **state)
{
    (void)state;
    static const double turned[3][4] = {{0, -3, 0, 10}, {2, 0, 0, 20}, {0, 0, 4, 30}};
    expect_affine(
        put_mha(SHAPE
                "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nElementSpacing = 2 3 4\nOffset = 10 20 30\n" LOCAL),
        NULL, turned, 0);
    expect_affine(
        put_mha(SHAPE "Rotation = 0 1 0 -1 0 0 0 0 1\nElementSize = 2 3 4\nPosition = 10 20 30\n" LOCAL),
        NULL, turned, 0);
    expect_affine(
        put_mha(SHAPE "Orientation = 0 1 0 -1 0 0 0 0 1\nElementSize = 9 9 9\nElementSpacing = 0.2 0.3 0.4\n"
                      "Origin = 1 2 3\nDistanceUnits = cm\n" LOCAL),
        NULL, turned, 1e-14);
    static const double flat[3][4] = {{0, -3, 0, 10}, {2, 0, 0, 20}, {0, 0, 1, 0}};
    expect_affine(put_mha("NDims = 2\nDimSize = 3 2\nElementType = MET_SHORT\nTransformMatrix = 0 1 -1 0\n"
                          "ElementSpacing = 2 3\nOffset = 10 20\n" LOCAL),
                  NULL, flat, 0);
    struct brick_source *source = open_source(
        put_mha(SHAPE "ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1\n" LOCAL),
        NULL);
    assert_true(source->geometry.slope == 2.0 && source->geometry.intercept == -1.0);
    brick_source_destroy(&source);
}

static void bad_headers(void **state)
{
    (void)state;
    static const struct bad_header table[] = {
        {"", FORMAT, "no 'ElementDataFile'"},
        {SHAPE, FORMAT, "no 'ElementDataFile'"},
        {"GIF89a\n" SHAPE LOCAL, FORMAT, "line 1"},
        {"= 3\n" SHAPE LOCAL, FORMAT, "line 1"},
        {SHAPE SHAPE LOCAL, FORMAT, "twice"},
        {"ObjectType = Tube\n" LOCAL, BRICK_ERR_UNSUPPORTED, "Tube"},
        {"NDims = 3\nElementType = MET_CHAR\n" LOCAL, FORMAT, "no 'DimSize'"},
        {"DimSize = 1 1 1\nElementType = MET_CHAR\n" LOCAL, FORMAT, "no 'NDims'"},
        {"NDims = 3\nDimSize = 1 1 1\n" LOCAL, FORMAT, "no 'ElementType'"},
        {"NDims = 0\nDimSize = 1\nElementType = MET_CHAR\n" LOCAL, FORMAT, "NDims = 0"},
        {"NDims = 4\nDimSize = 1 1 1 1\nElementType = MET_CHAR\n" LOCAL, BRICK_ERR_UNSUPPORTED,
         "4 dimensions"},
        {"NDims = 3\nDimSize = 1 1\nElementType = MET_CHAR\n" LOCAL, FORMAT, "DimSize"},
        {"NDims = 3\nDimSize = 1 1 1 1\nElementType = MET_CHAR\n" LOCAL, FORMAT, "DimSize"},
        {"NDims = 3\nDimSize = 1 -1 1\nElementType = MET_CHAR\n" LOCAL, FORMAT, "DimSize"},
        {"NDims = 3\nDimSize = 1 0 1\nElementType = MET_CHAR\n" LOCAL, FORMAT, "size 0"},
        {"NDims = 3\nDimSize = 99999999999999999999 1 1\nElementType = MET_CHAR\n" LOCAL, FORMAT, "DimSize"},
        {"NDims = 3\nDimSize = 4294967296 4294967296 2\nElementType = MET_CHAR\n" LOCAL, FORMAT, "beyond"},
        {"NDims = 3\nDimSize = 100000 100000 100\nElementType = MET_CHAR\n" LOCAL, FORMAT, "truncated"},
        {"NDims = 3\nDimSize = 100000 100000 100\nElementType = MET_CHAR\nCompressedData = True\n" LOCAL,
         FORMAT, "truncated"},
        {"NDims = 3\nDimSize = 1 1 18446744073709551615\nElementType = MET_CHAR\nElementDataFile = "
         "LIST\nv.mha\n",
         FORMAT, "needs 18446744073709551615"},
        {"NDims = 3\nDimSize = 1 1 1\nElementType = MET_PIXEL\n" LOCAL, FORMAT, "MET_PIXEL"},
        {"NDims = 3\nDimSize = 1 1 1\nElementType = MET_LONG_LONG\n" LOCAL, BRICK_ERR_UNSUPPORTED,
         "MET_LONG_LONG"},
        {SHAPE "ElementNumberOfChannels = 3\n" LOCAL, BRICK_ERR_UNSUPPORTED, "3 channels"},
        {SHAPE "ElementNumberOfChannels = one\n" LOCAL, FORMAT, "ElementNumberOfChannels"},
        {SHAPE "BinaryData = False\n" LOCAL, BRICK_ERR_UNSUPPORTED, "as text"},
        {SHAPE "BinaryDataByteOrderMSB = maybe\n" LOCAL, FORMAT, "maybe"},
        {SHAPE "CompressedData = True\nCompressedDataSize = -4\n" LOCAL, FORMAT, "CompressedDataSize"},
        {SHAPE "CompressedData = True\nCompressedDataSize = 18446744073709551615\n" LOCAL, FORMAT,
         "truncated"},
        {SHAPE "HeaderSize = -2\n" LOCAL, FORMAT, "HeaderSize"},
        {SHAPE "HeaderSize = 9223372036854775807\n" LOCAL, FORMAT, "truncated"},
        {SHAPE "ElementSpacing = 1 1\n" LOCAL, FORMAT, "ElementSpacing"},
        {SHAPE "ElementSpacing = 1 1 nan\n" LOCAL, FORMAT, "ElementSpacing"},
        {SHAPE "ElementSpacing = 1 1 0\n" LOCAL, FORMAT, "truncated"},
        {SHAPE "Offset = 1 1 1,5\n" LOCAL, FORMAT, "Offset"},
        {SHAPE "Offset = 1 1 inf\n" LOCAL, FORMAT, "Offset"},
        {SHAPE "TransformMatrix = 1 0 0 0 1 0 0 0\n" LOCAL, FORMAT, "TransformMatrix"},
        {SHAPE "ElementToIntensityFunctionSlope = x\n" LOCAL, FORMAT, "Slope"},
        {SHAPE "ElementDataFile = \n", FORMAT, "empty"},
        {SHAPE "ElementDataFile = LIST 4\nv.mha\n", FORMAT, "ElementDataFile"},
        {SHAPE "ElementDataFile = LIST\n", FORMAT, "names 0 data files"},
        {SHAPE "ElementDataFile = a%s 1 2\n", FORMAT, "series"},
        {SHAPE "ElementDataFile = a%d 1 2 1 1\n", FORMAT, "ElementDataFile"},
        {SHAPE "ElementDataFile = /dev/zero\n", BRICK_ERR_IO, "regular file"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        expect_failure(put_file("v.mha", table[i].header, NULL, 0), NULL, table[i].code, table[i].says);
    /* Whole, but with a geometry that no grid can have. */
    expect_failure(put_mha(SHAPE "ElementSpacing = 1 1 0\n" LOCAL), NULL, FORMAT, "spacing 0");
    expect_failure(put_mha(SHAPE "TransformMatrix = 1 0 0 0 1 0 0 1 0\n" LOCAL), NULL, FORMAT, "singular");
    expect_failure(put_mha(SHAPE "ElementToIntensityFunctionSlope = 0\n" LOCAL), NULL, FORMAT, "slope");
    expect_failure(put_file("v.mha", SHAPE LOCAL, voxels, 23), NULL, FORMAT, "truncated");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(local_and_beside, empty_folder),
        cmocka_unit_test_teardown(both_byte_orders, empty_folder),
        cmocka_unit_test_teardown(all_types, empty_folder),
        cmocka_unit_test_teardown(compressed, empty_folder),
        cmocka_unit_test_teardown(slices_in_files, empty_folder),
        cmocka_unit_test_teardown(world, empty_folder),
        cmocka_unit_test_teardown(bad_headers, empty_folder),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
