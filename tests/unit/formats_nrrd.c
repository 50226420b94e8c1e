/* NRRD headers as other programs write them, and as nobody should. */
#include "header_files.h"

#include <math.h>
#include <zlib.h>

#define SHAPE  "type: short\ndimension: 3\nsizes: 3 2 2\nendian: little\n"
#define HEADER "NRRD0004\n" SHAPE "encoding: raw\n"

static const char *put_nrrd(const char *header)
{
    return put_file("v.nrrd", header, voxels, sizeof voxels);
}

static const char *put_nhdr(const char *header)
{
    return put_file("v.nhdr", header, NULL, 0);
}

/* gzip of n bytes, in members of at most `member` bytes. */
static size_t gzip(const void *src, size_t n, size_t member, unsigned char *dst, size_t room)
{
    size_t at = 0;
    for (size_t i = 0; i < n; i += member) {
        z_stream z = {0};
        assert_int_equal(deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
        z.next_in = (Bytef *)(uintptr_t)((const unsigned char *)src + i);
        z.avail_in = (uInt)(n - i < member ? n - i : member);
        z.next_out = dst + at;
        z.avail_out = (uInt)(room - at);
        assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
        at = room - z.avail_out;
        deflateEnd(&z);
    }
    return at;
}

static void attached_raw(void **state)
{
    (void)state;
    expect_all(put_nrrd(HEADER "\n"));
    expect_all(
        put_nrrd("NRRD0001\r\n# comment: no field\r\ntype:int16_t\r\ndimension: 3 \r\nSIZES:  3\t2 2\r\n"
                 "Endian: Little\r\nkey:=a: b\r\nunknown field: 7\r\nencoding: RAW\r\n\r\n"));
    expect_all(put_file("v.nrrd",
                        "NRRD0005\ntype: signed short int\ndimension: 3\nsizes: 3 2 2\nendian: big\n"
                        "encoding: raw\ncontent: caf\xc3\xa9\nspace: LPS\n\n",
                        swapped(), 24));
    struct brick_source *source = open_source(in_folder("v.nrrd"), NULL);
    assert_string_equal(source->provenance,
                        "format: nrrd\nsource_type: i16\nsource_endian: big\nencoding: raw\n"
                        "space: LPS\ncontent: caf??\n");
    brick_source_destroy(&source);
}

static void types_by_all_names(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        enum brick_type type;
    } names[] = {
        {"signed char", BRICK_I8},   {"int8", BRICK_I8},        {"uchar", BRICK_U8},
        {"unsigned char", BRICK_U8}, {"uint8_t", BRICK_U8},     {"signed short", BRICK_I16},
        {"int16", BRICK_I16},        {"ushort", BRICK_U16},     {"unsigned short int", BRICK_U16},
        {"uint16_t", BRICK_U16},     {"signed int", BRICK_I32}, {"int32", BRICK_I32},
        {"unsigned int", BRICK_U32}, {"uint32_t", BRICK_U32},   {"Float", BRICK_F32},
        {"double", BRICK_F64},
    };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char header[256];
        snprintf(header, sizeof header,
                 "NRRD0001\ntype: %s\ndimension: 1\nsizes: 3\nencoding: raw\nendian: little\n\n",
                 names[i].name);
        static const uint64_t line[3] = {3, 1, 1};
        expect_voxels(put_nrrd(header), NULL, line, names[i].type, voxels);
    }
}

static void gzip_is_streamed(void **state)
{
    (void)state;
    unsigned char packed[512];
    size_t n = gzip(voxels, sizeof voxels, 1000, packed, sizeof packed);
    const char *header = "NRRD0004\n" SHAPE "encoding: gzip\n\n";
    expect_all(put_file("v.nrrd", header, packed, n));
    struct brick_source *source = open_source(in_folder("v.nrrd"), NULL);
    assert_non_null(strstr(source->provenance, "encoding: gzip"));
    assert_int_equal(source->input_bytes, n);
    /* Compressed slices may be left out, but do not come again. */
    int16_t got[12];
    assert_int_equal(source->read(source, 1, 1, got, NULL), 0);
    assert_memory_equal(got, voxels + dims[0] * dims[1], dims[0] * dims[1] * sizeof *got);
    assert_int_equal(source->read(source, 0, 1, got, NULL), BRICK_ERR_ARGUMENT);
    brick_source_destroy(&source);

    /* Every truncation is noticed, the last ones by the missing checksum. */
    for (size_t cut = 0; cut < n; cut++)
        expect_failure(put_file("v.nrrd", header, packed, cut), NULL, BRICK_ERR_FORMAT, "truncated");
    assert_true(n > 8 && n < sizeof packed);
    packed[n - 8] ^= 1; /* the stored CRC */
    expect_failure(put_file("v.nrrd", header, packed, n), NULL, BRICK_ERR_FORMAT, "incorrect data check");
    packed[n - 8] ^= 1;
    expect_failure(put_file("v.nrrd",
                            "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 3\nendian: little\n"
                            "encoding: gz\n\n",
                            packed, n),
                   NULL, BRICK_ERR_FORMAT, "end early");
    expect_failure(put_file("v.nrrd",
                            "NRRD0004\ntype: short\ndimension: 3\nsizes: 3000 2000 3000\nendian: little\n"
                            "encoding: gz\n\n",
                            packed, n),
                   NULL, BRICK_ERR_FORMAT, "cannot hold");
    expect_failure(put_file("v.nrrd", header, "no gzip stream at all", 21), NULL, BRICK_ERR_FORMAT,
                   "damaged");

    /* Several members, bytes to skip inside the stream and lines before it; more than a buffer of it. */
    n = gzip(voxels, sizeof voxels, 7, packed, sizeof packed);
    assert_true(n > 0);
    expect_all(put_file("v.nrrd", header, packed, n));
    n = gzip(voxels, sizeof voxels, 1000, packed, sizeof packed);
    put_file("d.gz", "a\nb\n", packed, n);
    static const uint64_t flat[3] = {3, 2, 1};
    expect_voxels(put_nhdr("NRRD0004\ntype: short\ndimension: 2\nsizes: 3 2\nendian: little\nencoding: gzip\n"
                           "line skip: 2\nbyte skip: 12\ndata file: d.gz\n"),
                  NULL, flat, BRICK_I16, voxels + 6);

    enum { SIDE = 96, COUNT = SIDE * SIDE * SIDE };
    unsigned char *noise = malloc(COUNT), *deflated = malloc(2 * COUNT);
    assert_non_null(noise);
    assert_non_null(deflated);
    uint32_t seed = 1;
    for (size_t i = 0; i < COUNT; i++)
        noise[i] = (unsigned char)((seed = seed * 1664525u + 1013904223u) >> 24);
    n = gzip(noise, COUNT, COUNT, deflated, 2 * COUNT);
    struct brick_source *big = open_source(
        put_file("v.nrrd", "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 96 96 96\nencoding: gzip\n\n",
                 deflated, n),
        NULL);
    assert_int_equal(read_all(big, 5, deflated, NULL), 0);
    assert_memory_equal(deflated, noise, COUNT);
    brick_source_destroy(&big);
    free(noise);
    free(deflated);
}

static void detached(void **state)
{
    (void)state;
    put_file("data.raw", "header\nbytes", voxels, sizeof voxels);
    expect_all(put_nhdr(HEADER "data file: data.raw\nbyte skip: -1\n"));
    expect_all(put_nhdr(HEADER "datafile: ./data.raw\nlineskip: 1\nbyteskip: 5\n\n"));
    /* A name with % and no series is a name. */
    put_file("100%d", "", voxels, sizeof voxels);
    expect_all(put_nhdr(HEADER "data file: 100%d"));
    expect_failure(put_nhdr(HEADER "data file: gone.raw\n"), NULL, BRICK_ERR_IO, "gone.raw");
    expect_failure(put_nhdr(HEADER "data file: data.raw\nline skip: 9\n"), NULL, BRICK_ERR_FORMAT,
                   "lines to be skipped");
    expect_failure(put_nhdr(HEADER "data file: data.raw\nbyte skip: 9223372036854775807\n"), NULL,
                   BRICK_ERR_FORMAT, "truncated");
}

static void slices_in_files(void **state)
{
    (void)state;
    put_file("s1.raw", "", voxels, 12);
    put_file("s3.raw", "", voxels + 6, 12);
    expect_all(put_nhdr(HEADER "data file: LIST\ns1.raw\ns3.raw\n"));
    expect_all(put_nhdr(HEADER "data file: s%d.raw 1 3 2\n"));
    /* Slabs: here each file is a volume of one slice. */
    expect_all(put_nhdr(HEADER "data file: LIST 3\n\ns1.raw\r\ns3.raw"));
    /* Rows in files, last row first. */
    for (int i = 0; i < 4; i++) {
        char name[16];
        snprintf(name, sizeof name, "r%03d", 3 - i);
        put_file(name, "", voxels + 3 * i, 6);
    }
    expect_all(put_nhdr("NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 2\nendian: little\nencoding: raw\n"
                        "data file: r%03d 3 0 -1 1\n"));
    expect_failure(put_nhdr(HEADER "data file: LIST\ns1.raw\n"), NULL, BRICK_ERR_FORMAT,
                   "1 data files, its sizes need 2");
    expect_failure(put_nhdr(HEADER "data file: LIST\ns1.raw\ns2.raw\n"), NULL, BRICK_ERR_IO, "s2.raw");
    expect_failure(put_nhdr(HEADER "data file: s%d.raw 1 3\n"), NULL, BRICK_ERR_FORMAT, "3 data files");
    put_file("s3.raw", "", voxels + 6, 11);
    expect_failure(put_nhdr(HEADER "data file: LIST\ns1.raw\ns3.raw\n"), NULL, BRICK_ERR_FORMAT,
                   "s3.raw: truncated");
}

static void world(void **state)
{
    (void)state;
    static const double spaced[3][4] = {{0.5, 0, 0, 0}, {0, 0.25, 0, 0}, {0, 0, -2, 0}};
    expect_affine(put_nrrd(HEADER "spacings: 0.5 0.25 -2\n\n"), NULL, spaced, 0);
    static const double lps[3][4] = {{1, 4, 7, 10}, {2, 5, 8, 11}, {3, 6, 10, 12}};
    expect_affine(put_nrrd(HEADER
                           "space: left-posterior-superior\nspace directions: (1,2,3) (4, 5 ,6) (7,8,10)\n"
                           "space origin: (10,11,12)\n\n"),
                  NULL, lps, 0);
    static const double ras[3][4] = {{-1, -4, -7, -10}, {-2, -5, -8, -11}, {3, 6, 10, 12}};
    expect_affine(
        put_nrrd(HEADER
                 "space: RAS\nspace directions: (1,2,3) (4,5,6) (7,8,10)\nspace origin: (10,11,12)\n\n"),
        NULL, ras, 0);
    static const double las[3][4] = {{1, 4, 7, 10}, {-2, -5, -8, -11}, {3, 6, 10, 12}};
    expect_affine(put_nrrd(HEADER "space: left-anterior-superior\nspace directions: (1,2,3)(4,5,6)(7,8,10)\n"
                                  "space origin: (10,11,12)\nspace units: \"mm\" \"mm\" \"mm\"\n\n"),
                  NULL, las, 0);
    expect_affine(put_nrrd(HEADER "space: 3D-right-handed\nspace directions: (1,2,3) (4,5,6) (7,8,10)\n"
                                  "space origin: (10,11,12)\n\n"),
                  NULL, lps, 0);
    expect_affine(put_nrrd(HEADER
                           "space dimension: 3\nspace directions: (1e-1,2e-1,3e-1) (.4,.5,.6) (.7,.8,1)\n"
                           "space origin: (1,1.1,1.2)\nspace units: \"cm\" \"cm\" \"cm\"\n\n"),
                  NULL, lps, 1e-14);
    /* A slice in space: the missing axis stands on it. */
    static const double slice[3][4] = {{0, 0, 1, 5}, {2, 0, 0, 6}, {0, 3, 0, 7}};
    expect_affine(put_nrrd("NRRD0004\ntype: short\ndimension: 2\nsizes: 3 4\nendian: little\nencoding: raw\n"
                           "space: LPS\nspace directions: (0,2,0) (0,0,3)\nspace origin: (5,6,7)\n\n"),
                  NULL, slice, 0);
    /* The caller wins, and spacing keeps the directions. */
    struct fmt_source_params params = fmt_source_defaults;
    params.has_spacing = true;
    memcpy(params.spacing_mm, (double[3]){2.5, sqrt(77.0), sqrt(213.0)}, sizeof params.spacing_mm);
    static const double shorter[3][4] = {{2, 4, 7, 10}, {0, 5, 8, 11}, {1.5, 6, 10, 12}};
    expect_affine(
        put_nrrd(HEADER
                 "space: LPS\nspace directions: (4,0,3) (4,5,6) (7,8,10)\nspace origin: (10,11,12)\n\n"),
        &params, shorter, 1e-14);
    params = fmt_source_defaults;
    strcpy(params.axes, "LPS");
    params.has_spacing = true;
    static const double unit[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    expect_failure(put_nrrd(HEADER "spacings: nan 1 1\n\n"), NULL, BRICK_ERR_FORMAT, "not finite");
    expect_affine(in_folder("v.nrrd"), &params, unit, 0);
}

static void kinds_tell_values_from_axes(void **state)
{
    (void)state;
#define FOUR "NRRD0004\ntype: short\ndimension: 4\nendian: little\nencoding: raw\n"
    static const double spaced[3][4] = {{0.5, 0, 0, 0}, {0, 0.25, 0, 0}, {0, 0, 2, 0}};
    const char *path =
        put_nrrd(FOUR "sizes: 1 3 2 2\nkinds: vector space space space\nspacings: nan 0.5 0.25 2\n\n");
    expect_all(path);
    expect_affine(path, NULL, spaced, 0);
    path = put_nrrd(FOUR "sizes: 3 2 2 1\nkinds: domain domain domain time\nspacings: 0.5 0.25 2 1\n\n");
    expect_all(path);
    expect_all(put_nrrd(FOUR "sizes: 3 2 2 1\n\n"));
    expect_all(
        put_nrrd(FOUR "sizes: 1 3 2 2\nspace: LPS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n\n"));
    expect_failure(put_nrrd(FOUR "sizes: 3 2 2 1\nkinds: RGB-color domain domain domain\n\n"), NULL,
                   BRICK_ERR_UNSUPPORTED, "axis 0 (RGB-color, 3 values)");
    expect_failure(
        put_nrrd(FOUR "sizes: 3 2 1 2\nspace: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1) none\n\n"), NULL,
        BRICK_ERR_UNSUPPORTED, "axis 3 (no direction, 2 values)");
    expect_failure(put_nrrd("NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 2 2 3\nencoding: raw\n\n"), NULL,
                   BRICK_ERR_UNSUPPORTED, "4 NRRD axes are longer than 1");
    /* A vector of a three-dimensional header is a vector all the same. */
    expect_failure(put_nrrd(HEADER "kinds: 3-vector domain domain\n\n"), NULL, BRICK_ERR_UNSUPPORTED,
                   "3-vector");
}

static void slope_travels_as_keys(void **state)
{
    (void)state;
    struct brick_source *source = open_source(put_nrrd(HEADER "slope:=0.5\nintercept:= -1024\n\n"), NULL);
    assert_true(source->geometry.slope == 0.5 && source->geometry.intercept == -1024.0);
    brick_source_destroy(&source);
    struct fmt_source_params params = fmt_source_defaults;
    params.has_slope = true;
    params.slope = 3;
    source = open_source(in_folder("v.nrrd"), &params);
    assert_true(source->geometry.slope == 3.0 && source->geometry.intercept == -1024.0);
    brick_source_destroy(&source);
}

static void bad_headers(void **state)
{
    (void)state;
    static const struct bad_header table[] = {
        {"", FORMAT, "not a NRRD file"},
        {"NRRD0006\n" SHAPE "encoding: raw\n\n", FORMAT, "not a NRRD file"},
        {"NRRD0004", FORMAT, "truncated"},
        {"NRRD0004\n", FORMAT, "header"},
        {HEADER, FORMAT, "header"},
        {HEADER "no colon here\n\n", FORMAT, "line 7"},
        {HEADER "sizes: 3 2 2\n\n", FORMAT, "twice"},
        {"NRRD0004\ndimension: 3\nsizes: 3 2 2\nendian: little\nencoding: raw\n\n", FORMAT,
         "no field 'type'"},
        {"NRRD0004\ntype: short\nsizes: 3 2 2\nendian: little\nencoding: raw\n\n", FORMAT,
         "no field 'dimension'"},
        {"NRRD0004\ntype: short\ndimension: 3\nendian: little\nencoding: raw\n\n", FORMAT,
         "no field 'sizes'"},
        {"NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 2\nencoding: raw\n\n", FORMAT, "no field 'endian'"},
        {"NRRD0004\n" SHAPE "\n", FORMAT, "no field 'encoding'"},
        {"NRRD0004\n" SHAPE "encoding: lzma\n\n", FORMAT, "encoding: lzma"},
        {"NRRD0004\n" SHAPE "encoding: text\n\n", BRICK_ERR_UNSUPPORTED, "'text'"},
        {"NRRD0004\n" SHAPE "encoding: hex\n\n", BRICK_ERR_UNSUPPORTED, "'hex'"},
        {"NRRD0004\n" SHAPE "encoding: bzip2\n\n", BRICK_ERR_UNSUPPORTED, "'bzip2'"},
        {"NRRD0004\ntype: int64\ndimension: 1\nsizes: 3\nendian: little\nencoding: raw\n\n",
         BRICK_ERR_UNSUPPORTED, "'int64'"},
        {"NRRD0004\ntype: block\ndimension: 1\nsizes: 3\nencoding: raw\n\n", BRICK_ERR_UNSUPPORTED,
         "'block'"},
        {"NRRD0004\ntype: char\ndimension: 1\nsizes: 3\nencoding: raw\n\n", FORMAT, "type: char"},
        {"NRRD0004\ntype: uchar\ndimension: 0\nsizes: \nencoding: raw\n\n", FORMAT, "dimension"},
        {"NRRD0004\ntype: uchar\ndimension: 17\nsizes: 1\nencoding: raw\n\n", FORMAT, "dimension"},
        {"NRRD0004\ntype: uchar\ndimension: 3x\nsizes: 1 1 1\nencoding: raw\n\n", FORMAT, "dimension"},
        {"NRRD0004\ntype: uchar\ndimension: -1\nsizes: 1\nencoding: raw\n\n", FORMAT, "dimension"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2\nencoding: raw\n\n", FORMAT, "sizes"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 2 2\nencoding: raw\n\n", FORMAT, "sizes"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 -2 2\nencoding: raw\n\n", FORMAT, "sizes"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 2.5\nencoding: raw\n\n", FORMAT, "sizes"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 0 2\nencoding: raw\n\n", FORMAT, "axis 1 has size 0"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 18446744073709551616 1 1\nencoding: raw\n\n", FORMAT,
         "sizes"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 18446744073709551615 2 2\nencoding: raw\n\n", FORMAT,
         "beyond"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4294967296 4294967296 4294967296\nencoding: raw\n\n",
         FORMAT, "beyond"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1000000 1000000 1000\nencoding: raw\n\n", FORMAT,
         "truncated"},
        {"NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 2\nendian: middle\nencoding: raw\n\n", FORMAT,
         "endian"},
        {HEADER "spacings: 1 1\n\n", FORMAT, "spacings"},
        {HEADER "spacings: 1 0 1\n\n", FORMAT, "spacing"},
        {HEADER "spacings: 1 inf 1\n\n", FORMAT, "not finite"},
        {HEADER "spacings: 1 1e400 1\n\n", FORMAT, "spacings"},
        {HEADER "spacings: 1 0x10 1\n\n", FORMAT, "spacings"},
        {HEADER "spacings: 1 one 1\n\n", FORMAT, "spacings"},
        {HEADER "kinds: domain domain\n\n", FORMAT, "kinds"},
        {HEADER "kinds: domain domain domain domain\n\n", FORMAT, "kinds"},
        {HEADER "space: left-posterior-inferior\n\n", BRICK_ERR_UNSUPPORTED, "left-posterior-inferior"},
        {HEADER "space dimension: 4\n\n", BRICK_ERR_UNSUPPORTED, "4 dimensions"},
        {HEADER "space dimension: 0\n\n", FORMAT, "space dimension"},
        {HEADER "space: LPS\nspace directions: (1,0,0) (0,1,0)\n\n", FORMAT, "space directions"},
        {HEADER "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1) (0,0,1)\n\n", FORMAT,
         "space directions"},
        {HEADER "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,nan)\n\n", FORMAT, "space directions"},
        {HEADER "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0)\n\n", FORMAT, "space directions"},
        {HEADER "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1,0)\n\n", FORMAT, "space directions"},
        {HEADER "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1\n\n", FORMAT, "space directions"},
        {HEADER "space: LPS\nspace directions: 1,0,0 0,1,0 0,0,1\n\n", FORMAT, "space directions"},
        {HEADER "space: LPS\nspace directions: (1,0,0) (0,1,0) (1,1,0)\n\n", FORMAT, "singular"},
        {HEADER "space: LPS\nspace origin: (1,2)\n\n", FORMAT, "space origin"},
        {HEADER "space: LPS\nspace units: mm mm mm\n\n", FORMAT, "space units"},
        {HEADER "units: \"mm\" \"mm\n\n", FORMAT, "units"},
        {HEADER "byte skip: -2\n\n", FORMAT, "byte skip"},
        {HEADER "byte skip: 1k\n\n", FORMAT, "byte skip"},
        {"NRRD0004\n" SHAPE "encoding: gzip\nbyte skip: -1\n\n", FORMAT, "byte skip"},
        {HEADER "line skip: -1\n\n", FORMAT, "line skip"},
        {HEADER "slope:=steep\n\n", FORMAT, "slope"},
        {HEADER "slope:=0\n\n", FORMAT, "slope"},
        {HEADER "data file: \n\n", FORMAT, "empty"},
        {HEADER "data file: LIST\n", FORMAT, "lists no data files"},
        {HEADER "data file: LIST 4\nv.nrrd\n", FORMAT, "number of axes"},
        {HEADER "data file: %s%d 1 2\n\n", FORMAT, "series"},
        {HEADER "data file: %n 1 2\n\n", FORMAT, "series"},
        {HEADER "data file: %99d 1 2\n\n", FORMAT, "series"},
        {HEADER "data file: v%d 1 2 0\n\n", FORMAT, "series"},
        {HEADER "data file: v%d 1 9223372036854775807\n\n", FORMAT, "series"},
        {HEADER "data file: v%d 0 1000000000\n\n", FORMAT, "more than"},
        {HEADER "data file: .\n\n", BRICK_ERR_IO, "regular file"},
        {HEADER "data file: /dev/zero\n\n", BRICK_ERR_IO, "regular file"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        /* Headers that end have their voxels, so that these are not what is missing. */
        size_t n = strlen(table[i].header);
        bool ends = n > 2 && strcmp(table[i].header + n - 2, "\n\n") == 0;
        expect_failure(put_file("v.nrrd", table[i].header, voxels, ends ? sizeof voxels : 0), NULL,
                       table[i].code, table[i].says);
    }
    expect_failure(put_file("v.nrrd", HEADER "\n", voxels, 23), NULL, FORMAT, "truncated");
    expect_failure(put_file("v.nrrd", "NRRD0004\n", "ty\0pe: short\n\n", 14), NULL, FORMAT, "not text");

    /* A header without an end is not read for ever. */
    size_t n = (size_t)2 << 20;
    char *filler = malloc(n);
    assert_non_null(filler);
    memset(filler, 'x', n);
    expect_failure(put_file("v.nrrd", HEADER "content: ", filler, n), NULL, FORMAT, "does not end within");
    memset(filler, '\n', n);
    filler[0] = '#';
    filler[n / 2] = '#';
    expect_failure(put_file("v.nhdr", HEADER "data file: LIST\n", filler, n), NULL, FORMAT,
                   "does not end within");
    free(filler);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(attached_raw, empty_folder),
        cmocka_unit_test_teardown(types_by_all_names, empty_folder),
        cmocka_unit_test_teardown(gzip_is_streamed, empty_folder),
        cmocka_unit_test_teardown(detached, empty_folder),
        cmocka_unit_test_teardown(slices_in_files, empty_folder),
        cmocka_unit_test_teardown(world, empty_folder),
        cmocka_unit_test_teardown(kinds_tell_values_from_axes, empty_folder),
        cmocka_unit_test_teardown(slope_travels_as_keys, empty_folder),
        cmocka_unit_test_teardown(bad_headers, empty_folder),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
