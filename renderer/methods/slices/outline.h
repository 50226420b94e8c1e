/* The part of a box that lies between two planes of one depth each, as seen in the picture: a convex polygon.
 * With both at one depth it is the intersection of a plane with the box. */
#ifndef RENDERER_METHODS_SLICES_OUTLINE_H
#define RENDERER_METHODS_SLICES_OUTLINE_H

#include <stdbool.h>

/* Corner i of a box, x fastest: its depth along the view, and its place in the picture in pixels, which in
 * perspective is times the depth, so that all three are linear in the corner. */
struct vr_corner {
    double depth, x, y;
};

/* x and y in pixels, low and high. */
struct vr_window {
    double low[2], high[2];
};

#define VR_OUTLINE_MAX 36 /* 8 corners, 12 edges cut twice, 4 sides of the window */

/* The polygon's vertices in order; returns how many, 0 when nothing of the box is between near and far and in
 * the window. near <= far; in perspective near is above 0. */
int vr_outline(const struct vr_corner corners[8], bool perspective, double near, double far,
               const struct vr_window *window, double polygon[VR_OUTLINE_MAX][2]);

#endif
