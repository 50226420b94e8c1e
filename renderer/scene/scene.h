/* What is in a scene beside the volume, checked and put where rays are: clip planes and meshes. For all
 * methods, on the GPU or not. */
#ifndef RENDERER_SCENE_SCENE_H
#define RENDERER_SCENE_SCENE_H

#include <renderer/renderer.h>

/* BRICK_ERR_ARGUMENT for more planes than there may be, planes without a direction, and meshes that are not
 * there or whose colour is no colour. */
int vr_scene_check_parts(const struct vr_scene *scene, struct brick_error *err);

/* Samples of a ray are counted in 32 bits: BRICK_ERR_ARGUMENT for a step that would make more of any. */
int vr_scene_check_step(const struct brick_grid *grid, double step_mm, struct brick_error *err);

/* From a gradient in a level's index space to one in the world but for a positive factor: world component i
 * is the sum of normals[i][a] times component a. The inverse of (affine's linear part x level's scale),
 * transposed, its largest entry made 1. */
void vr_scene_normals(const struct brick_grid *grid, const struct brick_level *level, float normals[3][3]);

/* A clip plane in level-0 index space: it keeps the points p with plane . (p, 1) >= 0. */
void vr_scene_clip_plane(const struct vr_scene *scene, const struct brick_grid *grid, uint32_t index,
                         double plane[4]);
/* The same in a level's index space. */
void vr_scene_level_plane(const struct vr_scene *scene, const struct brick_grid *grid,
                          const struct brick_level *level, uint32_t index, double plane[4]);

/* All of a scene's planes, for rays on the CPU. */
struct vr_clip {
    double plane[VR_MAX_CLIP_PLANES][4]; /* vr_scene_clip_plane */
    uint32_t count;
};
void vr_scene_clip(const struct vr_scene *scene, const struct brick_grid *grid, struct vr_clip *clip);
/* Cut a ray's span where the planes do. False when nothing is left. */
bool vr_clip_span(const struct vr_clip *clip, const struct brick_ray *ray, double *t_enter_mm,
                  double *t_leave_mm);

/* The same rays in the world: origins in mm, `linear` the identity; t is the same. */
void vr_scene_world_view(const struct brick_view *view, const struct brick_grid *grid,
                         struct brick_view *world);

#endif
