/* The field inside a cell, along a ray: where it is which polynomial. */
#ifndef RENDERER_EXACT_FIELD_H
#define RENDERER_EXACT_FIELD_H

#include <renderer/renderer.h>

#include "cubic.h"
#include "march.h"

/* Part of a step, from a to b of its [0,1]. */
struct vr_segment {
    double a, b;
    struct vr_cubic f; /* with its own parameter in [0,1] */
    double from, to; /* f at its ends: a corner's value at that corner, and never outside the corners' hull */
};

/* Cuts that four planes can make. */
#define VR_MAX_SEGMENTS 5

/* The trilinear field or the one on tetrahedra; a present step. Returns how many segments. */
int vr_field_segments(enum vr_field field, const struct vr_cells *cells, const struct vr_step *step,
                      struct vr_segment segments[VR_MAX_SEGMENTS]);

/* The trilinear field at a point of a cell, as exact as `from` above. */
double vr_field_trilinear(const double corners[8], const double at[3]);

#endif
