/* Which bricks are where: bricks that rays ask for brought into the atlas, nearest the eye first, and the
 * page table and macrocell bits that tell the shaders. Bricks stay for later passes and pictures until
 * others need their slots. */
#ifndef RENDERER_RESIDENCY_RESIDENCY_H
#define RENDERER_RESIDENCY_RESIDENCY_H

#include <brick/active.h>
#include <brick/camera.h>
#include <brick/loader.h>
#include <brick/threads.h>

#include "atlas.h"
#include "feedback.h"
#include "macrocells.h"

struct vr_residency;

/* All since vr_residency_begin but for the cache's size and peak. */
struct vr_residency_counters {
    uint64_t bricks_total, bricks_active; /* of the level */
    uint64_t bricks_loaded;               /* into the atlas, a brick that came twice counted twice */
    uint64_t bricks_read, bytes_read;     /* from the file, payloads as stored */
    uint64_t cache_bytes, cache_peak_bytes;
    uint64_t host_cache_peak_bytes;
};

/* The context is bound in all of these; context, volume and pool outlive the residency. */
int vr_residency_create(struct vr_residency **residency, struct vr_context *context,
                        const struct brick_volume *volume, const struct vr_renderer_params *params,
                        struct brick_pool *pool, struct brick_error *err);
void vr_residency_destroy(struct vr_residency **residency);

/* What slots hold from the next picture on: NULL for voxels, or what a method makes of them, which lives
 * until this is called again. Where it is another than before, slots are emptied; bricks stay in the host's
 * cache. BRICK_ERR_MEMORY when the budget does not hold one brick so; slots then hold voxels. */
int vr_residency_set_texels(struct vr_residency *residency, const struct vr_texels *texels,
                            struct brick_error *err);
/* Begin a picture: page table and macrocell bits say what of its active bricks is resident. Reads nothing. */
int vr_residency_begin(struct vr_residency *residency, const struct brick_active_query *query,
                       const struct brick_camera *camera, struct brick_error *err);
/* How much may be brought at once. */
struct vr_residency_limit {
    uint64_t bricks;      /* 1 at least */
    uint64_t deadline_ns; /* of brick_now_ns; the brick that comes first is brought even so */
};

/* After a pass: bring what its rays want, the nearest first, as far as there are slots. *wanted: how many
 * distinct bricks were asked for. If a ray waits for a brick, then of those that are waited for the nearest
 * is resident afterwards, or, with a deadline, after as many calls as it takes. Errors of reading bricks as
 * they are; the residency is then as usable as before. A brick in which nothing is visible may be asked for
 * too, and counts as active until the classification changes. */
int vr_residency_bring(struct vr_residency *residency, const struct vr_feedback *feedback,
                       const struct vr_residency_limit *limit, uint64_t *wanted, struct brick_error *err);
/* From here to the next vr_residency_hold, or the next picture of another level or classification, pages of
 * missing bricks name coarser ones that stand in for them, where a share of the slots has room for such; they
 * are read now, if need be. */
int vr_residency_stand_in(struct vr_residency *residency, struct brick_error *err);

/* Ask for all bricks that touch one in which something is visible. Before vr_residency_order. */
int vr_residency_touching(struct vr_residency *residency, struct brick_error *err);
/* For methods that draw bricks one after the other, in batches: the picture's active bricks in the order in
 * which rays meet them, or the other way round. *bricks, of *count, is the residency's, and stands until the
 * next picture begins. */
int vr_residency_order(struct vr_residency *residency, bool far_first, const uint32_t **bricks, size_t *count,
                       struct brick_error *err);
/* Make bricks[0..n) resident, n at most the atlas's slots; bricks are a run of vr_residency_order's list, and
 * runs come in the list's order. */
int vr_residency_hold(struct vr_residency *residency, const uint32_t *bricks, size_t n, bool far_first,
                      struct brick_error *err);
/* The slot of a brick of the level, UINT32_MAX when it is not resident. */
uint32_t vr_residency_slot(const struct vr_residency *residency, uint32_t brick);

/* A byte a brick of the level (brick/active.h), x fastest, for the picture. */
const uint8_t *vr_residency_states(const struct vr_residency *residency);

void vr_residency_count(const struct vr_residency *residency, struct vr_residency_counters *counters);
const struct vr_atlas *vr_residency_atlas(const struct vr_residency *residency);
/* Of voxels; colours in their place are not filtered by the texture unit, whatever this says. */
enum vr_filter vr_residency_filter(const struct vr_residency *residency);
const struct vr_macrocells *vr_residency_macrocells(const struct vr_residency *residency);
const struct vr_buffer *vr_residency_pages(const struct vr_residency *residency);

#endif
