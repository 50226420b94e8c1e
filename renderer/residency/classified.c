/* A copy of the transfer function's knots: its address says nothing, since callers may fill it anew. */
#include "classified.h"

#include <stdlib.h>
#include <string.h>

/* NULL where the bits do not depend on it. */
static const struct brick_transfer *transfer_of(const struct brick_active_query *q)
{
    return q->mode != BRICK_MODE_ISO ? q->transfer : NULL;
}

static bool same(const struct vr_classified *c, const struct brick_active_query *q)
{
    const struct brick_transfer *t = transfer_of(q);
    if (!c->number || c->mode != q->mode || (q->mode == BRICK_MODE_ISO && c->isovalue != q->isovalue))
        return false;
    return t ? c->count == t->count && c->emission == t->emission &&
                   !memcmp(c->knots, t->knots, t->count * sizeof *c->knots)
             : !c->count;
}

int vr_classified_set(struct vr_classified *c, const struct brick_active_query *q, struct brick_error *err)
{
    const struct brick_transfer *t = transfer_of(q);
    struct brick_transfer_knot *knots = NULL;
    if (same(c, q))
        return BRICK_OK;
    if (t && !(knots = malloc(t->count * sizeof *knots)))
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a transfer function of %zu knots", t->count);
    if (t)
        memcpy(knots, t->knots, t->count * sizeof *knots);
    free(c->knots);
    *c = (struct vr_classified){c->number + 1, q->mode,
                                q->isovalue,   t ? t->emission : BRICK_EMISSION_SCALED,
                                knots,         t ? t->count : 0};
    return BRICK_OK;
}

void vr_classified_finish(struct vr_classified *c)
{
    free(c->knots);
    *c = (struct vr_classified){0};
}
