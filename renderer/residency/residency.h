/* Which bricks are where: the active set of a picture brought into the atlas, nearest the eye first, and the
 * page table and macrocell bits that tell the shaders. Bricks stay for later pictures. */
#ifndef RENDERER_RESIDENCY_RESIDENCY_H
#define RENDERER_RESIDENCY_RESIDENCY_H

#include <brick/active.h>
#include <brick/camera.h>
#include <brick/threads.h>

#include "atlas.h"
#include "buffer.h"
#include "macrocells.h"

struct vr_residency;

struct vr_residency_counters {
    uint64_t bricks_total, bricks_active, bricks_loaded; /* of the level, for the last picture */
    uint64_t bytes_read;
    uint64_t cache_bytes, cache_peak_bytes;
};

/* The context is bound in all of these; context, volume and pool outlive the residency. */
int vr_residency_create(struct vr_residency **residency, struct vr_context *context,
                        const struct brick_volume *volume, uint64_t budget_bytes, struct brick_pool *pool,
                        struct brick_error *err);
void vr_residency_destroy(struct vr_residency **residency);

/* Everything a picture needs, resident. BRICK_ERR_MEMORY with the size that would do when it does not fit;
 * errors of reading bricks as they are. After an error the residency is as usable as before. */
int vr_residency_update(struct vr_residency *residency, const struct brick_active_query *query,
                        const struct brick_camera *camera, struct vr_residency_counters *counters,
                        struct brick_error *err);

const struct vr_atlas *vr_residency_atlas(const struct vr_residency *residency);
const struct vr_macrocells *vr_residency_macrocells(const struct vr_residency *residency);
const struct vr_buffer *vr_residency_pages(const struct vr_residency *residency);

#endif
