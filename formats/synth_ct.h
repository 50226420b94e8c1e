/* The body phantom as a list of parts, painted one over the other. synth_ct_body.c lists them in body
 * coordinates
 * ([-1, 1] on each axis, the ends being the volume's faces; +x left, +y posterior, +z superior); synth_ct.c
 * holds them in voxels and paints. */
#ifndef FORMATS_SYNTH_CT_H
#define FORMATS_SYNTH_CT_H

#include "synth.h"

enum ct_kind {
    CT_ELLIPSOID, /* solid */
    CT_SHELL,     /* the surface of an ellipsoid, of some thickness, cut by planes */
    CT_CAPSULE    /* all within a radius of a line segment */
};

struct ct_plane {
    double normal[3], offset; /* kept where normal . p + offset > 0, normal of length 1 */
};

/* A part in body coordinates. */
struct ct_part {
    enum ct_kind kind;
    double hu;
    double a[3];              /* ellipsoid, shell: centre. capsule: one end */
    double b[3];              /* ellipsoid, shell: semi-axes. capsule: the other end */
    double thickness;         /* shell: wall; capsule: radius */
    struct ct_plane plane[2]; /* shell */
};

#define CT_AIR (-1000.0)

struct ct_part_list {
    unsigned count;
    struct ct_part part[SYNTH_MAX_PARTS];
};

/* Fill the list in painting order: the same for every volume. */
void synth_ct_body(struct ct_part_list *list);

#endif
