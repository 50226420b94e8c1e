/* The active set from the index alone. A brick may be called active without need, never the other way round.
 */
#include <brick/active.h>

#include <math.h>

static bool integral(double v)
{
    return fabs(v) < 8388608.0 && v == trunc(v);
}

void brick_active_widen(double slope, double intercept, double *lo, double *hi)
{
    if (*lo == *hi && slope == 1.0 && (intercept == 0.0 || (integral(*lo) && integral(intercept))))
        return; /* a + t (a - a) = a, and adding small integers is exact */
    /* Three lerps, a product and a sum in float32: a dozen roundings of numbers no larger than this, 2^-24
     * each. */
    double most = fmax(fabs(*lo), fabs(*hi)) + 2.0 * fabs(intercept), e = most * 0x1p-20;
    *lo -= e;
    *hi += e;
}

/* Bins of a brick's mask that a range of stored values touches; the formula is the one that set them. */
static uint64_t bins_touched(const struct brick_entry *e, double lo, double hi)
{
    double min = (double)e->min, scale = 64.0 / ((double)e->max - min);
    double a = (lo - min) * scale, b = (hi - min) * scale;
    if (!(b >= 0.0) || !(a <= 64.0))
        return 0;
    unsigned first = a <= 0.0 ? 0 : a < 63.0 ? (unsigned)a : 63, last = b < 63.0 ? (unsigned)b : 63;
    return ~UINT64_C(0) << first & ~UINT64_C(0) >> (63 - last);
}

/* Does any support interval meet a bin that holds values? [lo, hi]: the brick's widened physical range. */
static bool mask_visible(const struct brick_grid *grid, const struct brick_entry *e,
                         const struct brick_transfer *transfer, double lo, double hi)
{
    if (e->min == e->max)
        return true; /* one value: the range has said it all */
    double margin = fmax(fabs(lo), fabs(hi)) * 0x1p-20 + 2.0 * fabs(grid->intercept) * 0x1p-20;
    for (size_t i = 0; i < transfer->support_count; i++) {
        const struct brick_interval *s = &transfer->support[i];
        if (s->hi < lo || s->lo > hi)
            continue;
        double a = (fmax(s->lo, lo) - margin - grid->intercept) / grid->slope;
        double b = (fmin(s->hi, hi) + margin - grid->intercept) / grid->slope;
        if (bins_touched(e, fmin(a, b), fmax(a, b)) & e->mask)
            return true;
    }
    return false;
}

static enum brick_state state_of(const struct brick_volume *volume, const struct brick_active_query *query,
                                 uint64_t id)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    double lo, hi;
    if (!brick_volume_physical_range(volume, id, &lo, &hi))
        return BRICK_STATE_EMPTY;
    brick_active_widen(grid->slope, grid->intercept, &lo, &hi);
    switch (query->mode) {
    case BRICK_MODE_ISO:
        if (lo > query->isovalue)
            return BRICK_STATE_ABOVE;
        if (hi < query->isovalue)
            return BRICK_STATE_EMPTY;
        /* f >= V is above: a constant brick exactly at V has no crossing, but its neighbours' samples need
         * its side */
        return BRICK_STATE_ACTIVE;
    case BRICK_MODE_MIP:
        /* It may hold the ray's maximum, and what is at or below that maximum is not all transparent. */
        return brick_transfer_visible(query->transfer, -INFINITY, hi) ? BRICK_STATE_ACTIVE
                                                                      : BRICK_STATE_EMPTY;
    default:
        return brick_transfer_visible(query->transfer, lo, hi) &&
                       mask_visible(grid, brick_volume_entry(volume, id), query->transfer, lo, hi)
                   ? BRICK_STATE_ACTIVE
                   : BRICK_STATE_EMPTY;
    }
}

uint64_t brick_active_set(const struct brick_volume *volume, const struct brick_active_query *query,
                          uint8_t *states)
{
    const struct brick_level *level = &brick_volume_grid(volume)->level[query->level];
    uint64_t n = level->bricks[0] * level->bricks[1] * level->bricks[2], active = 0;
    for (uint64_t i = 0; i < n; i++) {
        states[i] = (uint8_t)state_of(volume, query, level->first_brick + i);
        active += states[i] == BRICK_STATE_ACTIVE;
    }
    return active;
}
