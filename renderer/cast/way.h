/* A ray's way through the bricks of the level. */
#ifndef RENDERER_CAST_WAY_H
#define RENDERER_CAST_WAY_H

#include "frame.h"

/* Where a ray waits: `run` samples from k on lie in the brick. */
struct vr_cast_wait {
    uint64_t brick; /* of the level */
    uint32_t k, run;
    int64_t place[3]; /* a voxel before them, which 8.56 positions count from */
};

/* On from sample k to the next in an active brick; false when there is none. */
bool vr_cast_go_on(const struct vr_cast_frame *frame, const struct vr_cast_ray *ray,
                   struct vr_cast_wait *wait);

#endif
