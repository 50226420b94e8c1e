/* A volume in memory as a source, and files made of it: what most tests begin with. */
#ifndef TESTS_MEMORY_SOURCE_H
#define TESTS_MEMORY_SOURCE_H

#include <brick/build.h>
#include <brick/source.h>

struct memory_source {
    struct brick_source base;
    const void *voxels;
};

/* It can read boxes: base.read_box = NULL takes that away. Spacing 1 mm, identity affine, slope 1, intercept
 * 0; change base.geometry afterwards at will. voxels stay the caller's. */
void memory_source_init(struct memory_source *source, enum brick_type type, uint64_t nx, uint64_t ny,
                        uint64_t nz, const void *voxels);

/* A path in the test's own temporary folder, removed at exit; a few buffers in turn. */
const char *test_path(const char *name);

/* Build and open; asserts success. params may be NULL for the defaults. */
struct brick_volume *build_and_open(struct memory_source *source, const char *name,
                                    const struct brick_build_params *params);

/* NULL when there is none; to free(), with a byte to spare. */
void *read_file(const char *path, size_t *bytes);
void write_file(const char *path, const void *data, size_t bytes);

static inline void store_voxel(enum brick_type type, void *voxels, size_t i, double v)
{
    brick_type_store(type, voxels, i, v);
}

/* Uniform 64-bit noise of a counter (splitmix64). */
uint64_t noise64(uint64_t seed, uint64_t i);

#endif
