/* A damaged file's level 0 as a source of voxels: what is lost is filled in from what is left. */
#ifndef BRICK_BUILD_PATCH_H
#define BRICK_BUILD_PATCH_H

#include <brick/repair.h>
#include <brick/source.h>

#include "salvage.h"
#include "tile.h"

struct patch {
    struct brick_source base;
    const struct salvage *salvage;
    double fill; /* stored value where nothing is known */
    struct brick_scratch scratch;
    unsigned char *brick, *core,
        *known; /* a decoded brick; a lost brick's core; which of its voxels are right */
    struct box slab;
    unsigned char *slab_voxels;
    size_t slab_bytes;
};

/* Memory that it takes, its slab apart (base.held_slices). */
uint64_t patch_bytes(const struct brick_grid *grid);
int patch_init(struct patch *patch, const struct salvage *salvage, struct brick_error *err);
void patch_finish(struct patch *patch);
/* Work out a lost brick's core, into patch->core, and say where it comes from. */
int patch_lost(struct patch *patch, uint64_t id, struct brick_loss *loss, struct brick_error *err);

#endif
