/* Differences of neighbours, folded so that small ones of either sign have zero upper bytes. */
#ifndef BRICK_CODEC_DELTA_H
#define BRICK_CODEC_DELTA_H

#include <stddef.h>

/* n elements of width 1, 2 or 4 bytes. Reversible for every input: arithmetic wraps around. */
void delta_encode(size_t width, const void *src, void *dst, size_t n);
void delta_decode(size_t width, void *elements, size_t n);

#endif
