/* What the tests of volume formats with a header in text share: twelve voxels, and files that hold them. */
#ifndef TESTS_HEADER_FILES_H
#define TESTS_HEADER_FILES_H

#include "format_files.h"

static const uint64_t dims[3] = {3, 2, 2};
static const int16_t voxels[12] = {0, -1, 255, 256, 32767, -32768, 7, 8, 9, 10, 11, 0x1234};

/* The voxels, big end first. */
static inline const void *swapped(void)
{
    static unsigned char big[sizeof voxels];
    for (size_t i = 0; i < sizeof big; i++)
        big[i] = ((const unsigned char *)voxels)[i ^ 1];
    return big;
}

static inline void expect_all(const char *path)
{
    expect_voxels(path, NULL, dims, BRICK_I16, voxels);
}

#define FORMAT BRICK_ERR_FORMAT
struct bad_header {
    const char *header;
    int code;
    const char *says;
};

#endif
