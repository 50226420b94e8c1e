/* Voxel i of a halved axis averages 2i and 2i+1 of the stored level above, clamped at the end, so an axis
 * that ends on an odd voxel counts it twice; eight values are averaged whichever axes are halved (a repeated
 * value changes no mean). The ranges of level 0 travel along: the smallest and largest value below each
 * coarse voxel. */
#include "downsample.h"

#include <string.h>

enum { PAIRS = 64 };

/* Four rows in which every one of n voxels is its own partner. */
static void pair_with_itself(const void *const rows[4], size_t width, size_t n,
                             unsigned char pairs[4][2 * PAIRS * 4], const void *out[4])
{
    for (int r = 0; r < 4; r++) {
        const unsigned char *row = (const unsigned char *)rows[r];
        for (size_t i = 0; i < n; i++) {
            memcpy(pairs[r] + 2 * i * width, row + i * width, width);
            memcpy(pairs[r] + (2 * i + 1) * width, row + i * width, width);
        }
        out[r] = pairs[r];
    }
}

static void advance(const void *rows[4], size_t bytes)
{
    for (int r = 0; r < 4; r++)
        rows[r] = (const unsigned char *)rows[r] + bytes;
}

void downsample_row(const struct kernels *k, const struct window *fine, const struct window *coarse,
                    const bool halved[3], enum brick_type type, bool nearest, uint64_t x, uint64_t left,
                    uint64_t y, uint64_t z)
{
    size_t width = brick_type_bytes(type);
    const uint64_t *n = fine->level->dims, at[3] = {x, y, z};
    uint64_t first[3], second[3];
    for (int a = 0; a < 3; a++) {
        first[a] = halved[a] ? 2 * at[a] : at[a];
        second[a] = halved[a] && first[a] + 1 < n[a] ? first[a] + 1 : first[a];
    }
    const void *rows[3][4]; /* voxels, min, max of the coarse row's first voxel */
    const unsigned char *arrays[3] = {fine->voxels, fine->min, fine->max};
    for (int i = 0; i < 3; i++)
        for (int r = 0; r < 4; r++)
            rows[i][r] = arrays[i] + window_at(fine, first[0], r & 1 ? second[1] : first[1],
                                               r & 2 ? second[2] : first[2]);
    size_t to = window_at(coarse, x, y, z);
    unsigned char *out = coarse->voxels + to, *min = coarse->min + to, *max = coarse->max + to;
    if (nearest)
        for (uint64_t i = 0; i < left; i++)
            memcpy(out + i * width, (const unsigned char *)rows[0][0] + (halved[0] ? 2 * i : i) * width,
                   width);
    if (halved[0]) {
        uint64_t whole = (n[0] - first[0]) / 2;
        if (whole > left)
            whole = left;
        if (!nearest)
            k->mean_pairs[type](out, rows[0], whole);
        k->range_pairs[type](min, max, rows[1], rows[2], whole);
        left -= whole;
        out += whole * width;
        min += whole * width;
        max += whole * width;
        for (int i = 0; i < 3; i++)
            advance(rows[i], 2 * whole * width);
    }
    while (left) {
        size_t some = left < PAIRS ? (size_t)left : PAIRS;
        unsigned char pairs[3][4][2 * PAIRS * 4];
        const void *paired[3][4];
        for (int i = 0; i < 3; i++)
            pair_with_itself(rows[i], width, some, pairs[i], paired[i]);
        if (!nearest)
            k->mean_pairs[type](out, paired[0], some);
        k->range_pairs[type](min, max, paired[1], paired[2], some);
        left -= some;
        out += some * width;
        min += some * width;
        max += some * width;
        for (int i = 0; i < 3; i++)
            advance(rows[i], some * width);
    }
}
