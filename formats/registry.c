/* Why: the one place that knows which volume formats there are. A format is a row of the table; a file's
 * ending chooses it; the caller's overrides are applied here, after the file has spoken, and alike for all.
 */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include <brick/io.h>

#include "geometry.h"
#include "volume_formats.h"

#define MAX_ENDINGS 4

static const struct format {
    const char *name;
    const char *reads[MAX_ENDINGS + 1], *writes[MAX_ENDINGS + 1]; /* endings, NULL at the end */
    fmt_source_open_fn *open;
    fmt_sink_create_fn *create;
} formats[] = {
    {"raw", {".raw", ".img", ".dat", ".bin"}, {".raw"}, fmt_raw_open, fmt_raw_create},
    {"NRRD", {".nrrd", ".nhdr"}, {".nrrd"}, fmt_nrrd_open, fmt_nrrd_create},
    {"MetaImage", {".mhd", ".mha"}, {".mhd", ".mha"}, fmt_meta_open, fmt_meta_create},
};
#define FORMAT_COUNT (sizeof formats / sizeof *formats)

const struct fmt_source_params fmt_source_defaults = {
    .type = BRICK_TYPE_COUNT,
    .spacing_mm = {1, 1, 1},
    .affine = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
    .slope = 1.0,
};

static bool ends_with(const char *path, const char *const *endings)
{
    size_t n = strlen(path);
    for (; *endings; endings++) {
        size_t m = strlen(*endings);
        if (n > m && strcasecmp(path + n - m, *endings) == 0)
            return true;
    }
    return false;
}

/* "raw (.raw .img), NRRD (.nrrd)": what can be read, or written. */
static const char *list_formats(bool writes, char *text, size_t bytes)
{
    size_t at = 0;
    for (size_t i = 0; i < FORMAT_COUNT; i++) {
        const char *const *endings = writes ? formats[i].writes : formats[i].reads;
        at += (size_t)snprintf(text + at, bytes - at, "%s%s (", i ? ", " : "", formats[i].name);
        for (size_t e = 0; endings[e]; e++)
            at += (size_t)snprintf(text + at, bytes - at, "%s%s", e ? " " : "", endings[e]);
        at += (size_t)snprintf(text + at, bytes - at, ")");
    }
    return text;
}

int fmt_source_open(struct brick_source **source, const char *path, const struct fmt_source_params *params,
                    struct brick_error *err)
{
    struct brick_io io;
    int code = brick_io_open(&io, path, err); /* a missing file is said to be missing, whatever its ending */
    if (code)
        return code;
    brick_io_close(&io);

    bool raw_given =
        brick_type_bytes(params->type) && (params->dims[0] || params->dims[1] || params->dims[2]);
    size_t i = 0;
    while (i < FORMAT_COUNT && !ends_with(path, formats[i].reads))
        i++;
    if (i == FORMAT_COUNT && !raw_given) {
        char text[256];
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "%s: unknown ending; read are %s, and any file as raw with --size and --type", path,
                          list_formats(false, text, sizeof text));
    }
    fmt_source_open_fn *open = i == FORMAT_COUNT ? fmt_raw_open : formats[i].open;
    if (open != fmt_raw_open && (raw_given || params->big_endian || params->skip_bytes))
        return brick_fail(err, BRICK_ERR_ARGUMENT,
                          "%s: has a header: --size, --type, --endian and --skip are for raw files", path);

    struct brick_source *opened = NULL;
    code = open(&opened, path, params, err);
    if (!code)
        code = fmt_geometry_override(&opened->geometry, params, err);
    if (!code)
        code = fmt_geometry_check(&opened->geometry, path, err);
    if (code)
        brick_source_destroy(&opened);
    else
        *source = opened;
    return code;
}

int fmt_sink_create(struct brick_sink **sink, const char *path, enum brick_type type,
                    const struct brick_geometry *geometry, struct brick_error *err)
{
    for (size_t i = 0; i < FORMAT_COUNT; i++)
        if (ends_with(path, formats[i].writes))
            return formats[i].create(sink, path, type, geometry, err);
    char text[256];
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: unknown ending; written are %s", path,
                      list_formats(true, text, sizeof text));
}
