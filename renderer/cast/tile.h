/* A tile of a picture: its rays, and their way through the bricks. */
#ifndef RENDERER_CAST_TILE_H
#define RENDERER_CAST_TILE_H

#include <brick/cache.h>
#include <brick/image.h>

#include "activity.h"
#include "kernels.h"
#include "ray.h"

enum { VR_CAST_TILE = 16, VR_CAST_RAYS = VR_CAST_TILE * VR_CAST_TILE };
_Static_assert((int)VR_CAST_RAYS <= (int)VR_CAST_ROOM, "a tile's rays are coloured in one go");

/* What is the same for all tiles of a picture. */
struct vr_cast_frame {
    struct vr_cast_set set;
    const struct vr_scene *scene;
    const struct vr_cast_kernels *kernels;
    struct vr_transfer_table table;
    struct vr_cast_pieces pieces; /* of the table */
    struct vr_cast_field field;
    struct vr_cast_light light; /* but for view */
    struct vr_cast_activity *activity;
    struct brick_cache *cache;
    float unit_mm;   /* mip: length that a control point's opacity belongs to */
    float depth_end; /* optical depth at which a ray ends */
    struct brick_image *image;
};

/* A thread's room for a tile. */
struct vr_cast_tile;
struct vr_cast_tile *vr_cast_tile_create(const struct vr_cast_activity *activity);
void vr_cast_tile_destroy(struct vr_cast_tile *tile);

/* Of the tile whose first pixel is (x, y): empty it, */
void vr_cast_tile_clear(const struct vr_cast_frame *frame, uint32_t x, uint32_t y);
/* or draw it; *samples grows by those looked at. */
int vr_cast_tile_draw(struct vr_cast_tile *tile, const struct vr_cast_frame *frame, uint32_t x, uint32_t y,
                      uint64_t *samples, struct brick_error *err);

#endif
