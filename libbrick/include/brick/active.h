/* The active set: which bricks of a level a picture can need. From the index alone, no I/O. */
#ifndef BRICK_ACTIVE_H
#define BRICK_ACTIVE_H

#include <stdint.h>

#include <brick/transfer.h>
#include <brick/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

enum brick_mode { BRICK_MODE_DVR, BRICK_MODE_SHADED, BRICK_MODE_ISO, BRICK_MODE_MIP };

/* State of a brick for one picture. For iso an inactive brick says on which side of the isovalue it lies. */
enum brick_state {
    BRICK_STATE_EMPTY = 0, /* below the isovalue, or nothing visible */
    BRICK_STATE_ABOVE = 1, /* iso: wholly at or above the isovalue */
    BRICK_STATE_ACTIVE = 2
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

/* states: one byte a brick of the level, x fastest. Returns the number of active ones. */
uint64_t brick_active_set(const struct brick_volume *volume, const struct brick_active_query *query,
                          uint8_t *states);

#ifdef __cplusplus
}
#endif
#endif
