/* Why: NRRD headers: fields and key/value pairs as text first, each at most once, then interpreted in one
 * order, so that the order in the file does not matter. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "file_source.h"
#include "geometry.h"
#include "nrrd_header.h"
#include "text.h"
#include "volume_formats.h"

/* Both spellings of a name, and none for what is a key of key:=value. Names are case-insensitive, keys are
 * not. */
static const struct {
    const char *name, *other, *key;
} fields[NRRD_FIELD_COUNT] = {
    [NRRD_TYPE] = {"type", NULL, NULL},
    [NRRD_DIMENSION] = {"dimension", NULL, NULL},
    [NRRD_SIZES] = {"sizes", NULL, NULL},
    [NRRD_ENCODING] = {"encoding", NULL, NULL},
    [NRRD_ENDIAN] = {"endian", NULL, NULL},
    [NRRD_SPACINGS] = {"spacings", NULL, NULL},
    [NRRD_KINDS] = {"kinds", NULL, NULL},
    [NRRD_UNITS] = {"units", NULL, NULL},
    [NRRD_SPACE] = {"space", NULL, NULL},
    [NRRD_SPACE_DIMENSION] = {"space dimension", NULL, NULL},
    [NRRD_SPACE_DIRECTIONS] = {"space directions", NULL, NULL},
    [NRRD_SPACE_ORIGIN] = {"space origin", NULL, NULL},
    [NRRD_SPACE_UNITS] = {"space units", NULL, NULL},
    [NRRD_DATA_FILE] = {"data file", "datafile", NULL},
    [NRRD_LINE_SKIP] = {"line skip", "lineskip", NULL},
    [NRRD_BYTE_SKIP] = {"byte skip", "byteskip", NULL},
    [NRRD_CONTENT] = {"content", NULL, NULL},
    [NRRD_SLOPE] = {NULL, NULL, "slope"},
    [NRRD_INTERCEPT] = {NULL, NULL, "intercept"},
};

static const struct {
    const char *name;
    enum brick_type type; /* BRICK_TYPE_COUNT: a NRRD type that is not read */
} types[] = {
    {"signed char", BRICK_I8},
    {"int8", BRICK_I8},
    {"int8_t", BRICK_I8},
    {"uchar", BRICK_U8},
    {"unsigned char", BRICK_U8},
    {"uint8", BRICK_U8},
    {"uint8_t", BRICK_U8},
    {"short", BRICK_I16},
    {"short int", BRICK_I16},
    {"signed short", BRICK_I16},
    {"signed short int", BRICK_I16},
    {"int16", BRICK_I16},
    {"int16_t", BRICK_I16},
    {"ushort", BRICK_U16},
    {"unsigned short", BRICK_U16},
    {"unsigned short int", BRICK_U16},
    {"uint16", BRICK_U16},
    {"uint16_t", BRICK_U16},
    {"int", BRICK_I32},
    {"signed int", BRICK_I32},
    {"int32", BRICK_I32},
    {"int32_t", BRICK_I32},
    {"uint", BRICK_U32},
    {"unsigned int", BRICK_U32},
    {"uint32", BRICK_U32},
    {"uint32_t", BRICK_U32},
    {"float", BRICK_F32},
    {"double", BRICK_F64},
    {"longlong", BRICK_TYPE_COUNT},
    {"long long", BRICK_TYPE_COUNT},
    {"long long int", BRICK_TYPE_COUNT},
    {"signed long long", BRICK_TYPE_COUNT},
    {"signed long long int", BRICK_TYPE_COUNT},
    {"int64", BRICK_TYPE_COUNT},
    {"int64_t", BRICK_TYPE_COUNT},
    {"ulonglong", BRICK_TYPE_COUNT},
    {"unsigned long long", BRICK_TYPE_COUNT},
    {"unsigned long long int", BRICK_TYPE_COUNT},
    {"uint64", BRICK_TYPE_COUNT},
    {"uint64_t", BRICK_TYPE_COUNT},
    {"block", BRICK_TYPE_COUNT},
};

static const struct {
    const char *name;
    bool read;
    enum fmt_encoding encoding;
} encodings[] = {
    {"raw", true, FMT_ENCODING_RAW},  {"gzip", true, FMT_ENCODING_GZIP}, {"gz", true, FMT_ENCODING_GZIP},
    {"txt", false, FMT_ENCODING_RAW}, {"text", false, FMT_ENCODING_RAW}, {"ascii", false, FMT_ENCODING_RAW},
    {"hex", false, FMT_ENCODING_RAW}, {"bz2", false, FMT_ENCODING_RAW},  {"bzip2", false, FMT_ENCODING_RAW},
    {"zrl", false, FMT_ENCODING_RAW},
};

static int bad(const struct nrrd_header *header, enum nrrd_field field, struct brick_error *err)
{
    const char *name = fields[field].name ? fields[field].name : fields[field].key;
    if (!header->value[field])
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: the NRRD header has no field '%s'", header->path, name);
    return brick_fail(err, BRICK_ERR_FORMAT, "%s: cannot read the NRRD field '%s: %.80s'", header->path, name,
                      header->value[field]);
}

/* Sort one line of the header into value[]. Unknown fields and keys are passed over. */
static int sort_line(struct nrrd_header *header, const struct fmt_text *text, char *line,
                     struct brick_error *err)
{
    if (*line == '#')
        return BRICK_OK;
    char *colon = strchr(line, ':');
    if (!colon || colon == line)
        return brick_fail(err, BRICK_ERR_FORMAT,
                          "%s: line %u of the NRRD header is neither a field nor a comment", header->path,
                          text->line);
    bool is_key = colon[1] == '=';
    *colon = 0;
    const char *name = is_key ? line : fmt_text_trim(line);
    for (int f = 0; f < NRRD_FIELD_COUNT; f++) {
        if (is_key ? !fields[f].key || strcmp(name, fields[f].key) != 0
                   : (!fields[f].name || strcasecmp(name, fields[f].name) != 0) &&
                         (!fields[f].other || strcasecmp(name, fields[f].other) != 0))
            continue;
        if (header->value[f])
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: the NRRD header says '%s' twice (line %u)",
                              header->path, name, text->line);
        header->value[f] = fmt_text_trim(colon + (is_key ? 2 : 1));
        break;
    }
    return BRICK_OK;
}

/* Read up to the blank line, or, when the data are elsewhere, at most to the end; `data file: LIST` ends a
 * header, and the lines that follow are names. */
static int read_fields(struct nrrd_header *header, struct fmt_text *text, struct fmt_file_names *names,
                       struct brick_error *err)
{
    char *line;
    int got = fmt_text_line(text, &line, err);
    if (got < 0)
        return got;
    if (got == 0 || strncmp(line, "NRRD000", 7) != 0 || line[7] < '1' || line[7] > '5' || line[8])
        return brick_fail_at(err, BRICK_ERR_FORMAT, 0, BRICK_NO_BRICK,
                             "%s: not a NRRD file: does not begin with NRRD0001 to NRRD0005", header->path);
    bool list = false;
    while (!list && (got = fmt_text_line(text, &line, err)) > 0 && *line) {
        int code = sort_line(header, text, line, err);
        if (code)
            return code;
        const char *file = header->value[NRRD_DATA_FILE];
        list = file && strncmp(file, "LIST", 4) == 0 && (file[4] == 0 || file[4] == ' ' || file[4] == '\t');
    }
    if (got == 0 && !header->value[NRRD_DATA_FILE])
        return brick_fail_at(err, BRICK_ERR_FORMAT, text->at, BRICK_NO_BRICK,
                             "%s: truncated: the NRRD header ends without a blank line and voxels",
                             header->path);
    while (list && (got = fmt_text_line(text, &line, err)) > 0) {
        line = fmt_text_trim(line);
        int code = *line ? fmt_file_names_add(names, header->path, line, err) : BRICK_OK;
        if (code)
            return code;
    }
    return got < 0 ? got : BRICK_OK;
}

/* Find the data files, and hold their number against the array's axes: a file holds the first `subdim` of
 * them, or a slab of the last one. */
static int find_files(struct nrrd_header *header, struct fmt_file_names *names, struct brick_error *err)
{
    char *file = header->value[NRRD_DATA_FILE];
    const char *rest = "";
    bool list =
        names->count > 0 || (file && strncmp(file, "LIST", 4) == 0 && (!file[4] || strchr(" \t", file[4])));
    if (!file)
        return fmt_file_names_add(names, "", header->path, err);
    if (list) {
        rest = fmt_text_trim(file + 4);
        if (names->count == 0)
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: lists no data files after 'data file: LIST'",
                              header->path);
    } else if (strchr(file, '%') && strpbrk(file, " \t")) {
        int code = fmt_file_names_add_series(names, header->path, file, &rest, err);
        if (code)
            return code;
    } else {
        return fmt_file_names_add(names, header->path, file, err);
    }

    uint64_t subdim = header->axes > 1 ? header->axes - 1 : 1, expected = 1;
    if (*rest && (!fmt_parse_u64(rest, &subdim) || subdim < 1 || subdim > header->axes))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: '%.80s' is not the number of axes in each data file",
                          header->path, rest);
    if (subdim == header->axes)
        return header->sizes[subdim - 1] % names->count == 0
                   ? BRICK_OK
                   : brick_fail(err, BRICK_ERR_FORMAT, "%s: %zu data files cannot share %llu slices equally",
                                header->path, names->count, (unsigned long long)header->sizes[subdim - 1]);
    for (uint64_t a = subdim; a < header->axes; a++)
        if (__builtin_mul_overflow(expected, header->sizes[a], &expected))
            expected = UINT64_MAX;
    if (expected != names->count)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: names %zu data files, its sizes need %llu",
                          header->path, names->count, (unsigned long long)expected);
    return BRICK_OK;
}

/* Fields that say how voxels are stored. */
static int read_storage(struct nrrd_header *header, struct fmt_file_layout *layout, struct brick_error *err)
{
    char *const *value = header->value;
    uint64_t n;
    if (!value[NRRD_DIMENSION] || !fmt_parse_u64(value[NRRD_DIMENSION], &n) || n < 1 || n > NRRD_MAX_AXES)
        return bad(header, NRRD_DIMENSION, err);
    header->axes = (unsigned)n;
    if (!value[NRRD_SIZES] || !fmt_parse_u64s(value[NRRD_SIZES], header->sizes, header->axes))
        return bad(header, NRRD_SIZES, err);

    size_t i = 0;
    while (value[NRRD_TYPE] && i < sizeof types / sizeof *types &&
           strcasecmp(value[NRRD_TYPE], types[i].name) != 0)
        i++;
    if (!value[NRRD_TYPE] || i == sizeof types / sizeof *types)
        return bad(header, NRRD_TYPE, err);
    layout->type = types[i].type;
    if (layout->type == BRICK_TYPE_COUNT)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: voxels of NRRD type '%s' are not read",
                          header->path, types[i].name);

    for (i = 0; value[NRRD_ENCODING] && i < sizeof encodings / sizeof *encodings; i++)
        if (strcasecmp(value[NRRD_ENCODING], encodings[i].name) == 0)
            break;
    if (!value[NRRD_ENCODING] || i == sizeof encodings / sizeof *encodings)
        return bad(header, NRRD_ENCODING, err);
    if (!encodings[i].read)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "%s: NRRD encoding '%s' is not read: write it as raw or gzip", header->path,
                          encodings[i].name);
    layout->encoding = encodings[i].encoding;

    if (value[NRRD_ENDIAN]) {
        layout->big_endian = strcasecmp(value[NRRD_ENDIAN], "big") == 0;
        if (!layout->big_endian && strcasecmp(value[NRRD_ENDIAN], "little") != 0)
            return bad(header, NRRD_ENDIAN, err);
    } else if (brick_type_bytes(layout->type) > 1) {
        return bad(header, NRRD_ENDIAN, err);
    }
    if (value[NRRD_LINE_SKIP] && !fmt_parse_u64(value[NRRD_LINE_SKIP], &layout->skip_lines))
        return bad(header, NRRD_LINE_SKIP, err);
    if (value[NRRD_BYTE_SKIP] &&
        (!fmt_parse_i64(value[NRRD_BYTE_SKIP], &layout->skip_bytes) ||
         layout->skip_bytes < FMT_SKIP_TO_TAIL ||
         (layout->skip_bytes == FMT_SKIP_TO_TAIL && layout->encoding != FMT_ENCODING_RAW)))
        return bad(header, NRRD_BYTE_SKIP, err);
    if (value[NRRD_SLOPE] && !fmt_parse_f64(value[NRRD_SLOPE], &layout->geometry.slope))
        return bad(header, NRRD_SLOPE, err);
    if (value[NRRD_INTERCEPT] && !fmt_parse_f64(value[NRRD_INTERCEPT], &layout->geometry.intercept))
        return bad(header, NRRD_INTERCEPT, err);
    return BRICK_OK;
}

/* Lines for provenance of what the header says about itself. NULL without memory. */
static char *describe(const struct nrrd_header *header)
{
    const char *content = header->value[NRRD_CONTENT], *space = header->value[NRRD_SPACE];
    char *c = fmt_text_printable(content ? content : ""), *s = fmt_text_printable(space ? space : ""),
         *notes = NULL;
    if (c && s &&
        asprintf(&notes, "%s%s%s%s%s%s", *s ? "space: " : "", s, *s ? "\n" : "", *c ? "content: " : "", c,
                 *c ? "\n" : "") < 0)
        notes = NULL;
    free(c);
    free(s);
    return notes;
}

int fmt_nrrd_open(struct brick_source **source, const char *path, const struct fmt_source_params *params,
                  struct brick_error *err)
{
    (void)params;
    struct nrrd_header header = {.path = path};
    struct fmt_file_names names = {0};
    struct fmt_file_layout layout = {.format = "nrrd", .geometry = fmt_geometry_identity, .names = &names};
    struct fmt_text text = {0};
    struct brick_io io = BRICK_IO_CLOSED;
    char *notes = NULL;
    int code = brick_io_open(&io, path, err);
    if (!code)
        code = fmt_text_load(&text, &io, err);
    if (!code)
        code = read_fields(&header, &text, &names, err);
    if (!code)
        code = read_storage(&header, &layout, err);
    if (!code)
        code = find_files(&header, &names, err);
    if (!code && !(notes = describe(&header)))
        code = brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    if (!code)
        code = nrrd_axes_place(&header, &layout.geometry, err);
    if (!code) {
        layout.notes = notes;
        layout.offset = header.value[NRRD_DATA_FILE] ? 0 : text.at;
        code = fmt_file_source_create(source, &layout, err);
    }
    free(notes);
    fmt_file_names_finish(&names);
    fmt_text_finish(&text);
    brick_io_close(&io);
    return code;
}
