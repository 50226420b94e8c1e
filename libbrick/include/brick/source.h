/* A volume being read, slice by slice. formats/ and the synthetic fields implement this; build/ consumes it.
 */
#ifndef BRICK_SOURCE_H
#define BRICK_SOURCE_H

#include <stdint.h>

#include <brick/error.h>
#include <brick/grid.h>
#include <brick/type.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The first member of every source. Filled by the source's open function; constant afterwards. */
struct brick_source {
    struct brick_geometry geometry;
    enum brick_type type;   /* as in the file, in host byte order once read */
    const char *provenance; /* owned by the source: one "key: value" a line, UTF-8, no paths, no times */
    uint64_t input_bytes;   /* bytes this source will read from disk, for progress; 0 if unknown */
    uint64_t held_slices;   /* slices of the box last asked for that the source itself holds in memory */
    /* Owned by the source: one line that differs when the voxels may: sizes and times of change of files, how
     * they are read, seeds. Not what geometry, type and provenance say. NULL: unknown. */
    const char *state;

    /* Read slices [z, z + count) to dst (count * dims[0] * dims[1] voxels). Called with z ascending, no
     * slice twice; slices may be left out. One caller at a time. */
    int (*read)(struct brick_source *source, uint64_t z, uint64_t count, void *dst, struct brick_error *err);
    /* Read voxels [lo, hi) to dst, x fastest, no padding: for volumes of which few slices fit into memory. In
     * any order, any number of times, never together with read. NULL where the source can only be read from
     * front to back. One caller at a time. */
    int (*read_box)(struct brick_source *source, const uint64_t lo[3], const uint64_t hi[3], void *dst,
                    struct brick_error *err);
    /* Boxes of slices [z, z + count) will be read soon: a hint, given in ascending order. A source that has
     * it says that a voxel read before costs little to read again. May be NULL; needs read_box. */
    void (*fetch)(struct brick_source *source, uint64_t z, uint64_t count);
    void (*destroy)(struct brick_source *source);
};

static inline void brick_source_destroy(struct brick_source **source)
{
    if (*source)
        (*source)->destroy(*source);
    *source = 0;
}

/* A volume being written, slice by slice: what export feeds. */
struct brick_sink {
    /* Write slices [z, z + count), z ascending, every slice once. */
    int (*write)(struct brick_sink *sink, uint64_t z, uint64_t count, const void *src,
                 struct brick_error *err);
    /* Complete the file under its final name. */
    int (*finish)(struct brick_sink *sink, struct brick_error *err);
    /* Releases everything; without finish nothing is left on disk. */
    void (*destroy)(struct brick_sink *sink);
};

static inline void brick_sink_destroy(struct brick_sink **sink)
{
    if (*sink)
        (*sink)->destroy(*sink);
    *sink = 0;
}

#ifdef __cplusplus
}
#endif
#endif
