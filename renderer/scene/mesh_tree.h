/* The nearest triangle on a ray, in double precision; and a picture's meshes for those who draw on the CPU.
 */
#ifndef RENDERER_SCENE_MESH_TREE_H
#define RENDERER_SCENE_MESH_TREE_H

#include <renderer/renderer.h>

/* Boxes in boxes around a scene's triangles, 160 bytes each. Only read once built, so from any thread. */
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

/* A picture's meshes, which stay the caller's. The tree is kept while the scene's number for them stays. */
struct vr_mesh_view {
    struct vr_mesh_tree *tree;
    uint64_t number; /* of what the tree is of */
    bool any;        /* in this picture */
    struct brick_view world;
    double ambient, diffuse, specular, shininess;
};
int vr_mesh_view_begin(struct vr_mesh_view *view, const struct vr_scene *scene, const struct brick_grid *grid,
                       const struct brick_view *rays, struct brick_error *err);
void vr_mesh_view_finish(struct vr_mesh_view *view);

/* t of the nearest mesh on a pixel's ray, and its colour in the light; INFINITY where there is none. */
double vr_mesh_view_pixel(const struct vr_mesh_view *view, uint32_t column, uint32_t row, double rgb[3]);

#endif
