/* Why: the voxels and nothing else, little endian. Geometry, slope and intercept have no place in it. */
#include "file_sink.h"
#include "volume_formats.h"

int fmt_raw_create(struct brick_sink **sink, const char *path, enum brick_type type,
                   const struct brick_geometry *geometry, struct brick_error *err)
{
    const struct fmt_file_sink_params params = {.data_path = path, .type = type, .dims = geometry->dims};
    return fmt_file_sink_create(sink, &params, err);
}
