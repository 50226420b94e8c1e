/* The atlas: the GPU cache texture, an array of 2D layers in which equal slots are boxes, each room for one
 * stored brick of any level. Layers and not a 3D texture, since shaders can gather four texels of a layer at
 * once, as they are. */
#ifndef RENDERER_RESIDENCY_ATLAS_H
#define RENDERER_RESIDENCY_ATLAS_H

#include <brick/grid.h>
#include <renderer/renderer.h>

#include "context.h"

/* A texture takes no more than this, whatever the budget: what drivers still allocate in one piece. */
#define VR_ATLAS_MAX_BYTES (UINT64_C(1700) << 20)
/* Page table entries hold a slot's place in 8 bits an axis. */
#define VR_ATLAS_MAX_SLOTS 255

/* How voxels lie in the texture. Integers that are to be filtered are normalised, 16 bits each: as 8 bits
 * some samplers (llvmpipe) interpolate them in 8 bits. */
struct vr_atlas_voxels {
    GLenum internal, format, type;
    size_t bytes;
    double scale, offset; /* normalised: stored value = texel * scale - offset; else scale is 0 */
    double grains; /* normalised: a stored unit; one is above twice what interpolation in float32 may round */
};

struct vr_atlas {
    GLuint texture;
    enum vr_filter filter;
    enum brick_type stored; /* of the volume */
    struct vr_atlas_voxels voxels;
    int size[3];      /* texels; of layers powers of two where the sampler filters */
    int slot_size[3]; /* voxels: a stored brick of level 0, the largest */
    int slots[3];
    uint32_t count; /* slots[0] * slots[1] * slots[2] */
    uint64_t slot_bytes, bytes;
};

/* Arrange at least `want` slots in as little as possible, or, when that is above `most`, as many as `most`
 * allows. False when not one slot fits. limit: slots that fit the texture on each axis. */
bool vr_atlas_arrange(uint64_t want, uint64_t most, const int limit[3], int slots[3]);
/* The same for layers whose edges are powers of two, up to limit[0] x limit[1] texels; limit[2] slots are the
 * most in depth. `texels` are allowed in all. size: of a layer. */
bool vr_atlas_arrange_powers(uint64_t want, uint64_t texels, const int slot_size[3], const int limit[3],
                             int size[2], int slots[3]);

/* Slots for every brick of level 0, or as many as budget_bytes holds. BRICK_ERR_MEMORY when that is not one.
 * The context is bound. */
int vr_atlas_init(struct vr_atlas *atlas, struct vr_context *context, const struct brick_grid *grid,
                  enum vr_filter filter, uint64_t budget_bytes, struct brick_error *err);
void vr_atlas_finish(struct vr_atlas *atlas, struct vr_context *context);

/* Make it the texture of a unit; an upload undoes that. */
void vr_atlas_use(const struct vr_atlas *atlas, struct vr_context *context, GLuint unit);
void vr_atlas_slot_place(const struct vr_atlas *atlas, uint32_t slot, uint32_t at[3]);
/* Voxels as stored to what is uploaded of them, count * voxels.bytes. */
void vr_atlas_convert(const struct vr_atlas *atlas, const void *stored, size_t count, void *out);
/* stored: the brick's voxels on each axis, at most slot_size; they begin, converted, at a byte of the pixel
 * buffer that is bound. */
void vr_atlas_upload(const struct vr_atlas *atlas, struct vr_context *context, uint32_t slot,
                     const uint32_t stored[3], size_t at_byte);

#endif
