/* What is drawn of a brick: boxes of its active macrocells, and for slabs its rim. */
#ifndef RENDERER_METHODS_SLICES_PARTS_H
#define RENDERER_METHODS_SLICES_PARTS_H

#include "boxes.h"
#include "sheets.h"
#include "stack.h"

/* Of one brick at a time. Kept from picture to picture; one of zeros is empty. */
struct vr_parts {
    struct vr_stack_box *boxes;
    uint32_t *numbers; /* theirs in the sheets */
    size_t count, room;
    struct vr_cell_box *cells; /* room for one a macrocell */
};

/* All of a brick, resident or not. */
void vr_parts_whole(const struct vr_frame *frame, const struct vr_stack *stack, uint32_t brick,
                    struct vr_stack_box *box);
/* Find the parts of a brick that is resident, and add their boxes to the sheets. */
int vr_parts_find(struct vr_parts *parts, const struct vr_frame *frame, const struct vr_stack *stack,
                  uint32_t brick, struct vr_sheets *sheets, struct brick_error *err);
void vr_parts_finish(struct vr_parts *parts);

#endif
