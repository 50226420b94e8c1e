/* What macrocell bits depend on, kept to see whether it changed. */
#ifndef RENDERER_RESIDENCY_CLASSIFIED_H
#define RENDERER_RESIDENCY_CLASSIFIED_H

#include <brick/active.h>

/* One of zeros has classified nothing. */
struct vr_classified {
    uint64_t number; /* another after every change; 0: nothing yet */
    enum brick_mode mode;
    double isovalue;
    enum brick_emission emission;
    struct brick_transfer_knot *knots;
    size_t count;
};

/* Take over what the query asks for, its level apart. */
int vr_classified_set(struct vr_classified *classified, const struct brick_active_query *query,
                      struct brick_error *err);
void vr_classified_finish(struct vr_classified *classified);

#endif
