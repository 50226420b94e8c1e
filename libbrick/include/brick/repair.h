/* From a damaged .brick file to a whole one: what is left of level 0 goes through the same machinery as a
 * conversion, and payloads that are whole are taken over as they are. So where no brick of level 0 is lost
 * the result is the file that was damaged, byte for byte, if it was lossless. */
#ifndef BRICK_REPAIR_H
#define BRICK_REPAIR_H

#include <brick/build.h>
#include <brick/damaged.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A brick of level 0 that is lost. Voxels that its neighbours' borders hold are right; each other one is that
 * of the next coarser level that is whole there, or, where there is none, NaN (f32) or the smallest value
 * found. */
struct brick_loss {
    uint64_t brick, at[3];
    uint32_t voxels, from_neighbours; /* of its core; how many of them are right */
    uint32_t from_level;              /* where the others are from; 0: from nowhere */
};

enum brick_downsample { BRICK_DOWNSAMPLE_AS_FOUND, BRICK_DOWNSAMPLE_MEAN, BRICK_DOWNSAMPLE_NEAREST };

struct brick_repair_params {
    uint64_t memory_bytes; /* of everything */
    unsigned threads;      /* 0: one a core */
    enum brick_downsample
        downsample; /* as found: from a coarser brick that is whole; mean where there is none */
    void (*lost)(void *context, const struct brick_loss *loss); /* each, in order; may be NULL */
    void *lost_context;
    void (*progress)(void *context, uint64_t done, uint64_t all); /* reading, then writing; may be NULL */
    void *progress_context;
};

struct brick_repair_report {
    struct brick_damage damage;
    uint64_t bricks, lost;   /* of all levels; of level 0 */
    uint64_t rebuilt;        /* of coarser levels, made again */
    uint64_t unconfirmed;    /* of level 0, found without a checksum: they agree with what is around them */
    bool guessed_downsample; /* coarser levels are rebuilt, as means, and nothing said how they were made */
    double tolerance_was,
        tolerance; /* of the files; rebuilt bricks of lossy files may be off by twice as much */
    uint64_t output_bytes;
};

/* path is not touched; to, another file, appears when it is complete. Losses are no error: the report tells.
 */
int brick_repair(const char *path, const char *to, const struct brick_repair_params *params,
                 struct brick_repair_report *report, struct brick_error *err);

#ifdef __cplusplus
}
#endif
#endif
