/* Histogram and moments. For integers everything follows from the histogram, exactly until the last division.
 *
 * Neighbours are often equal, and adding to a counter that was just written waits for the write. So voxels
 * are dealt to four tables in turn; these have 32-bit counters, to stay in the cache, and are emptied into
 * the 64-bit ones before any could overflow. Macrocells of one value are counted without looking at their
 * voxels. */
#include "tally.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { BINS = TALLY_BINS, TABLES = 4 };

size_t tally_bytes(void)
{
    return BINS * (sizeof(uint64_t) + TABLES * sizeof(uint32_t));
}

int tally_init(struct tally *tally, struct brick_error *err)
{
    *tally = (struct tally){.bins = calloc(BINS, sizeof *tally->bins),
                            .fast = calloc((size_t)BINS * TABLES, sizeof *tally->fast)};
    if (tally->bins && tally->fast)
        return BRICK_OK;
    tally_finish(tally);
    return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a histogram");
}

void tally_finish(struct tally *tally)
{
    free(tally->bins);
    free(tally->fast);
    *tally = (struct tally){0};
}

static void empty_fast(struct tally *tally)
{
    for (uint32_t i = 0; i < BINS; i++)
        for (uint32_t t = 0; t < TABLES; t++)
            tally->bins[i] += tally->fast[t * BINS + i];
    memset(tally->fast, 0, (size_t)BINS * TABLES * sizeof *tally->fast);
    tally->pending = 0;
}

static const void *core_row(const struct brick_grid *grid, const struct brick_place *place,
                            const void *voxels, uint32_t y, uint32_t z)
{
    size_t at =
        ((size_t)(z + grid->border) * place->stored[1] + y + grid->border) * place->stored[0] + grid->border;
    return (const unsigned char *)voxels + at * brick_type_bytes(grid->type);
}

/* Count `n` voxels of each of `rows` rows, whose bin is the value + offset. */
#define COUNT(T, SUFFIX)                                                                                     \
    static void count_##SUFFIX(uint32_t *fast, const T *row, size_t stride, uint32_t n, uint32_t rows,       \
                               int32_t offset)                                                               \
    {                                                                                                        \
        for (uint32_t r = 0; r < rows; r++, row += stride) {                                                 \
            uint32_t x = 0;                                                                                  \
            for (; x + 4 <= n; x += 4) {                                                                     \
                fast[0 * BINS + row[x] + offset]++;                                                          \
                fast[1 * BINS + row[x + 1] + offset]++;                                                      \
                fast[2 * BINS + row[x + 2] + offset]++;                                                      \
                fast[3 * BINS + row[x + 3] + offset]++;                                                      \
            }                                                                                                \
            for (; x < n; x++)                                                                               \
                fast[row[x] + offset]++;                                                                     \
        }                                                                                                    \
    }
COUNT(uint8_t, u8)
COUNT(int8_t, i8)
COUNT(uint16_t, u16)
COUNT(int16_t, i16)
#undef COUNT

static int32_t bin_of_zero(enum brick_type type)
{
    return type == BRICK_I8 ? 128 : type == BRICK_I16 ? 32768 : 0;
}

static void count_box(struct tally *tally, enum brick_type type, const void *row, size_t stride, uint32_t n,
                      uint32_t rows)
{
    switch (type) {
    case BRICK_U8:
        count_u8(tally->fast, row, stride, n, rows, 0);
        break;
    case BRICK_I8:
        count_i8(tally->fast, row, stride, n, rows, bin_of_zero(type));
        break;
    case BRICK_U16:
        count_u16(tally->fast, row, stride, n, rows, 0);
        break;
    default:
        count_i16(tally->fast, row, stride, n, rows, bin_of_zero(type));
        break;
    }
}

/* A row of macrocells: one after the other where some are of one value, else in rows as long as the brick. */
static void count_integers(struct tally *tally, const struct brick_grid *grid,
                           const struct brick_place *place, const void *voxels,
                           const unsigned char *macrocells)
{
    size_t width = brick_type_bytes(grid->type), stride = place->stored[0];
    for (uint32_t z = 0; z < place->core[2]; z += grid->macrocell) {
        uint32_t nz = place->core[2] - z < grid->macrocell ? place->core[2] - z : grid->macrocell;
        for (uint32_t y = 0; y < place->core[1]; y += grid->macrocell) {
            uint32_t ny = place->core[1] - y < grid->macrocell ? place->core[1] - y : grid->macrocell;
            for (uint32_t x = 0; x < place->core[0];) {
                /* as many neighbours as are all of one value, or all not */
                bool flat = memcmp(macrocells, macrocells + width, width) == 0;
                uint32_t from = x;
                do {
                    x += grid->macrocell;
                    macrocells += 2 * width;
                } while (!flat && x < place->core[0] && memcmp(macrocells, macrocells + width, width) != 0);
                uint32_t nx = (x < place->core[0] ? x : place->core[0]) - from;
                if (flat)
                    tally->bins[(int32_t)brick_type_load(grid->type, macrocells - width, 0) +
                                bin_of_zero(grid->type)] += (uint64_t)nx * ny * nz;
                else
                    for (uint32_t k = 0; k < nz; k++)
                        count_box(tally, grid->type,
                                  (const unsigned char *)core_row(grid, place, voxels, y, z + k) +
                                      from * width,
                                  stride, nx, ny);
            }
        }
    }
}

static double sum_of_lanes(const double lane[8])
{
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}

static uint32_t count_floats(struct tally *tally, const struct kernels *kernels,
                             const struct brick_grid *grid, const struct brick_place *place,
                             const void *voxels, struct tally_moments *moments)
{
    uint32_t nonfinite = 0, n = place->core[0];
    double sum[8] = {0}, squares[8] = {0};
    for (uint32_t z = 0; z < place->core[2]; z++)
        for (uint32_t y = 0; y < place->core[1]; y++) {
            const float *row = core_row(grid, place, voxels, y, z);
            kernels->sum_f32(sum, row, n);
            for (uint32_t x = 0; x < n; x++) {
                if (!isfinite(row[x])) {
                    nonfinite++;
                    continue;
                }
                uint32_t bits;
                memcpy(&bits, &row[x], sizeof bits);
                tally->fast[(x & 3) * BINS + ((bits ^ (bits >> 31 ? 0xffffffffu : 0x80000000u)) >> 16)]++;
            }
        }
    uint64_t count = (uint64_t)n * place->core[1] * place->core[2] - nonfinite;
    double mean = count ? sum_of_lanes(sum) / (double)count : 0.0;
    for (uint32_t z = 0; z < place->core[2]; z++)
        for (uint32_t y = 0; y < place->core[1]; y++)
            kernels->squares_f32(squares, core_row(grid, place, voxels, y, z), n, mean);
    *moments = (struct tally_moments){count, mean, sum_of_lanes(squares)};
    return nonfinite;
}

uint32_t tally_brick(struct tally *tally, const struct kernels *kernels, const struct brick_grid *grid,
                     const struct brick_place *place, const void *voxels, const void *macrocells,
                     struct tally_moments *moments)
{
    uint64_t n = (uint64_t)place->core[0] * place->core[1] * place->core[2];
    if (tally->pending + n > UINT32_MAX)
        empty_fast(tally);
    tally->pending += n;
    *moments = (struct tally_moments){0};
    if (grid->type == BRICK_F32)
        return count_floats(tally, kernels, grid, place, voxels, moments);
    count_integers(tally, grid, place, voxels, macrocells);
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

void tally_gather(struct tally *tally, unsigned n)
{
    for (unsigned t = 0; t < n; t++)
        empty_fast(&tally[t]);
    for (unsigned t = 1; t < n; t++)
        for (uint32_t i = 0; i < BINS; i++) {
            tally[0].bins[i] += tally[t].bins[i];
            tally[t].bins[i] = 0;
        }
}

void tally_result(struct tally *tally, unsigned n, enum brick_type type, uint64_t voxels, double min,
                  double max, const struct tally_moments *moments, struct brick_stats *stats)
{
    uint64_t *bins = tally[0].bins;
    tally_gather(tally, n);
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
