/* The active set: which bricks of a level, and which macrocells inside them, a picture can need. Bricks are
 * judged from the index alone, without I/O. All functions are safe from several threads at once. */
#ifndef BRICK_ACTIVE_H
#define BRICK_ACTIVE_H

#include <stdint.h>

#include <brick/transfer.h>
#include <brick/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

enum brick_mode { BRICK_MODE_DVR, BRICK_MODE_SHADED, BRICK_MODE_ISO, BRICK_MODE_MIP };

/* State of a brick or macrocell for one picture. For iso an inactive one says on which side of the isovalue
 * it lies. From BRICK_STATE_ACTIVE on the brick is needed. */
enum brick_state {
    BRICK_STATE_EMPTY = 0, /* below the isovalue, or nothing visible */
    BRICK_STATE_ABOVE = 1, /* iso: wholly at or above the isovalue */
    BRICK_STATE_ACTIVE = 2,
    BRICK_STATE_WHOLE = 3 /* iso, bricks: active with all its macrocells: a voxel near it is NaN or Inf, and
                             samples there have no side, which ranges do not tell */
};

struct brick_active_query {
    enum brick_mode mode;
    const struct brick_transfer *transfer; /* dvr, shaded, mip */
    double isovalue;                       /* iso: physical */
    uint32_t level;
};

/* Widen [lo, hi] (physical) by what float32 interpolation and rescaling may add: constant ranges that convert
 * exactly stay as they are. */
void brick_active_widen(double slope, double intercept, double *lo, double *hi);

/* states: one byte a brick of the level, x fastest. Returns the number of active ones, whole ones included.
 */
uint64_t brick_active_set(const struct brick_volume *volume, const struct brick_active_query *query,
                          uint8_t *states);
/* The same without the occupancy masks: to see what they are worth. */
uint64_t brick_active_by_interval(const struct brick_volume *volume, const struct brick_active_query *query,
                                  uint8_t *states);

/* The same for the macrocells of one brick, by the same rule. ranges: pairs (min, max) of `type`, x fastest,
 * count[a] on axis a, as they lie behind the voxels of a payload. Macrocell (x, y, z) is bit x + y *
 * stride[0] + z * stride[1] of a plane, 32 in a word, lowest first. Bits are only set: start from zero.
 * `above` may be NULL when the mode is not iso; `whole`: the brick is BRICK_STATE_WHOLE. Returns the number
 * of active ones. */
uint64_t brick_active_macrocells(const struct brick_grid *grid, const struct brick_active_query *query,
                                 bool whole, enum brick_type type, const void *ranges,
                                 const uint32_t count[3], const uint32_t stride[2], uint32_t *active,
                                 uint32_t *above);

/* What each finer look culls, of one level. */
struct brick_active_summary {
    uint64_t bricks;
    uint64_t bricks_interval;   /* active by range alone */
    uint64_t bricks_active;     /* by range and mask: what brick_active_set returns */
    uint64_t bricks_macrocells; /* of those, with an active macrocell */
    uint64_t macrocells;        /* of all bricks */
    uint64_t macrocells_active;
    uint64_t bytes_read; /* payloads */
};

/* With `macrocells` the payloads of active bricks are read, by `threads` threads (0: one a core); without,
 * nothing is read and the last four are 0. Errors of reading name the brick. */
int brick_active_summarise(const struct brick_volume *volume, const struct brick_active_query *query,
                           bool macrocells, unsigned threads, struct brick_active_summary *summary,
                           struct brick_error *err);

#ifdef __cplusplus
}
#endif
#endif
