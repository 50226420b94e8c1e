/* Integrals of the transfer function over the value, from below it up to where each piece starts, so that a
 * piece of a ray along which the field is linear is integrated exactly whatever lies between its ends
 * (shaders/preintegrated.glsl). */
#ifndef RENDERER_FRAME_PREFIXES_H
#define RENDERER_FRAME_PREFIXES_H

#include "transfer_table.h"

/* S(v): the integral of extinction over the stored value. Four elements of an array of GL_RGBA32UI. */
struct vr_prefix {
    double depth;     /* S */
    double colour[3]; /* integral of colour dS */
    double moment[3]; /* integral of colour S dS */
    double unused;
};

/* One a piece; the first two are zero, as the function has no start. *prefixes is the caller's to free. The
 * integrals are of what the shaders evaluate, the float32 pieces: where they are zero neighbours are equal to
 * the bit. */
int vr_prefixes_create(struct vr_prefix **prefixes, const struct vr_transfer_table *table,
                       struct brick_error *err);

#endif
