/* The order in which rays meet bricks. */
#ifndef RENDERER_RESIDENCY_DEPTH_H
#define RENDERER_RESIDENCY_DEPTH_H

#include <stdbool.h>

#include <brick/camera.h>
#include <brick/grid.h>

struct vr_depth {
    double eye[3]; /* in bricks of the level; or the direction of parallel rays */
    bool parallel;
    uint64_t bricks[2]; /* of the level, on x and y */
};

void vr_depth_init(struct vr_depth *depth, const struct brick_grid *grid, uint32_t level,
                   const struct brick_camera *camera);
/* Depth of brick b of the level, x fastest: along every ray of the camera it ascends from brick to brick. */
double vr_depth_of(const struct vr_depth *depth, uint64_t b);

#endif
