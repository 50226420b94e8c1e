/* Voxels in one file or spread over several of the same shape, raw or compressed: what a header comes down
 * to. Private to formats/. */
#ifndef FORMATS_FILE_SOURCE_H
#define FORMATS_FILE_SOURCE_H

#include <stdbool.h>
#include <stdint.h>

#include <brick/source.h>

#include "file_names.h"

enum fmt_encoding { FMT_ENCODING_RAW, FMT_ENCODING_GZIP, FMT_ENCODING_ZLIB };

#define FMT_SKIP_TO_TAIL (-1) /* the voxels are the last bytes of the file */

struct fmt_file_layout {
    const char *format; /* for provenance */
    const char *notes;  /* further provenance, whole lines; may be NULL */
    struct brick_geometry geometry;
    enum brick_type type;
    bool big_endian;
    enum fmt_encoding encoding;
    const struct fmt_file_names *names; /* slabs of equal size, z ascending; only read */
    uint64_t offset;                    /* bytes before anything else, as stored */
    uint64_t skip_lines;                /* then lines, as stored */
    int64_t skip_bytes;                 /* then bytes, in the decoded stream, or FMT_SKIP_TO_TAIL */
    uint64_t stored_bytes;              /* of a compressed stream; 0: all that is there */
    bool exact;                         /* the file must end with the last voxel */
};

/* Opens every file once to hold its size against the layout before any memory is taken for voxels. Reading
 * keeps one file open; slices of compressed files come in ascending order only. */
int fmt_file_source_create(struct brick_source **source, const struct fmt_file_layout *layout,
                           struct brick_error *err);

#endif
