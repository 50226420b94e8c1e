/* A level's voxels in other orders than the file's, in memory, to measure the file's against. */
#ifndef RENDERER_ISOTRACE_LAYOUT_H
#define RENDERER_ISOTRACE_LAYOUT_H

#include "walk.h"

struct vr_iso_layout_copy {
    enum vr_iso_layout layout;
    uint32_t level;
    bool ready;
    struct vr_iso_block *blocks; /* flat: one; tiled: one a brick of the level */
    void *voxels, *ranges;
    uint32_t *table[3];
};

/* Make the copy of a level, unless it is there. BRICK_ERR_MEMORY when it needs more than budget_bytes. */
int vr_iso_layout_make(struct vr_iso_layout_copy *copy, const struct brick_volume *volume, uint32_t level,
                       uint64_t budget_bytes, struct brick_error *err);
void vr_iso_layout_finish(struct vr_iso_layout_copy *copy);

#endif
