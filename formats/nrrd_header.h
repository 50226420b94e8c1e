/* The fields of a NRRD header, and its axes. Private to source_nrrd.c and nrrd_axes.c. */
#ifndef FORMATS_NRRD_HEADER_H
#define FORMATS_NRRD_HEADER_H

#include <stdint.h>

#include <brick/error.h>
#include <brick/grid.h>

#define NRRD_MAX_AXES 16

enum nrrd_field {
    NRRD_TYPE,
    NRRD_DIMENSION,
    NRRD_SIZES,
    NRRD_ENCODING,
    NRRD_ENDIAN,
    NRRD_SPACINGS,
    NRRD_KINDS,
    NRRD_UNITS,
    NRRD_SPACE,
    NRRD_SPACE_DIMENSION,
    NRRD_SPACE_DIRECTIONS,
    NRRD_SPACE_ORIGIN,
    NRRD_SPACE_UNITS,
    NRRD_DATA_FILE,
    NRRD_LINE_SKIP,
    NRRD_BYTE_SKIP,
    NRRD_CONTENT,
    NRRD_SLOPE,     /* key:=value */
    NRRD_INTERCEPT, /* key:=value */
    NRRD_FIELD_COUNT
};

struct nrrd_header {
    const char *path;
    char *
        value[NRRD_FIELD_COUNT]; /* text of each field given, trimmed, inside the header's bytes; else NULL */
    unsigned axes;               /* dimension, 1..NRRD_MAX_AXES */
    uint64_t sizes[NRRD_MAX_AXES];
};

/* Tell axes of space from axes of values, and place the former in LPS mm: fills dims and affine. Cuts the
 * values. */
int nrrd_axes_place(struct nrrd_header *header, struct brick_geometry *geometry, struct brick_error *err);

#endif
