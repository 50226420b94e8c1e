/* The active set from the index alone, and macrocells by the same rule. A brick or macrocell may be called
 * active without need, never the other way round.
 *
 * One rule (`state_of`) decides for both, so a macrocell's bit never contradicts its brick's state. It is
 * called for every brick of the volume whenever the transfer function changes: no division, no call, one
 * search among the function's visible intervals. */
#include <brick/active.h>

#include <math.h>

#define AHEAD_BYTES                                                                                          \
    1152                 /* the index streams through: fetched this far ahead the loop takes half the time   \
                          */
#define ROUNDING 0x1p-20 /* a dozen roundings in float32, 2^-24 each */

struct rule {
    enum brick_mode mode;
    double slope, intercept, isovalue;
    double mip_from;    /* mip: the smallest visible value; NaN: there is none */
    double exact_below; /* physical values below this, in magnitude, may come out exactly */
    const struct brick_interval *visible;
    size_t count;
};

static const struct brick_interval nothing = {INFINITY, -INFINITY};

/* Adding 1.5 * 2^52 leaves no bits for a fraction. */
static inline bool integral(double v)
{
    return (fabs(v) < 0x1p23) & (v + 0x1.8p52 - 0x1.8p52 == v);
}

/* A constant a interpolates as a + t (a - a) = a, and adding small integers is exact. */
static double exact_below(double slope, double intercept)
{
    return slope != 1.0 ? 0.0 : intercept == 0.0 ? INFINITY : integral(intercept) ? 0x1p23 : 0.0;
}

/* What float32 may add to a physical range: three lerps, a product and a sum round numbers no larger than
 * this. In the hot loop, so without branches. */
static inline double widening(double lo, double hi, double intercept, double limit)
{
    double a = fabs(lo), b = fabs(hi), most = a > b ? a : b;
    int exact = (lo == hi) & (most < limit) & ((limit > 0x1p23) | integral(lo));
    return (most + 2.0 * fabs(intercept)) * ROUNDING * (double)(1 - exact);
}

void brick_active_widen(double slope, double intercept, double *lo, double *hi)
{
    double e = widening(*lo, *hi, intercept, exact_below(slope, intercept));
    *lo -= e;
    *hi += e;
}

static struct rule rule_of(const struct brick_grid *grid, const struct brick_active_query *query)
{
    struct rule r = {.mode = query->mode,
                     .slope = grid->slope,
                     .intercept = grid->intercept,
                     .isovalue = query->isovalue,
                     .mip_from = NAN,
                     .exact_below = exact_below(grid->slope, grid->intercept),
                     .visible = &nothing,
                     .count = 1};
    if (query->mode != BRICK_MODE_ISO && query->transfer->visible_count) {
        r.visible = query->transfer->visible;
        r.count = query->transfer->visible_count;
        r.mip_from = r.visible[0].lo;
    }
    return r;
}

/* brick_transfer_visible for ranges that are not empty, without branches that depend on the range. */
static inline bool visible(const struct rule *r, double lo, double hi)
{
    const struct brick_interval *at = r->visible;
    for (size_t n = r->count;
         n > 1;) { /* the last interval that starts at or below hi is the only candidate */
        size_t half = n / 2;
        at += at[half].lo <= hi ? half : 0;
        n -= half;
    }
    return (at->lo <= hi) & (at->hi >= lo);
}

/* State of a place whose stored values are in [min, max]; its widened physical range to *lo, *hi. */
static inline enum brick_state state_of(const struct rule *r, double min, double max, double *lo, double *hi)
{
    if (!(min <= max))
        return BRICK_STATE_EMPTY;
    double a = r->slope * (r->slope < 0.0 ? max : min) + r->intercept;
    double b = r->slope * (r->slope < 0.0 ? min : max) + r->intercept;
    double e = widening(a, b, r->intercept, r->exact_below);
    *lo = a - e;
    *hi = b + e;
    switch (r->mode) {
    case BRICK_MODE_ISO: /* a value is above when it is not below */
        return *lo >= r->isovalue  ? BRICK_STATE_ABOVE
               : *hi < r->isovalue ? BRICK_STATE_EMPTY
                                   : BRICK_STATE_ACTIVE;
    case BRICK_MODE_MIP:
        /* It may hold the ray's maximum, and what is at or below that maximum is not all transparent. */
        return *hi >= r->mip_from ? BRICK_STATE_ACTIVE : BRICK_STATE_EMPTY;
    default:
        return visible(r, *lo, *hi) ? BRICK_STATE_ACTIVE : BRICK_STATE_EMPTY;
    }
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

/* Does any visible interval meet a bin that holds values? [lo, hi]: the brick's widened physical range. Rare:
 * the mask is full unless voxels are NaN or Inf. */
static bool mask_visible(const struct rule *r, const struct brick_entry *e, double lo, double hi)
{
    double margin = (fmax(fabs(lo), fabs(hi)) + 2.0 * fabs(r->intercept)) * ROUNDING;
    for (size_t i = 0; i < r->count; i++) {
        const struct brick_interval *s = &r->visible[i];
        if (s->hi < lo || s->lo > hi)
            continue;
        double a = (fmax(s->lo, lo) - margin - r->intercept) / r->slope;
        double b = (fmin(s->hi, hi) + margin - r->intercept) / r->slope;
        if (bins_touched(e, fmin(a, b), fmax(a, b)) & e->mask)
            return true;
    }
    return false;
}

/* By an isosurface a cell with a corner that is NaN or Inf has no side, whatever the rest of its brick has.
 * Such voxels are counted at level 0; a brick of a coarser level averages whole bricks of level 0, and its
 * cells reach one voxel into the next brick. Returns how many bricks became active. */
static uint64_t mark_whole(const struct brick_volume *volume, uint32_t level, uint8_t *states)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const uint64_t *fine = grid->level[0].bricks, *coarse = grid->level[level].bricks;
    const double *scale = grid->level[level].scale;
    const int halved[3] = {ilogb(scale[0]), ilogb(scale[1]), ilogb(scale[2])};
    const struct brick_entry *e = brick_volume_entry(volume, 0);
    uint64_t more = 0;
    for (uint64_t z = 0; z < fine[2]; z++)
        for (uint64_t y = 0; y < fine[1]; y++)
            for (uint64_t x = 0; x < fine[0]; x++, e++) {
                if (!e->nonfinite)
                    continue;
                const uint64_t at[3] = {x >> halved[0], y >> halved[1], z >> halved[2]};
                for (unsigned n = 0; n < 8; n++) {
                    const uint64_t dx = n & 1, dy = n >> 1 & 1, dz = n >> 2;
                    if (dx > at[0] || dy > at[1] || dz > at[2])
                        continue;
                    uint8_t *s = &states[((at[2] - dz) * coarse[1] + at[1] - dy) * coarse[0] + at[0] - dx];
                    more += *s < BRICK_STATE_ACTIVE;
                    *s = BRICK_STATE_WHOLE;
                }
            }
    return more;
}

static uint64_t set_of(const struct brick_volume *volume, const struct brick_active_query *query, bool masks,
                       uint8_t *states)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_level *level = &grid->level[query->level];
    const struct brick_entry *e = brick_volume_entry(volume, level->first_brick);
    const struct rule r = rule_of(grid, query);
    const bool by_mask = masks && (query->mode == BRICK_MODE_DVR || query->mode == BRICK_MODE_SHADED);
    uint64_t n = level->bricks[0] * level->bricks[1] * level->bricks[2], active = 0;
    for (uint64_t i = 0; i < n; i++, e++) {
        double lo, hi;
        __builtin_prefetch((const void *)((uintptr_t)e + AHEAD_BYTES));
        enum brick_state state = state_of(&r, (double)e->min, (double)e->max, &lo, &hi);
        if (by_mask & (state == BRICK_STATE_ACTIVE) & (e->mask != ~UINT64_C(0)) & (e->min < e->max))
            state = mask_visible(&r, e, lo, hi) ? BRICK_STATE_ACTIVE : BRICK_STATE_EMPTY;
        states[i] = (uint8_t)state;
        active += state == BRICK_STATE_ACTIVE;
    }
    if (query->mode == BRICK_MODE_ISO && brick_volume_stats(volume)->nonfinite)
        active += mark_whole(volume, query->level, states);
    return active;
}

uint64_t brick_active_set(const struct brick_volume *volume, const struct brick_active_query *query,
                          uint8_t *states)
{
    return set_of(volume, query, true, states);
}

uint64_t brick_active_by_interval(const struct brick_volume *volume, const struct brick_active_query *query,
                                  uint8_t *states)
{
    return set_of(volume, query, false, states);
}

uint64_t brick_active_macrocells(const struct brick_grid *grid, const struct brick_active_query *query,
                                 bool whole, enum brick_type type, const void *ranges,
                                 const uint32_t count[3], const uint32_t stride[2], uint32_t *active,
                                 uint32_t *above)
{
    const struct rule r = rule_of(grid, query);
    uint64_t sum = 0;
    size_t i = 0;
    for (uint32_t z = 0; z < count[2]; z++)
        for (uint32_t y = 0; y < count[1]; y++)
            for (uint32_t x = 0; x < count[0]; x++, i += 2) {
                double lo, hi, min = brick_type_load(type, ranges, i),
                               max = brick_type_load(type, ranges, i + 1);
                enum brick_state state = whole ? BRICK_STATE_WHOLE : state_of(&r, min, max, &lo, &hi);
                size_t bit = x + (size_t)y * stride[0] + (size_t)z * stride[1];
                if (state == BRICK_STATE_EMPTY)
                    continue;
                uint32_t *plane = state == BRICK_STATE_ABOVE ? above : active;
                plane[bit / 32] |= UINT32_C(1) << (bit % 32);
                sum += state != BRICK_STATE_ABOVE;
            }
    return sum;
}
