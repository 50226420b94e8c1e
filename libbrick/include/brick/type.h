/* Voxel types. "Stored" types can be in a .brick file; the others are read from sources and become f32. */
#ifndef BRICK_TYPE_H
#define BRICK_TYPE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum brick_type {
    BRICK_U8 = 0,
    BRICK_I8 = 1,
    BRICK_U16 = 2,
    BRICK_I16 = 3,
    BRICK_F32 = 4,
    BRICK_TYPE_STORED_COUNT = 5,
    BRICK_U32 = 5,
    BRICK_I32 = 6,
    BRICK_F64 = 7,
    BRICK_TYPE_COUNT = 8
};

/* Bytes of one voxel; 0 for a value that is no type. */
size_t brick_type_bytes(enum brick_type type);
/* "u8", "i16", "f32", ...; NULL for a value that is no type. */
const char *brick_type_name(enum brick_type type);
/* The type of that name, or BRICK_TYPE_COUNT. */
enum brick_type brick_type_from_name(const char *name);
bool brick_type_is_integer(enum brick_type type);
/* Value of voxel i of an array of a stored or source type, as double (exact for all of them). */
double brick_type_load(enum brick_type type, const void *voxels, size_t i);
/* voxels[i] = v, which a voxel of this stored type can be. */
void brick_type_store(enum brick_type type, void *voxels, size_t i, double v);
/* Reverse the bytes of n voxels in place. */
void brick_type_swap_bytes(enum brick_type type, void *voxels, size_t n);

#ifdef __cplusplus
}
#endif
#endif
