/* A tile of a picture. */
#ifndef RENDERER_ISOTRACE_TILE_H
#define RENDERER_ISOTRACE_TILE_H

#include <brick/image.h>

#include "bounds.h"
#include "mesh_tree.h"
#include "pins.h"
#include "scene.h"
#include "shade.h"

enum {
    VR_ISO_TILE_WIDTH = 16,
    VR_ISO_TILE_HEIGHT = 8,
    VR_ISO_TILE_PIXELS = VR_ISO_TILE_WIDTH * VR_ISO_TILE_HEIGHT
};
_Static_assert((int)VR_ISO_TILE_PIXELS <= (int)VR_ISO_RAYS, "a tile is traced in one go");

/* What is the same for all tiles. */
struct vr_iso_picture {
    struct vr_iso_frame frame;
    struct vr_iso_shading shading;
    struct brick_view view;
    struct vr_clip clip;
    const struct vr_iso_bounds *bounds;
    const struct vr_mesh_view *meshes;
    struct brick_image *image;
    uint32_t tiles_x, tiles;
};

/* A pixel whose ray meets a mesh. */
struct vr_iso_mesh_pixel {
    struct brick_ray ray;
    struct vr_iso_point point;
    double rgb[3], light;
    float *rgba;
};

/* A thread's room for a tile. */
struct vr_iso_worker {
    struct vr_iso_activity activity;
    struct vr_iso_pin pin;
    struct vr_iso_walk walk[VR_ISO_TILE_PIXELS], shadow[VR_ISO_TILE_PIXELS];
    struct brick_ray ray[VR_ISO_TILE_PIXELS];
    struct vr_iso_mesh_pixel mesh[VR_ISO_TILE_PIXELS];
    size_t meshes; /* pixels that have one */
};

int vr_iso_tile_draw(const struct vr_iso_picture *picture, struct vr_iso_worker *worker, uint32_t tile,
                     struct brick_error *err);

#endif
