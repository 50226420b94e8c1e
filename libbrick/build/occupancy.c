/* The hulls of neighbouring cells share a voxel, so together they cover the whole range without a gap: the
 * mask is full unless NaN or Inf keep cells apart. Only then is it worth computing, bin by bin. */
#include "occupancy.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

static bool all_finite(const float *lo, size_t sx, size_t sy, const uint32_t core[3])
{
    for (uint32_t z = 0; z <= core[2]; z++)
        for (uint32_t y = 0; y <= core[1]; y++) {
            const float *row = lo + (z * sy + y) * sx;
            int bad = 0; /* no early way out: whole rows vectorise */
            for (uint32_t x = 0; x <= core[0]; x++)
                bad |= !isfinite(row[x]);
            if (bad)
                return false;
        }
    return true;
}

/* Bins of every voxel; one that is not finite gets (255, 0), neutral for minimum and maximum. */
static void bins_of_voxels(const float *lo, const float *hi, size_t sx, size_t sy, const uint32_t core[3],
                           double min, double scale, unsigned char *bin_lo, unsigned char *bin_hi)
{
    for (uint32_t z = 0; z <= core[2]; z++)
        for (uint32_t y = 0; y <= core[1]; y++) {
            const float *l = lo + (z * sy + y) * sx, *h = hi + (z * sy + y) * sx;
            for (uint32_t x = 0; x <= core[0]; x++) {
                double a = ((double)l[x] - min) * scale, b = ((double)h[x] - min) * scale;
                *bin_lo++ = isfinite(l[x]) ? (unsigned char)(a < 63.0 ? a : 63.0) : 255;
                *bin_hi++ = isfinite(h[x]) ? (unsigned char)(b < 63.0 ? b : 63.0) : 0;
            }
        }
}

/* Minimum (or maximum) over the two neighbours on each axis: (core+1)^3 lattice values to core^3 cells, in
 * place. */
static void hull(unsigned char *bins, unsigned char *tmp, const uint32_t core[3], bool max)
{
    size_t nx = core[0] + 1, ny = core[1] + 1, nz = core[2] + 1, n = nx * ny * nz;
    const size_t stride[3] = {1, nx, nx * ny};
    for (int a = 0; a < 3; a++) {
        size_t s = stride[a], end = n - s;
        if (max)
            for (size_t i = 0; i < end; i++)
                tmp[i] = bins[i] > bins[i + s] ? bins[i] : bins[i + s];
        else
            for (size_t i = 0; i < end; i++)
                tmp[i] = bins[i] < bins[i + s] ? bins[i] : bins[i + s];
        memcpy(bins, tmp, end);
    }
}

uint64_t occupancy_mask(enum brick_type type, const void *lo, const void *hi, size_t sx, size_t sy,
                        const uint32_t core[3], float min, float max, unsigned char *bins)
{
    if (!(min <= max))
        return 0;
    if (min == max)
        return 1;
    if (type != BRICK_F32 || all_finite(lo, sx, sy, core))
        return ~UINT64_C(0);
    size_t lattice = (size_t)(core[0] + 1) * (core[1] + 1) * (core[2] + 1);
    unsigned char *bin_lo = bins, *bin_hi = bins + lattice, *tmp = bins + 2 * lattice;
    bins_of_voxels(lo, hi, sx, sy, core, (double)min, 64.0 / ((double)max - (double)min), bin_lo, bin_hi);
    hull(bin_lo, tmp, core, false);
    hull(bin_hi, tmp, core, true);
    uint64_t mask = 0;
    for (uint32_t z = 0; z < core[2]; z++)
        for (uint32_t y = 0; y < core[1]; y++) {
            size_t row = ((size_t)z * (core[1] + 1) + y) * (core[0] + 1);
            for (uint32_t x = 0; x < core[0]; x++)
                if (bin_lo[row + x] < 64) /* 255: no corner is finite */
                    mask |= ~UINT64_C(0) << bin_lo[row + x] & ~UINT64_C(0) >> (63 - bin_hi[row + x]);
        }
    return mask;
}
