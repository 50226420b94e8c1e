/* Why: voxels without a header: all that is known comes from the caller, so the file's size is the only check
 * there is, and it is exact. */
#include "file_source.h"
#include "geometry.h"
#include "volume_formats.h"

int fmt_raw_open(struct brick_source **source, const char *path, const struct fmt_source_params *params,
                 struct brick_error *err)
{
    if (brick_type_bytes(params->type) == 0 || !(params->dims[0] || params->dims[1] || params->dims[2]))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: a raw file needs --size and --type", path);
    if (params->skip_bytes > INT64_MAX)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: cannot skip %llu bytes", path,
                          (unsigned long long)params->skip_bytes);
    char *name = (char *)path;
    const struct fmt_file_names names = {.path = &name, .count = 1};
    struct fmt_file_layout layout = {
        .format = "raw",
        .geometry = fmt_geometry_identity,
        .type = params->type,
        .big_endian = params->big_endian,
        .names = &names,
        .skip_bytes = (int64_t)params->skip_bytes,
        .exact = true,
    };
    for (int a = 0; a < 3; a++)
        layout.geometry.dims[a] = params->dims[a];
    return fmt_file_source_create(source, &layout, err);
}
