/* The bounding geometry of a picture (Scharsach 2005, sections 3 and 8): blocks at the border between active
 * and inactive ones, where blocks are macrocells. A brick that is not in the atlas has no macrocells yet, and
 * all of it is active; so are bricks of lossy volumes where classification is pre-integrated. */
#ifndef RENDERER_METHODS_BLOCKS_H
#define RENDERER_METHODS_BLOCKS_H

#include "frame.h"

/* Blocks side by side on x, as one; in macrocells of the level. */
struct vr_row {
    uint32_t from, to, y, z;
};

struct vr_blocks {
    struct vr_row *row;
    size_t count, room;
    uint64_t fingerprint; /* of what is active; 0: nothing was found yet */

    /* What is active. */
    uint32_t *place; /* a brick's place in the list of active ones, from 1; 0: not active */
    uint64_t bricks;
    const uint32_t **bits; /* a list: macrocell bits of active bricks; NULL: all are active */
    size_t bits_room;
};

/* Find them for the frame, unless they are what they were: *changed says. One of zeros is empty. */
int vr_blocks_update(struct vr_blocks *blocks, const struct vr_frame *frame, bool *changed,
                     struct brick_error *err);
void vr_blocks_finish(struct vr_blocks *blocks);

/* After an update: does an active block, made larger by margin (in voxels of the level), hold the point? */
bool vr_blocks_inside(const struct vr_blocks *blocks, const struct vr_frame *frame, const double at[3],
                      const double margin[3]);

#endif
