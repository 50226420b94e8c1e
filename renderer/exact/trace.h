/* One ray, in any mode. */
#ifndef RENDERER_EXACT_TRACE_H
#define RENDERER_EXACT_TRACE_H

#include <renderer/renderer.h>

#include "march.h"
#include "ray.h"

/* What all rays of a picture share. */
struct vr_look {
    enum brick_mode mode;
    enum vr_field field;                   /* dvr and shaded: all; iso and mip: not preclassified */
    const struct brick_transfer *transfer; /* dvr, shaded, mip */
    double tolerance;                      /* dvr, shaded: absolute, per channel */
    double isovalue, surface[3];           /* iso */
    double normal[3][3];                   /* gradient in the level's index space -> world, of any scale */
    double linear[3][3];                   /* level-0 index steps -> mm */
    double ambient, diffuse, specular, shininess;
};

struct vr_traced {
    struct vr_ray_integral light; /* depth is infinite at an isosurface */
    double hit_mm;                /* iso: t of the hit, infinite when there is none */
};

/* From t_enter_mm to t_leave_mm (inside brick_ray_span). */
int vr_trace(const struct vr_look *look, struct vr_cells *cells, const struct brick_ray *ray,
             double t_enter_mm, double t_leave_mm, struct vr_traced *traced, struct brick_error *err);

#endif
