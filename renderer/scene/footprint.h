/* Where in a picture active bricks can be seen. */
#ifndef RENDERER_SCENE_FOOTPRINT_H
#define RENDERER_SCENE_FOOTPRINT_H

#include <stdint.h>

#include <brick/camera.h>
#include <brick/grid.h>

/* A part of a picture in square tiles of `edge` pixels. */
struct vr_tiles {
    int x, y, width, height; /* pixels of the picture */
    int edge, across;        /* flags a row; flags[0] is the tile at x, y */
};

/* Set to 1 the flag of every tile that a ray through an active brick can have its pixel in, and perhaps some
 * more; the others to 0. states: a byte a brick of the level (brick/active.h), x fastest. */
void vr_footprint(const struct brick_view *view, const struct brick_grid *grid, uint32_t level,
                  const uint8_t *states, const struct vr_tiles *tiles, uint32_t *flags);

#endif
