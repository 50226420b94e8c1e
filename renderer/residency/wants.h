/* Bricks that a picture wants, in the order in which they are to come. */
#ifndef RENDERER_RESIDENCY_WANTS_H
#define RENDERER_RESIDENCY_WANTS_H

#include <stddef.h>

#include "depth.h"
#include "feedback.h"

struct vr_want {
    double distance; /* those with the smallest come first */
    uint32_t brick;  /* of the level */
    bool needed;     /* else asked ahead */
};

/* A list that grows; one of zeros is empty. How many of its items count, its user knows. */
struct vr_wants {
    struct vr_want *item;
    size_t room;
};

int vr_wants_reserve(struct vr_wants *wants, size_t n, struct brick_error *err);
void vr_wants_finish(struct vr_wants *wants);
/* By distance, then by number. */
void vr_wants_sort(struct vr_wants *wants, size_t n);
/* What rays ask for, by depth, *count in all. The nearest that a ray waits for is the first, should rounding
 * have put another before it: that one is sure of a slot, so every pass takes a ray further. */
int vr_wants_gather(struct vr_wants *wants, const struct vr_feedback *feedback, const struct vr_depth *depth,
                    size_t *count, struct brick_error *err);

#endif
