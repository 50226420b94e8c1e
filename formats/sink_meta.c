/* Why: MetaImage, uncompressed, little endian: .mha with its voxels behind the header, .mhd with a .raw
 * beside it. Row i of TransformMatrix is the unit direction of index axis i, and ElementSpacing its length.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "file_sink.h"
#include "geometry.h"
#include "volume_formats.h"

static const char *const type_names[BRICK_TYPE_COUNT] = {
    [BRICK_U8] = "MET_UCHAR",  [BRICK_I8] = "MET_CHAR",    [BRICK_U16] = "MET_USHORT",
    [BRICK_I16] = "MET_SHORT", [BRICK_F32] = "MET_FLOAT",  [BRICK_U32] = "MET_UINT",
    [BRICK_I32] = "MET_INT",   [BRICK_F64] = "MET_DOUBLE",
};

/* NULL without memory. */
static char *make_header(enum brick_type type, const struct brick_geometry *g, const char *data_file)
{
    char *text = NULL;
    size_t bytes;
    double spacing[3];
    fmt_geometry_spacing(g->affine, spacing);
    FILE *f = open_memstream(&text, &bytes);
    if (!f)
        return NULL;
    fprintf(f, "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n");
    fprintf(f, "CompressedData = False\nTransformMatrix =");
    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++)
            fprintf(f, " %.17g", g->affine[r][c] / spacing[c]);
    fprintf(f, "\nOffset = %.17g %.17g %.17g\n", g->affine[0][3], g->affine[1][3], g->affine[2][3]);
    fprintf(f, "ElementSpacing = %.17g %.17g %.17g\n", spacing[0], spacing[1], spacing[2]);
    fprintf(f, "DimSize = %llu %llu %llu\n", (unsigned long long)g->dims[0], (unsigned long long)g->dims[1],
            (unsigned long long)g->dims[2]);
    if (g->slope != 1.0 || g->intercept != 0.0)
        fprintf(f, "ElementToIntensityFunctionSlope = %.17g\nElementToIntensityFunctionOffset = %.17g\n",
                g->slope, g->intercept);
    fprintf(f, "ElementType = %s\nElementDataFile = %s\n", type_names[type], data_file);
    if (fclose(f)) {
        free(text);
        return NULL;
    }
    return text;
}

int fmt_meta_create(struct brick_sink **sink, const char *path, enum brick_type type,
                    const struct brick_geometry *geometry, struct brick_error *err)
{
    size_t stem = strlen(path) - strlen(".mhd");
    bool attached = strcasecmp(path + stem, ".mha") == 0;
    char *data_path = NULL, *header = NULL;
    int code = BRICK_OK;
    if (attached ? !(data_path = strdup(path)) : asprintf(&data_path, "%.*s.raw", (int)stem, path) < 0)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    const char *slash = strrchr(data_path, '/');
    header = make_header(type, geometry, attached ? "LOCAL" : slash ? slash + 1 : data_path);
    if (!header) {
        code = brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    } else if (!attached && access(data_path, F_OK) == 0 && access(path, F_OK) != 0) {
        /* A raw file that no header of ours goes with may be somebody's only copy. */
        code = brick_fail(err, BRICK_ERR_ARGUMENT, "%s: its voxels would replace %s, which is not part of it",
                          path, data_path);
    } else {
        const struct fmt_file_sink_params params = {
            .data_path = data_path,
            .header = attached ? header : NULL,
            .side_path = attached ? NULL : path,
            .side_header = header,
            .type = type,
            .dims = geometry->dims,
        };
        code = fmt_file_sink_create(sink, &params, err);
    }
    free(header);
    free(data_path);
    return code;
}
