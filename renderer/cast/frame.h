/* What is the same for all tiles of a picture. */
#ifndef RENDERER_CAST_FRAME_H
#define RENDERER_CAST_FRAME_H

#include <brick/cache.h>
#include <brick/image.h>

#include "activity.h"
#include "kernels.h"
#include "mesh_tree.h"
#include "ray.h"

enum { VR_CAST_TILE = 16, VR_CAST_RAYS = VR_CAST_TILE * VR_CAST_TILE };
_Static_assert((int)VR_CAST_RAYS <= (int)VR_CAST_ROOM, "a tile's rays are coloured in one go");
_Static_assert((int)VR_CAST_RAYS <= (int)VR_CAST_PACKET, "a tile's rays are one packet");

struct vr_cast_frame {
    struct vr_cast_set set;
    const struct vr_scene *scene;
    const struct vr_cast_kernels *kernels;
    struct vr_transfer_table table;
    struct vr_cast_pieces pieces; /* of the table */
    struct vr_cast_field field;
    struct vr_cast_light light; /* but for view */
    const struct vr_mesh_view *meshes;
    struct vr_cast_activity *activity;
    struct brick_cache *cache;
    float unit_mm;   /* mip: length that a control point's opacity belongs to */
    float depth_end; /* optical depth at which a ray ends */
    struct brick_image *image;
};

#endif
