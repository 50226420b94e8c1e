/* From a source to a .brick file, in one pass: padded bricks, level pyramid, ranges, statistics. */
#ifndef BRICK_BUILD_H
#define BRICK_BUILD_H

#include <stdbool.h>
#include <stdint.h>

#include <brick/codec.h>
#include <brick/source.h>
#include <brick/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

struct brick_build_params {
    uint32_t edge, border, macrocell;
    enum brick_codec codec;
    int codec_level;       /* 1..9 */
    double tolerance;      /* lossy codecs, above 0: no voxel is off by more, in physical units */
    bool nearest;          /* coarser levels take voxel 2i instead of averaging (labels) */
    bool round_to_f32;     /* u32, i32, f64 values that f32 cannot hold are rounded; else BRICK_ERR_INEXACT */
    uint64_t memory_bytes; /* budget of the slabs and queues; BRICK_ERR_MEMORY names what would do */
    unsigned threads;      /* 0: one a core */
    void (*progress)(void *context, uint64_t slices_done, uint64_t slices); /* may be NULL */
    void *progress_context;
};
extern const struct brick_build_params brick_build_defaults;

struct brick_build_report {
    uint64_t input_bytes;  /* voxels read, in bytes of the source's type */
    uint64_t output_bytes; /* the file */
    uint64_t bricks, bricks_constant;
    uint64_t memory_bytes; /* of slabs and queues */
    bool converted;        /* source type was u32, i32 or f64 and the file holds f32 */
    double seconds;
};

int brick_build(struct brick_source *source, const char *path, const struct brick_build_params *params,
                struct brick_build_report *report, struct brick_error *err);

/* Compare a file with itself: checksums of every brick (tables were checked on opening), ranges, masks and
 * macrocells against the voxels, borders against the neighbour's core (within twice the tolerance of a lossy
 * file, which reads each brick up to four times), statistics against level 0.
 * The first contradiction is the error. */
int brick_check(const struct brick_volume *volume, unsigned threads,
                void (*progress)(void *context, uint64_t done, uint64_t bricks), void *progress_context,
                struct brick_error *err);

#ifdef __cplusplus
}
#endif
#endif
