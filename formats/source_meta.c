/* Why: MetaImage headers (.mhd, .mha): "Key = value" lines of which ElementDataFile is the last.
 *
 * World is LPS: MetaIO keeps TransformMatrix as written and ITK's MetaImageIO takes elements [i * n, i * n +
 * n) of it as the direction of index axis i, so that voxel (i,j,k) lies at Offset + sum of index * spacing *
 * row. Of synonymous keys MetaIO lets the later of Orientation, Rotation, TransformMatrix and of Position,
 * Offset, Origin win. */
#include <math.h>
#include <string.h>
#include <strings.h>

#include "file_source.h"
#include "geometry.h"
#include "text.h"
#include "volume_formats.h"

enum meta_key {
    META_OBJECT_TYPE,
    META_DIMENSION,
    META_SIZES,
    META_TYPE,
    META_CHANNELS,
    META_BINARY,
    META_MSB,         /* BinaryDataByteOrderMSB */
    META_ELEMENT_MSB, /* ElementByteOrderMSB: wins */
    META_COMPRESSED,
    META_COMPRESSED_BYTES,
    META_HEADER_BYTES,
    META_SPACING,
    META_ELEMENT_SIZE, /* when there is no spacing */
    META_ORIENTATION,
    META_ROTATION,
    META_TRANSFORM,
    META_POSITION,
    META_OFFSET,
    META_ORIGIN,
    META_UNITS,
    META_SLOPE,
    META_INTERCEPT,
    META_DATA_FILE,
    META_KEY_COUNT
};

static const char *const keys[META_KEY_COUNT] = {
    [META_OBJECT_TYPE] = "ObjectType",
    [META_DIMENSION] = "NDims",
    [META_SIZES] = "DimSize",
    [META_TYPE] = "ElementType",
    [META_CHANNELS] = "ElementNumberOfChannels",
    [META_BINARY] = "BinaryData",
    [META_MSB] = "BinaryDataByteOrderMSB",
    [META_ELEMENT_MSB] = "ElementByteOrderMSB",
    [META_COMPRESSED] = "CompressedData",
    [META_COMPRESSED_BYTES] = "CompressedDataSize",
    [META_HEADER_BYTES] = "HeaderSize",
    [META_SPACING] = "ElementSpacing",
    [META_ELEMENT_SIZE] = "ElementSize",
    [META_ORIENTATION] = "Orientation",
    [META_ROTATION] = "Rotation",
    [META_TRANSFORM] = "TransformMatrix",
    [META_POSITION] = "Position",
    [META_OFFSET] = "Offset",
    [META_ORIGIN] = "Origin",
    [META_UNITS] = "DistanceUnits",
    [META_SLOPE] = "ElementToIntensityFunctionSlope",
    [META_INTERCEPT] = "ElementToIntensityFunctionOffset",
    [META_DATA_FILE] = "ElementDataFile",
};

/* MET_LONG has four bytes in MetaIO, on every machine. */
static const struct {
    const char *name;
    enum brick_type type; /* BRICK_TYPE_COUNT: not read */
} types[] = {
    {"MET_CHAR", BRICK_I8},          {"MET_ASCII_CHAR", BRICK_I8},
    {"MET_UCHAR", BRICK_U8},         {"MET_SHORT", BRICK_I16},
    {"MET_USHORT", BRICK_U16},       {"MET_INT", BRICK_I32},
    {"MET_UINT", BRICK_U32},         {"MET_LONG", BRICK_I32},
    {"MET_ULONG", BRICK_U32},        {"MET_FLOAT", BRICK_F32},
    {"MET_DOUBLE", BRICK_F64},       {"MET_LONG_LONG", BRICK_TYPE_COUNT},
    {"MET_OTHER", BRICK_TYPE_COUNT}, {"MET_ULONG_LONG", BRICK_TYPE_COUNT},
};

struct meta_header {
    const char *path;
    char *value[META_KEY_COUNT]; /* text of each key given, trimmed, inside the header's bytes; else NULL */
    unsigned axes;               /* 2 or 3 */
};

static int bad(const struct meta_header *header, enum meta_key key, struct brick_error *err)
{
    if (!header->value[key])
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: the MetaImage header has no '%s'", header->path,
                          keys[key]);
    return brick_fail(err, BRICK_ERR_FORMAT, "%s: cannot read '%s = %.80s' in the MetaImage header",
                      header->path, keys[key], header->value[key]);
}

static int read_keys(struct meta_header *header, struct fmt_text *text, struct brick_error *err)
{
    char *line;
    int got = 1;
    while (!header->value[META_DATA_FILE] && (got = fmt_text_line(text, &line, err)) > 0) {
        line = fmt_text_trim(line);
        if (!*line)
            continue;
        char *value = strpbrk(line, "=:");
        if (!value || value == line)
            return brick_fail(err, BRICK_ERR_FORMAT,
                              "%s: line %u is not a 'Key = value' of a MetaImage header", header->path,
                              text->line);
        *value++ = 0;
        const char *name = fmt_text_trim(line);
        for (int k = 0; k < META_KEY_COUNT; k++) {
            if (strcmp(name, keys[k]) != 0)
                continue;
            if (header->value[k])
                return brick_fail(err, BRICK_ERR_FORMAT, "%s: the MetaImage header says '%s' twice (line %u)",
                                  header->path, name, text->line);
            header->value[k] = fmt_text_trim(value);
        }
    }
    return got < 0 ? got : header->value[META_DATA_FILE] ? BRICK_OK : bad(header, META_DATA_FILE, err);
}

static int read_flag(const struct meta_header *header, enum meta_key key, bool *flag, struct brick_error *err)
{
    const char *value = header->value[key];
    if (!value)
        return BRICK_OK;
    *flag = strcasecmp(value, "True") == 0 || strcmp(value, "1") == 0;
    if (!*flag && strcasecmp(value, "False") != 0 && strcmp(value, "0") != 0)
        return bad(header, key, err);
    return BRICK_OK;
}

/* Keys that say how voxels are stored. */
static int read_storage(struct meta_header *header, struct fmt_file_layout *layout, struct brick_error *err)
{
    char *const *value = header->value;
    uint64_t n;
    int code;
    if (value[META_OBJECT_TYPE] && strcmp(value[META_OBJECT_TYPE], "Image") != 0)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: MetaIO object '%.80s' is not an Image",
                          header->path, value[META_OBJECT_TYPE]);
    if (!value[META_DIMENSION] || !fmt_parse_u64(value[META_DIMENSION], &n) || n < 1)
        return bad(header, META_DIMENSION, err);
    if (n != 2 && n != 3)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "%s: a MetaImage of %llu dimensions is not read, only 2 or 3", header->path,
                          (unsigned long long)n);
    header->axes = (unsigned)n;
    if (!value[META_SIZES] || !fmt_parse_u64s(value[META_SIZES], layout->geometry.dims, header->axes))
        return bad(header, META_SIZES, err);

    size_t i = 0;
    while (value[META_TYPE] && i < sizeof types / sizeof *types &&
           strcmp(value[META_TYPE], types[i].name) != 0)
        i++;
    if (!value[META_TYPE] || i == sizeof types / sizeof *types)
        return bad(header, META_TYPE, err);
    layout->type = types[i].type;
    if (layout->type == BRICK_TYPE_COUNT)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: voxels of %s are not read", header->path,
                          types[i].name);
    if (value[META_CHANNELS] && !fmt_parse_u64(value[META_CHANNELS], &n))
        return bad(header, META_CHANNELS, err);
    if (value[META_CHANNELS] && n != 1)
        return brick_fail(
            err, BRICK_ERR_UNSUPPORTED,
            "%s: %llu channels a voxel: only one value a voxel can be read, split them into files first",
            header->path, (unsigned long long)n);

    bool binary = true, compressed = false;
    if ((code = read_flag(header, META_BINARY, &binary, err)) ||
        (code = read_flag(header, META_MSB, &layout->big_endian, err)) ||
        (code = read_flag(header, META_ELEMENT_MSB, &layout->big_endian, err)) ||
        (code = read_flag(header, META_COMPRESSED, &compressed, err)))
        return code;
    if (!binary)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: voxels as text (BinaryData = False) are not read",
                          header->path);
    layout->encoding = compressed ? FMT_ENCODING_ZLIB : FMT_ENCODING_RAW;
    if (compressed && value[META_COMPRESSED_BYTES] &&
        !fmt_parse_u64(value[META_COMPRESSED_BYTES], &layout->stored_bytes))
        return bad(header, META_COMPRESSED_BYTES, err);
    return BRICK_OK;
}

static int read_vector(const struct meta_header *header, enum meta_key key, double *v, size_t n,
                       struct brick_error *err)
{
    if (!header->value[key])
        return BRICK_OK;
    bool good = fmt_parse_f64s(header->value[key], v, n);
    for (size_t i = 0; good && i < n; i++)
        good = isfinite(v[i]);
    return good ? BRICK_OK : bad(header, key, err);
}

static int read_geometry(struct meta_header *header, struct brick_geometry *geometry, struct brick_error *err)
{
    unsigned n = header->axes;
    const char *unit = header->value[META_UNITS];
    double spacing[3] = {1, 1, 1}, offset[3] = {0}, directions[3][3] = {{0}}, matrix[9] = {0};
    double mm = !unit ? 1.0 : strcmp(unit, "um") == 0 ? 1e-3 : strcmp(unit, "cm") == 0 ? 10.0 : 1.0;
    for (unsigned a = 0; a < n; a++)
        matrix[a * n + a] = 1.0;
    int code;
    if ((code = read_vector(header, header->value[META_SPACING] ? META_SPACING : META_ELEMENT_SIZE, spacing,
                            n, err)) ||
        (code = read_vector(header, META_ORIENTATION, matrix, (size_t)n * n, err)) ||
        (code = read_vector(header, META_ROTATION, matrix, (size_t)n * n, err)) ||
        (code = read_vector(header, META_TRANSFORM, matrix, (size_t)n * n, err)) ||
        (code = read_vector(header, META_POSITION, offset, n, err)) ||
        (code = read_vector(header, META_OFFSET, offset, n, err)) ||
        (code = read_vector(header, META_ORIGIN, offset, n, err)) ||
        (code = read_vector(header, META_SLOPE, &geometry->slope, 1, err)) ||
        (code = read_vector(header, META_INTERCEPT, &geometry->intercept, 1, err)))
        return code;
    for (unsigned a = 0; a < n; a++)
        for (unsigned r = 0; r < n; r++)
            directions[a][r] = matrix[a * n + r] * spacing[a] * mm;
    for (unsigned r = 0; r < n; r++)
        offset[r] *= mm;
    fmt_geometry_set_axes(geometry, directions, n, offset);
    return BRICK_OK;
}

/* Where the voxels are, and what precedes them. A HeaderSize counts from the file's start, also in the
 * header's own. */
static int find_files(struct meta_header *header, struct fmt_text *text, struct fmt_file_layout *layout,
                      struct fmt_file_names *names, struct brick_error *err)
{
    char *file = header->value[META_DATA_FILE];
    int64_t header_bytes = 0;
    if (header->value[META_HEADER_BYTES] &&
        (!fmt_parse_i64(header->value[META_HEADER_BYTES], &header_bytes) || header_bytes < FMT_SKIP_TO_TAIL))
        return bad(header, META_HEADER_BYTES, err);
    if (header_bytes == FMT_SKIP_TO_TAIL)
        layout->skip_bytes = FMT_SKIP_TO_TAIL;
    else
        layout->offset = (uint64_t)header_bytes;

    if (strcasecmp(file, "LOCAL") == 0) {
        if (header_bytes == 0)
            layout->offset = text->at;
        return fmt_file_names_add(names, "", header->path, err);
    }
    bool list = strncmp(file, "LIST", 4) == 0 && (!file[4] || strchr(" \t", file[4]));
    bool series = !list && strchr(file, '%') && strpbrk(file, " \t");
    if (!list && !series)
        return fmt_file_names_add(names, header->path, file, err);

    /* Files of one dimension less than the image, unless a list says otherwise. */
    uint64_t file_axes = header->axes - 1, expected = 1;
    const char *rest = "";
    int code = BRICK_OK;
    if (list) {
        rest = fmt_text_trim(file + 4);
        if (*rest && (!fmt_parse_u64(rest, &file_axes) || file_axes < 1 || file_axes > header->axes))
            return bad(header, META_DATA_FILE, err);
    }
    for (uint64_t a = file_axes; a < header->axes; a++)
        if (__builtin_mul_overflow(expected, layout->geometry.dims[a], &expected))
            expected = UINT64_MAX;
    if (series)
        code = fmt_file_names_add_series(names, header->path, file, &rest, err);
    char *line;
    int got = 1;
    while (!code && list && names->count < expected && (got = fmt_text_line(text, &line, err)) > 0) {
        line = fmt_text_trim(line);
        if (*line)
            code = fmt_file_names_add(names, header->path, line, err);
    }
    if (code || got < 0)
        return code ? code : got;
    if (*rest && series)
        return bad(header, META_DATA_FILE, err);
    if (names->count != expected || names->count == 0)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: names %zu data files, its DimSize needs %llu",
                          header->path, names->count, (unsigned long long)expected);
    return BRICK_OK;
}

int fmt_meta_open(struct brick_source **source, const char *path, const struct fmt_source_params *params,
                  struct brick_error *err)
{
    (void)params;
    struct meta_header header = {.path = path};
    struct fmt_file_names names = {0};
    struct fmt_file_layout layout = {
        .format = "metaimage", .geometry = fmt_geometry_identity, .names = &names};
    struct fmt_text text = {0};
    struct brick_io io = BRICK_IO_CLOSED;
    int code = brick_io_open(&io, path, err);
    if (!code)
        code = fmt_text_load(&text, &io, err);
    if (!code)
        code = read_keys(&header, &text, err);
    if (!code)
        code = read_storage(&header, &layout, err);
    if (!code)
        code = read_geometry(&header, &layout.geometry, err);
    if (!code)
        code = find_files(&header, &text, &layout, &names, err);
    if (!code)
        code = fmt_file_source_create(source, &layout, err);
    fmt_file_names_finish(&names);
    fmt_text_finish(&text);
    brick_io_close(&io);
    return code;
}
