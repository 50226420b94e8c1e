/* What a brick must agree with: its ranges with its voxels, its border with the volume's edge and with its
 * neighbours, its level with the next. Checking a file relies on it, and so does finding places for payloads
 * whose places are lost. */
#ifndef BRICK_BUILD_AGREE_H
#define BRICK_BUILD_AGREE_H

#include "encode.h"

/* The 2 * border layers of voxels at one face, which the neighbour beyond it holds too. */
struct agree_face {
    uint64_t hash;
    bool flat; /* all of its voxels are one value, and the hash is of one of them */
};
/* axis 0..2; scratch: agree_face_bytes. Without with_flat every face is hashed as a whole. */
struct agree_face agree_face(const struct brick_grid *grid, const struct brick_place *place,
                             const void *voxels, int axis, bool high, bool with_flat, void *scratch);
size_t agree_face_bytes(const struct brick_grid *grid);

/* Do voxels beyond the volume's edge repeat it, to twice the tolerance (in stored values)? */
bool agree_edge_repeats(const struct brick_grid *grid, const struct brick_place *place, const void *voxels,
                        double tolerance);

/* A payload's macrocells, and the entry, against what the voxels give: equal at level 0, no narrower above
 * it. NULL, or what is wrong. scratch->payload holds the payload; the macrocells that its voxels give go to
 * `found`, their range and mask to `own`. */
const char *agree_ranges(const struct brick_grid *grid, const struct brick_place *place,
                         const struct brick_entry *entry, struct encoder *scratch, void *found,
                         struct brick_entry *own);

/* The box of the next level's voxels that a brick's core becomes, inside the core of brick `parent` of it:
 * from `lo` (counted from that core's first voxel) on, `size` voxels. Not for the last level. */
struct agree_part {
    uint64_t parent;
    uint32_t lo[3], size[3];
};
struct agree_part agree_part(const struct brick_grid *grid, const struct brick_place *place);
/* The voxels of this box, x fastest, as made from a brick's; scratch: agree_coarse_bytes. */
void agree_make_part(const struct kernels *kernels, const struct brick_grid *grid,
                     const struct brick_place *place, const void *voxels, bool nearest, void *part,
                     void *scratch);
/* The same as the parent (whose place and voxels these are) has them. */
void agree_take_part(const struct brick_grid *grid, const struct brick_place *parent, const void *voxels,
                     const struct agree_part *part, void *out);
size_t agree_coarse_bytes(const struct brick_grid *grid);

#endif
