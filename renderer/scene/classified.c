/* Two queries classify alike when mode, isovalue and transfer function are the same, whatever the level. */
#include "classified.h"

#include <stdlib.h>
#include <string.h>

static bool same(const struct vr_classified *c, const struct brick_active_query *q, size_t count)
{
    return c->number && c->mode == q->mode && (q->mode != BRICK_MODE_ISO || c->isovalue == q->isovalue) &&
           c->count == count &&
           (!count || (c->emission == q->transfer->emission &&
                       !memcmp(c->knots, q->transfer->knots, count * sizeof *c->knots)));
}

int vr_classified_set(struct vr_classified *c, const struct brick_active_query *q, struct brick_error *err)
{
    const size_t count = q->transfer && q->mode != BRICK_MODE_ISO ? q->transfer->count : 0;
    if (same(c, q, count))
        return BRICK_OK;
    struct brick_transfer_knot *knots = count ? malloc(count * sizeof *knots) : NULL;
    if (count && !knots)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a transfer function of %zu knots", count);
    if (count)
        memcpy(knots, q->transfer->knots, count * sizeof *knots);
    free(c->knots);
    const enum brick_emission emission = count ? q->transfer->emission : BRICK_EMISSION_SCALED;
    *c = (struct vr_classified){c->number + 1, q->mode, q->isovalue, emission, knots, count};
    return BRICK_OK;
}

void vr_classified_finish(struct vr_classified *c)
{
    free(c->knots);
    *c = (struct vr_classified){0};
}
