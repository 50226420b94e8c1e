/* The rows of the registry's table of volume formats. Private to formats/. */
#ifndef FORMATS_VOLUME_FORMATS_H
#define FORMATS_VOLUME_FORMATS_H

#include <formats/formats.h>

/* Open a volume as its file describes it; overrides of the geometry are the registry's. Only raw looks at
 * params. */
typedef int fmt_source_open_fn(struct brick_source **source, const char *path,
                               const struct fmt_source_params *params, struct brick_error *err);
typedef int fmt_sink_create_fn(struct brick_sink **sink, const char *path, enum brick_type type,
                               const struct brick_geometry *geometry, struct brick_error *err);

/* Headerless voxels. The file's size must be exactly that of params. */
fmt_source_open_fn fmt_raw_open;
fmt_sink_create_fn fmt_raw_create;

/* NRRD0001 to NRRD0005 (teem.sourceforge.net/nrrd/format.html): attached and detached headers, encodings raw
 * and gzip, one file, LIST or a numbered series. `centers`, `axis mins`, `thicknesses` and `measurement
 * frame` are not used: the space origin is the first sample's centre. Without a space, axes are taken as LPS.
 */
fmt_source_open_fn fmt_nrrd_open;
fmt_sink_create_fn fmt_nrrd_create;

/* MetaImage (.mhd, .mha). World is LPS, as ITK reads it; row i of TransformMatrix is the direction of index
 * axis i. ElementToIntensityFunctionSlope and -Offset are slope and intercept. */
fmt_source_open_fn fmt_meta_open;
fmt_sink_create_fn fmt_meta_create;

#endif
