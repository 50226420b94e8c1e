/* Light on a hit. */
#ifndef RENDERER_ISOTRACE_SHADE_H
#define RENDERER_ISOTRACE_SHADE_H

#include <brick/camera.h>
#include <renderer/renderer.h>

#include "walk.h"

/* The picture's lights and materials. */
struct vr_iso_shading {
    const struct brick_grid *grid;
    double normal[3][3]; /* gradient in the level's index space -> world: inverse transpose */
    double linear[3][3]; /* index0 steps -> mm */
    double ambient, diffuse, specular, shininess;
    double rgb[VR_ISO_MAX_SURFACES][3];
    bool headlight, shadows;
    double light[3];           /* towards it, unit, world; not for the headlight */
    double light_direction[3]; /* the same in index0 steps per mm */
    double shadow_start_mm;    /* a shadow ray's distance from its hit, where it begins */
};

void vr_iso_shading_init(struct vr_iso_shading *shading, const struct brick_grid *grid,
                         const struct vr_scene *scene, const struct vr_isotrace_params *params);

/* A surface's normal in the world, of any length, from its gradient; 0: it has none. */
void vr_iso_normal(const struct vr_iso_shading *shading, const double gradient[3], double normal[3]);

/* A point on a ray, with its normal, to be lit. */
struct vr_iso_point {
    const struct brick_ray *ray;
    double t;
    double normal[3]; /* world */
};

/* Where light can come from for the point: from its shadow's start on, in the world. False when it faces
 * away.
 */
bool vr_iso_to_light(const struct vr_iso_shading *shading, const struct vr_iso_point *point,
                     struct brick_ray *world);

/* The ray from the point to the light, and its span. False when nothing of the volume is in between. */
bool vr_iso_shadow_ray(const struct vr_iso_shading *shading, const struct vr_iso_point *point,
                       struct brick_ray *to_light, double *enter_mm, double *leave_mm);

/* Put what is opaque at the point behind premultiplied RGBA. light: what of the light's reaches it. */
void vr_iso_shade_opaque(const struct vr_iso_shading *shading, const struct vr_iso_point *point,
                         const double rgb[3], double light, float rgba[4]);

/* Composite a ray's hits front to back to premultiplied RGBA. */
void vr_iso_shade(const struct vr_iso_shading *shading, const struct vr_iso_walk *walk,
                  const struct brick_ray *ray, float rgba[4]);

#endif
