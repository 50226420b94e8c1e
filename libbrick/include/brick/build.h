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

/* What a conversion does to every voxel. Times are summed over threads: on a core for what is computed, on
 * the wall for what waits for disks (read, spool, write, finish). Bytes: of voxels for what is done to voxels
 * (borders and coarser levels included), of encoded bricks for writing. */
enum brick_build_stage {
    BRICK_STAGE_READ,   /* the source */
    BRICK_STAGE_GATHER, /* bricks with their borders */
    BRICK_STAGE_RANGES, /* of macrocells and bricks */
    BRICK_STAGE_COUNT,  /* statistics */
    BRICK_STAGE_COMPRESS,
    BRICK_STAGE_RESUME,     /* bricks of an interrupted conversion, checked or decoded */
    BRICK_STAGE_DOWNSAMPLE, /* bytes of the finer level */
    BRICK_STAGE_SPOOL,      /* levels that wait in scratch files, written and read */
    BRICK_STAGE_WRITE,      /* checksums and payloads */
    BRICK_STAGE_FINISH,     /* coarser levels and tables behind level 0, sync, rename */
    BRICK_STAGES
};

struct brick_build_params {
    uint32_t edge, border, macrocell;
    enum brick_codec codec;
    int codec_level;       /* 1..9 */
    double tolerance;      /* lossy codecs, above 0: no voxel is off by more, in physical units */
    bool nearest;          /* coarser levels take voxel 2i instead of averaging (labels) */
    bool round_to_f32;     /* u32, i32, f64 values that f32 cannot hold are rounded; else BRICK_ERR_INEXACT */
    uint64_t memory_bytes; /* budget of everything; BRICK_ERR_MEMORY names what would do */
    unsigned threads;      /* that encode, 0: one a core; two more read and write */
    bool plain;            /* no vectorised loops: the same file, slower */
    /* Bricks with keep[id] set are taken from this volume, of the source's grid, entry and payload as they
     * are; the others may then be lossless where the tolerance is above 0. Provenance is the source's alone.
     */
    const struct brick_volume *keep_from;
    const unsigned char *keep; /* NULL: none */
    bool resume;               /* keep what an interrupted conversion of the same source has left */
    /* May be NULL. limit: the stage that has limited so far, as brick_build_limit. */
    void (*progress)(void *context, uint64_t slices_done, uint64_t slices, enum brick_build_stage limit);
    void *progress_context;
};
extern const struct brick_build_params brick_build_defaults;

struct brick_build_cost {
    uint64_t ns, bytes;
};

struct brick_build_report {
    uint64_t input_bytes;  /* the volume, in bytes of the source's type */
    uint64_t source_bytes; /* of it, read: less when resuming, more in tiles */
    uint64_t output_bytes; /* the file */
    uint64_t bricks, bricks_constant;
    uint64_t bricks_kept;    /* of them, from an interrupted conversion */
    uint64_t bricks_decoded; /* of these, decoded again */
    uint64_t memory_bytes;   /* of everything, as planned */
    unsigned threads;        /* that encoded */
    bool tiled; /* rows of bricks did not fit, or not beside coarser levels: level 0 was read in tiles, their
                   borders twice */
    uint64_t spooled_bytes; /* of voxels that waited in scratch files */
    struct brick_build_cost stage[BRICK_STAGES];
    uint64_t wait_read_ns;  /* the encoding threads waited for the source, all together */
    uint64_t wait_write_ns; /* and for the writer */
    bool converted;         /* source type was u32, i32 or f64 and the file holds f32 */
    double seconds;
};

/* "read", "gather", ... */
const char *brick_build_stage_name(enum brick_build_stage stage);
/* The stage that limits: reading, writing or finishing where the encoding threads waited for it longer than
 * they worked, else the one on which they spent most. */
enum brick_build_stage brick_build_limit(const struct brick_build_report *report);

/* The file's bytes depend on the source and on params' layout and codec alone: not on threads, memory, plain,
 * or where it was interrupted and resumed.
 *
 * Until it is complete it is PATH.part, with PATH.part.levels and PATH.part.journal beside it. Killed, a
 * conversion leaves them. Failing, it removes them, unless it was to resume, or the system refused a read or
 * a write (BRICK_ERR_IO: a full disk, say) and something can be resumed: the message says so. Resuming is
 * refused with BRICK_ERR_ARGUMENT for a source without a state, and when source, layout or codec are not
 * those with which it was begun. */
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
