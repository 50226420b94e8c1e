/* Why: NRRD with an attached header, raw, little endian. The affine's columns are the space directions as
 * they are, to 17 digits, so that reading gives the same doubles; slope and intercept travel as key/value
 * pairs. */
#include <stdio.h>
#include <stdlib.h>

#include "file_sink.h"
#include "volume_formats.h"

static const char *const type_names[BRICK_TYPE_COUNT] = {
    [BRICK_U8] = "uint8",  [BRICK_I8] = "int8",    [BRICK_U16] = "uint16", [BRICK_I16] = "int16",
    [BRICK_F32] = "float", [BRICK_U32] = "uint32", [BRICK_I32] = "int32",  [BRICK_F64] = "double",
};

/* NULL without memory. */
static char *make_header(enum brick_type type, const struct brick_geometry *g)
{
    char *text = NULL;
    size_t bytes;
    FILE *f = open_memstream(&text, &bytes);
    if (!f)
        return NULL;
    fprintf(f, "NRRD0004\ntype: %s\ndimension: 3\nspace: left-posterior-superior\n", type_names[type]);
    fprintf(f, "sizes: %llu %llu %llu\n", (unsigned long long)g->dims[0], (unsigned long long)g->dims[1],
            (unsigned long long)g->dims[2]);
    fprintf(f, "space directions:");
    for (int c = 0; c < 3; c++)
        fprintf(f, " (%.17g,%.17g,%.17g)", g->affine[0][c], g->affine[1][c], g->affine[2][c]);
    fprintf(f, "\nkinds: domain domain domain\nendian: little\nencoding: raw\n");
    fprintf(f, "space origin: (%.17g,%.17g,%.17g)\n", g->affine[0][3], g->affine[1][3], g->affine[2][3]);
    if (g->slope != 1.0 || g->intercept != 0.0)
        fprintf(f, "slope:=%.17g\nintercept:=%.17g\n", g->slope, g->intercept);
    fprintf(f, "\n");
    if (fclose(f)) {
        free(text);
        return NULL;
    }
    return text;
}

int fmt_nrrd_create(struct brick_sink **sink, const char *path, enum brick_type type,
                    const struct brick_geometry *geometry, struct brick_error *err)
{
    char *header = make_header(type, geometry);
    if (!header)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    const struct fmt_file_sink_params params = {
        .data_path = path, .header = header, .type = type, .dims = geometry->dims};
    int code = fmt_file_sink_create(sink, &params, err);
    free(header);
    return code;
}
