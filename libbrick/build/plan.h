/* How a conversion fits into its memory: what is held, in which pieces, and what waits in scratch files. */
#ifndef BRICK_BUILD_PLAN_H
#define BRICK_BUILD_PLAN_H

#include <brick/build.h>

#include "tile.h"

struct plan {
    bool boxes;           /* level 0 is read tile by tile; else slice by slice into a ring */
    uint64_t ring_slices; /* of level 0, when not in boxes */
    uint32_t
        first_in_memory; /* this level and coarser ones have rings in memory; those between it and 0 spools */
    uint64_t shape[2];   /* of tiles, in bricks */
    uint64_t slots;      /* encoded bricks on their way to the writer */
    uint64_t box_bytes;  /* of a level-0 tile with its borders; two are held */
    uint64_t in_bytes;   /* of the largest tile from a spool, one of three arrays; 0 without spools */
    uint64_t out_bytes;  /* of the largest tile on its way to one, likewise */
    uint64_t staging_bytes; /* source voxels on their way to f32; 0 when they need no conversion */
    uint64_t memory_bytes;  /* of everything */
};

/* Slices a coarse level's ring holds: those that a row of bricks needs, and those that arrive at once. */
uint64_t plan_coarse_slices(const struct brick_grid *grid, uint32_t level);
/* BRICK_ERR_MEMORY names what would do. */
int plan_make(struct plan *plan, const struct brick_grid *grid, const struct brick_source *source,
              const struct brick_build_params *params, unsigned threads, struct brick_error *err);

#endif
