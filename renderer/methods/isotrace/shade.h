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

/* The ray from a hit to the light, and its span. False when the light's part is known without: the hit faces
 * away, or nothing is in between. */
bool vr_iso_shadow_ray(const struct vr_iso_shading *shading, const struct brick_ray *ray,
                       const struct vr_iso_hit *hit, struct brick_ray *to_light, double *enter_mm,
                       double *leave_mm);

/* Composite a ray's hits front to back to premultiplied RGBA. */
void vr_iso_shade(const struct vr_iso_shading *shading, const struct vr_iso_walk *walk,
                  const struct brick_ray *ray, float rgba[4]);

#endif
