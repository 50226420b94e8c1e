/* Rays of a tile through one brick, and what they gather there. */
#ifndef RENDERER_CAST_THROUGH_H
#define RENDERER_CAST_THROUGH_H

#include "frame.h"
#include "way.h"

/* What a ray has gathered. */
struct vr_cast_state {
    float rgb[3], depth; /* mip: rgb[0] is the largest value, depth 1 when there is one */
    bool done;
};

struct vr_cast_rays {
    struct vr_cast_ray ray[VR_CAST_RAYS];
    struct vr_cast_state state[VR_CAST_RAYS];
    struct vr_cast_wait wait[VR_CAST_RAYS];
    float view[3][VR_CAST_RAYS];
};

/* Room for samples on their way. */
struct vr_cast_samples {
    struct vr_cast_queue queue;
    struct vr_cast_seen seen;
    struct vr_cast_packet packet;
    _Alignas(64) float before[VR_CAST_ROOM]; /* optical depth before a sample */
};

/* Rays waiting[0] to waiting[n - 1] as far as their runs in the brick go; lo: the voxel of the level that is
 * its first; *looked grows by the samples looked at. */
void vr_cast_through(struct vr_cast_rays *rays, struct vr_cast_samples *samples,
                     const struct vr_cast_frame *frame, const struct vr_cast_brick *brick,
                     const int64_t lo[3], const uint32_t *waiting, uint32_t n, uint64_t *looked);

#endif
