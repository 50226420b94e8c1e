/* A tile of a picture: its rays, and their way through the bricks. */
#ifndef RENDERER_CAST_TILE_H
#define RENDERER_CAST_TILE_H

#include "frame.h"

/* A thread's room for a tile. */
struct vr_cast_tile;
struct vr_cast_tile *vr_cast_tile_create(const struct vr_cast_activity *activity);
void vr_cast_tile_destroy(struct vr_cast_tile *tile);

/* Draw the tile whose first pixel is (x, y); shows: the volume may be seen in it. *samples grows by those
 * looked at. */
int vr_cast_tile_draw(struct vr_cast_tile *tile, const struct vr_cast_frame *frame, uint32_t x, uint32_t y,
                      bool shows, uint64_t *samples, struct brick_error *err);

#endif
