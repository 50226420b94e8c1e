/* Voxels written to a file behind a header, or beside it: what every format's sink comes down to. Private to
 * formats/.
 */
#ifndef FORMATS_FILE_SINK_H
#define FORMATS_FILE_SINK_H

#include <stddef.h>

#include <brick/source.h>

struct fmt_file_sink_params {
    const char *data_path;   /* voxels, x fastest, little endian */
    const char *header;      /* text before the voxels; may be NULL */
    const char *side_path;   /* a second file, or NULL: named only after the data file is complete */
    const char *side_header; /* its text */
    enum brick_type type;
    const uint64_t *dims;
};

/* Both files are written as PATH.part and renamed by finish; destroyed unfinished, the sink removes them.
 * Strings are copied or written at once. */
int fmt_file_sink_create(struct brick_sink **sink, const struct fmt_file_sink_params *params,
                         struct brick_error *err);

#endif
