/* Histogram and moments. For integers everything follows from the histogram, exactly until the last division.
 */
#include "tally.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BINS = 65536 };

int tally_init(struct tally *tally, struct brick_error *err)
{
    tally->bins = calloc(BINS, sizeof *tally->bins);
    return tally->bins ? BRICK_OK : brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a histogram");
}

void tally_finish(struct tally *tally)
{
    free(tally->bins);
    tally->bins = NULL;
}

static const void *core_row(const struct brick_grid *grid, const struct brick_place *place,
                            const void *voxels, uint32_t y, uint32_t z)
{
    size_t at =
        ((size_t)(z + grid->border) * place->stored[1] + y + grid->border) * place->stored[0] + grid->border;
    return (const unsigned char *)voxels + at * brick_type_bytes(grid->type);
}

static void count_row(uint64_t *bins, enum brick_type type, const void *row, uint32_t n)
{
    switch (type) {
    case BRICK_U8:
        for (uint32_t i = 0; i < n; i++)
            bins[((const uint8_t *)row)[i]]++;
        break;
    case BRICK_I8:
        for (uint32_t i = 0; i < n; i++)
            bins[((const int8_t *)row)[i] + 128]++;
        break;
    case BRICK_U16:
        for (uint32_t i = 0; i < n; i++)
            bins[((const uint16_t *)row)[i]]++;
        break;
    default:
        for (uint32_t i = 0; i < n; i++)
            bins[((const int16_t *)row)[i] + 32768]++;
        break;
    }
}

static uint32_t count_floats(uint64_t *bins, const struct brick_grid *grid, const struct brick_place *place,
                             const void *voxels, struct tally_moments *moments)
{
    uint32_t nonfinite = 0;
    double sum = 0.0, m2 = 0.0;
    uint64_t count = 0;
    for (uint32_t z = 0; z < place->core[2]; z++)
        for (uint32_t y = 0; y < place->core[1]; y++) {
            const float *row = core_row(grid, place, voxels, y, z);
            for (uint32_t x = 0; x < place->core[0]; x++) {
                if (!isfinite(row[x])) {
                    nonfinite++;
                    continue;
                }
                uint32_t bits;
                memcpy(&bits, &row[x], sizeof bits);
                bins[(bits ^ (bits >> 31 ? 0xffffffffu : 0x80000000u)) >> 16]++;
                sum += (double)row[x];
                count++;
            }
        }
    double mean = count ? sum / (double)count : 0.0;
    for (uint32_t z = 0; z < place->core[2]; z++)
        for (uint32_t y = 0; y < place->core[1]; y++) {
            const float *row = core_row(grid, place, voxels, y, z);
            for (uint32_t x = 0; x < place->core[0]; x++)
                if (isfinite(row[x]))
                    m2 += ((double)row[x] - mean) * ((double)row[x] - mean);
        }
    *moments = (struct tally_moments){count, mean, m2};
    return nonfinite;
}

uint32_t tally_brick(struct tally *tally, const struct brick_grid *grid, const struct brick_place *place,
                     const void *voxels, struct tally_moments *moments)
{
    *moments = (struct tally_moments){0};
    if (grid->type == BRICK_F32)
        return count_floats(tally->bins, grid, place, voxels, moments);
    for (uint32_t z = 0; z < place->core[2]; z++)
        for (uint32_t y = 0; y < place->core[1]; y++)
            count_row(tally->bins, grid->type, core_row(grid, place, voxels, y, z), place->core[0]);
    return 0;
}

void tally_merge_moments(struct tally_moments *a, const struct tally_moments *b)
{
    if (b->count == 0)
        return;
    double na = (double)a->count, nb = (double)b->count, n = na + nb, d = b->mean - a->mean;
    a->mean += d * (nb / n);
    a->m2 += b->m2 + d * d * (na * nb / n);
    a->count += b->count;
}

/* Moments of integer values from their counts, in order of value. */
static struct tally_moments moments_of_counts(const uint64_t *bins, enum brick_type type)
{
    struct tally_moments m = {0};
    double sum = 0.0;
    for (uint32_t i = 0; i < BINS; i++) {
        m.count += bins[i];
        sum += (double)bins[i] * brick_stats_bin_start(type, i);
    }
    m.mean = m.count ? sum / (double)m.count : 0.0;
    for (uint32_t i = 0; i < BINS; i++) {
        double d = brick_stats_bin_start(type, i) - m.mean;
        m.m2 += (double)bins[i] * d * d;
    }
    return m;
}

void tally_result(struct tally *tally, unsigned n, enum brick_type type, uint64_t voxels, double min,
                  double max, const struct tally_moments *moments, struct brick_stats *stats)
{
    uint64_t *bins = tally[0].bins;
    for (unsigned t = 1; t < n; t++)
        for (uint32_t i = 0; i < BINS; i++)
            bins[i] += tally[t].bins[i];
    struct tally_moments m = type == BRICK_F32 ? *moments : moments_of_counts(bins, type);
    uint32_t first = 0, end = BINS;
    while (first < BINS && bins[first] == 0)
        first++;
    while (end > first && bins[end - 1] == 0)
        end--;
    *stats = (struct brick_stats){.count = m.count,
                                  .nonfinite = voxels - m.count,
                                  .min = min,
                                  .max = max,
                                  .mean = m.mean,
                                  .variance = m.count ? m.m2 / (double)m.count : 0.0,
                                  .first_bin = first == end ? 0 : first,
                                  .bins = end - first,
                                  .histogram = bins + first};
}
