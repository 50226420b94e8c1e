/* Foreign files: volumes in and out, pictures in and out, transfer functions in. Each format is one row of
 * the registry; a file's ending chooses it. */
#ifndef FORMATS_FORMATS_H
#define FORMATS_FORMATS_H

#include <stdbool.h>

#include <brick/error.h>
#include <brick/image.h>
#include <brick/mesh.h>
#include <brick/source.h>
#include <brick/transfer.h>

/* How to read a raw file, and what to override in one that has a header. Start from fmt_source_defaults. */
struct fmt_source_params {
    uint64_t dims[3];     /* raw: required */
    enum brick_type type; /* raw: required; BRICK_TYPE_COUNT: not given */
    bool big_endian;      /* raw */
    uint64_t skip_bytes;  /* raw: bytes before the first voxel */
    bool has_spacing, has_origin, has_affine, has_slope, has_intercept;
    double spacing_mm[3], origin_mm[3];
    char axes[4];        /* "" : not given */
    double affine[3][4]; /* index -> mm, LPS */
    double slope, intercept;
};
extern const struct fmt_source_params fmt_source_defaults;

/* Open any readable volume by its ending. Given overrides (spacing, origin, axes, affine, slope, intercept)
 * win over the file's. An unknown ending with dims and type given is read as raw; else BRICK_ERR_UNSUPPORTED
 * listing what can be read. Sizes are checked against the files' before memory is taken. */
int fmt_source_open(struct brick_source **source, const char *path, const struct fmt_source_params *params,
                    struct brick_error *err);

/* Synthetic fields: "marschner-lobb", "ct", "ramp", "checker", "constant", "shells". Any size; the same bytes
 * for every thread count. type: any stored type. spacing 1 mm, LPS, first voxel at 0. Scales: marschner-lobb
 * and shells from 0 to the type's largest value (f32: 1); ramp over the type's range (f32: x + y + z);
 * checker's voxels alternate between 0 and 200 (u8), 100 (i8), 50000 (u16), 20000 (i16), 1 (f32); ct in HU by
 * slope and intercept. */
struct fmt_synth_params {
    uint64_t dims[3];
    enum brick_type type;
    uint64_t seed;
    double value; /* constant: the stored value */
    unsigned threads;
};
int fmt_synth_open(struct brick_source **source, const char *name, const struct fmt_synth_params *params,
                   struct brick_error *err);
/* The names, NULL at the end. */
extern const char *const fmt_synth_names[];

/* Create DST by its ending (.raw, .nrrd, .mhd, .mha). The data of .mhd goes to a .raw beside it
 * (BRICK_ERR_ARGUMENT when that exists without the .mhd). Written under a temporary name and renamed by
 * finish. */
int fmt_sink_create(struct brick_sink **sink, const char *path, enum brick_type type,
                    const struct brick_geometry *geometry, struct brick_error *err);

/* Pictures. EXR: scanlines, ZIP, float A B G R, linear premultiplied; exact. PNG: over `background` (linear
 * RGB), sRGB encoded, 8 bits; by ending. Written under a temporary name and renamed. */
struct fmt_image_params {
    double background[3];
};
extern const struct fmt_image_params fmt_image_defaults; /* black */
int fmt_image_write(const char *path, const struct brick_image *image, const struct fmt_image_params *params,
                    struct brick_error *err);
/* EXR with float or half R G B (A) channels. image is initialised here; finish it. */
int fmt_image_read(struct brick_image *image, const char *path, struct brick_error *err);
/* Can a picture be written under that name? Checked before a long render. */
int fmt_image_check_path(const char *path, struct brick_error *err);

/* 8-bit samples as they are shown (sRGB), row 0 on top, no padding. */
struct fmt_samples {
    uint32_t width, height; /* 1..BRICK_IMAGE_MAX_DIM */
    uint32_t channels;      /* 1 gray, 3 RGB, 4 RGB and opacity (not premultiplied) */
    const uint8_t *data;
};
/* A PNG in memory, to free(). Equal samples give equal bytes. BRICK_ERR_UNSUPPORTED in a build without
 * libpng.
 */
int fmt_png_encode(const struct fmt_samples *samples, void **png, size_t *bytes, struct brick_error *err);

/* An opaque mesh, by ending: PLY (ascii or binary of either byte order) and OBJ; patient axes LPS, in mm, as
 * the file has them. Polygons come as triangles. Of PLY normals and colours (sRGB) are read too, of OBJ
 * normals. BRICK_ERR_FORMAT for what is damaged, cut off, not finite or without a triangle;
 * BRICK_ERR_UNSUPPORTED for another ending, and in a build without tinyobjloader for OBJ. mesh is initialised
 * here; finish it. */
int fmt_mesh_read(struct brick_mesh *mesh, const char *path, struct brick_error *err);

/* A transfer function from JSON: this project's, or ParaView's colour map (RGBPoints, Points, ColorSpace RGB,
 * HSV, Lab, Diverging, Step), whose values are taken as physical and whose opacity as of one voxel edge (it
 * states no unit). Files up to 16 MiB. BRICK_ERR_FORMAT names the key or the point. Finish with
 * brick_transfer_spec_finish. */
int fmt_transfer_read(struct brick_transfer_spec *spec, const char *path, struct brick_error *err);

#endif
