/* How far bricks are from those that matter. */
#ifndef RENDERER_CAST_AWAY_H
#define RENDERER_CAST_AWAY_H

#include <stdint.h>

/* away: one a brick, x fastest, 0 where it matters and 255 elsewhere, and room for bricks[0] + 2 more.
 * Becomes the distance, in bricks along the axis it is largest on, to the nearest that matters; 255: that or
 * more. */
void vr_cast_find_away(uint8_t *away, const uint64_t bricks[3]);

#endif
