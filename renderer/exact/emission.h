/* Emission and absorption over one piece of a ray, on which extinction and colour are cubics. */
#ifndef RENDERER_EXACT_EMISSION_H
#define RENDERER_EXACT_EMISSION_H

#include <stdint.h>

#include "cubic.h"

/* Blinn-Phong shading along a segment as shaders/shading.glsl has it: light and eye in one place, two-sided;
 * where the gradient is zero only the ambient part is left. */
struct vr_light {
    struct vr_cubic normal[3]; /* the gradient in world axes, of any scale */
    struct vr_cubic facing;    /* its product with the unit view direction; changes sign in no piece */
    double ambient, diffuse, specular, shininess;
};

struct vr_light vr_light_part(const struct vr_light *light, double a, double b);
/* The shaded colour of `rgb` at s. */
void vr_light_shade(const struct vr_light *light, double s, const double rgb[3], double shaded[3]);

/* What a ray has gathered, front to back. */
struct vr_ray_integral {
    double depth;         /* optical depth so far: transmittance is exp(-depth) */
    double rgb[3];        /* emission so far, premultiplied */
    uint64_t evaluations; /* of the emission's integrand */
    double length_mm;     /* of the whole ray, for its errors to be shared out */
};

struct vr_piece {
    struct vr_cubic sigma;        /* extinction times the piece's length; not below zero but for rounding */
    struct vr_cubic rgb[3];       /* colour before light */
    const struct vr_light *light; /* of this piece; NULL: unlit */
    double length_mm;
    double glow; /* colour is emitted so many times over the piece, evenly; 0: times extinction */
};

/* tolerance: the emission's error over the whole ray, absolute, per channel, however many pieces it has. */
void vr_ray_add_piece(struct vr_ray_integral *ray, const struct vr_piece *piece, double tolerance);

#endif
