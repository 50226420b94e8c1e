/* What macrocell bits depend on, kept to see whether it changed. */
#ifndef RENDERER_SCENE_CLASSIFIED_H
#define RENDERER_SCENE_CLASSIFIED_H

#include <stdbool.h>

#include <brick/active.h>

struct vr_classified {
    uint64_t number; /* grows with every change; 0: none yet */
    enum brick_mode mode;
    double isovalue;
    enum brick_emission emission;
    struct brick_transfer_knot *knots;
    size_t count;
};

/* One of zeros is empty. */
int vr_classified_set(struct vr_classified *classification, const struct brick_active_query *query,
                      struct brick_error *err);
void vr_classified_finish(struct vr_classified *classification);

#endif
