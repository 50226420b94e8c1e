/* Colour spaces in which ParaView interpolates. RGB here is sRGB encoded, [0, 1]. */
#ifndef FORMATS_COLOUR_H
#define FORMATS_COLOUR_H

enum colour_space { COLOUR_RGB, COLOUR_HSV, COLOUR_HSV_WRAP, COLOUR_LAB, COLOUR_DIVERGING, COLOUR_STEP };

/* The colour at t in (0, 1) between two. STEP: the second. HSV_WRAP: the short way round the hue circle.
 * DIVERGING: K. Moreland, "Diverging color maps for scientific visualization", ISVC 2009. Clipped to [0, 1]
 * as VTK does. */
void colour_interpolate(enum colour_space space, const double from[3], const double to[3], double t,
                        double rgb[3]);

/* One component from sRGB to linear (IEC 61966-2-1). */
double colour_decode_srgb(double encoded);

#endif
