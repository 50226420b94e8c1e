/* What a lossy codec changes about ranges and about what neighbouring bricks share. Tolerances in stored
 * values. */
#ifndef BRICK_BUILD_LOSSY_H
#define BRICK_BUILD_LOSSY_H

#include <stdbool.h>
#include <stddef.h>

#include <brick/codec.h>

/* For bricks that a lossy codec cannot encode within its tolerance, or only to more bytes than this one. */
#define LOSSY_FALLBACK BRICK_CODEC_ZSTD_DELTA

/* Ranges [lo, hi] of converted voxels become ranges of what decoding gives: wider by the tolerance, rounded
 * outwards, inside the type. Empty ranges stay. Tolerance 0 changes nothing. */
void lossy_widen(enum brick_type type, void *lo, void *hi, size_t n, double tolerance);
/* The same for one range in stored values as f32. */
void lossy_widen_value(enum brick_type type, float range[2], double tolerance);

/* Are n voxels the same bit for bit, or, with a tolerance above 0, finite and within twice the tolerance
 * (each is within it of one converted voxel)? */
bool lossy_agree(enum brick_type type, const void *a, const void *b, size_t n, double tolerance);

#endif
