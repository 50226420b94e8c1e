/* What of a damaged file's bricks is whole. */
#ifndef BRICK_BUILD_SALVAGE_H
#define BRICK_BUILD_SALVAGE_H

#include <brick/damaged.h>
#include <brick/threads.h>

#include "agree.h"

/* Of a brick. */
enum {
    SALVAGE_VOXELS = 1, /* its payload is right, or it is constant: brick_volume_read gives its voxels */
    SALVAGE_ENTRY = 2,  /* and its entry describes them: it can be kept as it is */
    SALVAGE_GONE = 4    /* its entry is right and its payload is not */
};

struct salvage_worker {
    struct encoder encoder; /* encoder.payload: a decoded brick */
    struct brick_scratch scratch;
    unsigned char *macrocells, *face, *coarse, *part[2];
};

struct salvage {
    struct brick_volume *volume;
    const struct brick_grid *grid;
    struct brick_damage damage;
    double tolerance; /* in stored values */
    struct brick_pool *pool;
    unsigned threads;
    struct salvage_worker *workers;
    unsigned char *state; /* of each brick */
    uint64_t first;       /* brick of the batch that is being read */
    uint64_t unconfirmed; /* bricks of level 0 whose checksums are lost: their voxels agree with all else */
    void (*progress)(void *context, uint64_t done, uint64_t bricks);
    void *progress_context;
};

/* Memory that a salvage takes beside the volume's. */
uint64_t salvage_bytes(const struct brick_grid *grid, unsigned threads);
int salvage_init(struct salvage *salvage, struct brick_volume *volume, const struct brick_damage *damage,
                 unsigned threads, struct brick_error *err);
void salvage_finish(struct salvage *salvage);
/* Read every brick and fill in the states. Only what has nothing to do with the file is an error. */
int salvage_read(struct salvage *salvage, struct brick_error *err);
/* Where entries are damaged: find the bricks' payloads by what must agree. Lossless files only. */
int salvage_find(struct salvage *salvage, struct brick_error *err);
/* Memory that it takes. */
uint64_t salvage_find_bytes(const struct brick_grid *grid);

/* A worker's decoded brick: are its ranges right, where nothing but its bytes is trusted? If so `entry`'s
 * range, mask and count are put right; *complete: they are known for sure. */
bool salvage_judge(const struct salvage *salvage, struct salvage_worker *worker,
                   const struct brick_place *place, struct brick_entry *entry, bool *complete);

#endif
