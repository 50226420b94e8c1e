/* Which stored values are above an isovalue. */
#ifndef RENDERER_ISOTRACE_SPLIT_H
#define RENDERER_ISOTRACE_SPLIT_H

#include "walk.h"

/* Fill split and split_int from isovalue. */
void vr_iso_split(const struct brick_grid *grid, struct vr_iso_level *level);

#endif
