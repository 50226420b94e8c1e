/* Source voxels to stored voxels. */
#ifndef BRICK_BUILD_CONVERT_H
#define BRICK_BUILD_CONVERT_H

#include <stdbool.h>

#include <brick/error.h>
#include <brick/type.h>

/* The type in which a source's voxels are stored: its own, or f32 for u32, i32, f64. */
enum brick_type convert_stored_type(enum brick_type source);

/* n voxels of u32, i32 or f64 to f32. Without `round`, the first value that f32 cannot hold exactly is
 * BRICK_ERR_INEXACT; first_voxel is the number of the first one, for the message. NaN and Inf are kept.
 * Overflow to Inf is never exact. */
int convert_to_f32(enum brick_type source, const void *src, float *dst, size_t n, bool round,
                   uint64_t first_voxel, struct brick_error *err);

#endif
