/* The nearest triangle on a ray, in double precision. */
#ifndef RENDERER_EXACT_MESHES_H
#define RENDERER_EXACT_MESHES_H

#include <renderer/renderer.h>

/* Boxes in boxes around a scene's triangles. Only read once built, so from any thread. */
struct vr_mesh_tree;

/* The meshes stay the caller's and live as long. */
int vr_mesh_tree_create(struct vr_mesh_tree **tree, const struct vr_mesh *meshes, uint32_t count,
                        struct brick_error *err);
void vr_mesh_tree_destroy(struct vr_mesh_tree **tree);

struct vr_mesh_hit {
    double t_mm;
    double normal[3]; /* towards either side, of any length but 0 */
    double rgb[3];    /* before light */
};

/* ray: in the world. False when it meets none at t >= 0. Triangles that share an edge leave no gap between
 * them; a ray in a triangle's plane passes it. */
bool vr_mesh_tree_first(const struct vr_mesh_tree *tree, const struct brick_ray *ray,
                        struct vr_mesh_hit *hit);

#endif
