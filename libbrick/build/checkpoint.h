/* What a conversion needs to go on from the end of a row of level 0 without decoding the rows before it: the
 * statistics so far, and the slices that coarser levels wait with. Now and then it becomes a note in the
 * writer's journal. It does not depend on threads, memory or tiles. */
#ifndef BRICK_BUILD_CHECKPOINT_H
#define BRICK_BUILD_CHECKPOINT_H

#include "drain.h"
#include "pyramid.h"
#include "tally.h"

struct checkpoint {
    struct brick_writer *writer;
    struct pyramid *pyramid;
    struct drain *drain;
    struct tally *tallies;
    unsigned threads;
    /* Of the one that was opened: rows [0, rows) of level 0 are in it; those from `first` on have to be gone
     * through again, for coarser levels alone. */
    uint64_t rows, first;
    uint64_t slices_at; /* in the note */
    uint64_t last;      /* rows in the last one, opened or saved */
};

/* Rows [0, rows) are done: is there to be one now? */
bool checkpoint_due(const struct checkpoint *checkpoint, uint64_t rows);
/* All workers rest. */
int checkpoint_save(struct checkpoint *checkpoint, uint64_t rows, struct brick_error *err);
/* Go back to the last one whose bricks are kept: its statistics, and the pyramid as at row `first`. Without
 * one, both rows are 0. */
int checkpoint_open(struct checkpoint *checkpoint, struct brick_error *err);
/* The rest of it, after rows [first, rows). */
int checkpoint_load_slices(const struct checkpoint *checkpoint, struct brick_error *err);

#endif
