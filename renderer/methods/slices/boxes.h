/* Few boxes that hold a brick's active macrocells and little else: what is drawn of a brick. */
#ifndef RENDERER_METHODS_SLICES_BOXES_H
#define RENDERER_METHODS_SLICES_BOXES_H

#include <stddef.h>
#include <stdint.h>

struct vr_cell_box {
    int low[3], high[3]; /* macrocells, high exclusive */
};

/* bits: macrocell (x, y, z) of cells[a] on axis a is bit (z * cells[1] + y) * cells[0] + x, 32 in a word.
 * Boxes do not overlap, every active macrocell is in one, and at least half of each box is active. At most
 * one box a macrocell; returns how many. */
size_t vr_boxes_of(const uint32_t *bits, const int cells[3], struct vr_cell_box *boxes);

#endif
