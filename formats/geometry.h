/* What headers and callers say about where voxels are, brought into one geometry. Private to formats/. */
#ifndef FORMATS_GEOMETRY_H
#define FORMATS_GEOMETRY_H

#include <stddef.h>
#include <stdint.h>

#include <brick/error.h>
#include <brick/grid.h>
#include <formats/formats.h>

/* 1 x 1 x 1 voxel of 1 mm at the origin, index axes along LPS, stored values physical. */
extern const struct brick_geometry fmt_geometry_identity;

/* Bytes of all voxels. BRICK_ERR_FORMAT for an empty or absurd size: afterwards every size within the volume,
 * in bytes, fits a file offset. */
int fmt_geometry_bytes(const uint64_t dims[3], enum brick_type type, const char *path, uint64_t *bytes,
                       struct brick_error *err);

/* affine from `axes` (1..3) directions, each the world step of one index axis. Axes that the file does not
 * have get unit steps perpendicular to those it has. */
void fmt_geometry_set_axes(struct brick_geometry *geometry, double directions[3][3], unsigned axes,
                           const double origin_mm[3]);

/* Let what the caller gave win. An affine stands alone; axes rebuild the affine along patient axes from the
 * spacing and origin given or known; spacing alone keeps the directions. */
int fmt_geometry_override(struct brick_geometry *geometry, const struct fmt_source_params *params,
                          struct brick_error *err);

/* Can a grid be made of it? BRICK_ERR_FORMAT with path and reason otherwise. */
int fmt_geometry_check(const struct brick_geometry *geometry, const char *path, struct brick_error *err);

/* Length of each index axis' step. */
void fmt_geometry_spacing(const double affine[3][4], double spacing_mm[3]);

#endif
