/* One brick: gather with the volume's edge repeated, ranges over cells, constant test, compression. Pure
 * function of the window: no state but the worker's scratch memory. */
#include "encode.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lossy.h"
#include "occupancy.h"
#include "ranges.h"

size_t encoder_bytes(const struct brick_grid *grid)
{
    size_t cells = (size_t)(grid->edge + 1) * (grid->edge + 1) * (grid->edge + 1);
    return brick_grid_max_payload_bytes(grid) + ranges_scratch_bytes(grid) +
           cells * (2 * brick_type_bytes(grid->type) + 3);
}

int encoder_init(struct encoder *e, const struct kernels *kernels, const struct brick_grid *grid,
                 struct brick_error *err)
{
    size_t cells = (size_t)(grid->edge + 1) * (grid->edge + 1) * (grid->edge + 1),
           width = brick_type_bytes(grid->type);
    *e = (struct encoder){.kernels = kernels,
                          .payload = malloc(brick_grid_max_payload_bytes(grid)),
                          .lo = malloc(cells * width),
                          .hi = malloc(cells * width),
                          .folds = malloc(ranges_scratch_bytes(grid)),
                          .bins = malloc(3 * cells)};
    if (e->payload && e->lo && e->hi && e->folds && e->bins)
        return BRICK_OK;
    encoder_finish(e);
    return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a brick's scratch space");
}

void encoder_finish(struct encoder *e)
{
    free(e->payload);
    free(e->lo);
    free(e->hi);
    free(e->folds);
    free(e->bins);
    brick_scratch_finish(&e->stored);
    memset(e, 0, sizeof *e);
}

void encode_ranges(const struct brick_grid *grid, const struct brick_place *place, const void *voxels,
                   const void *lo, const void *hi, void *macrocells, struct encoder *scratch,
                   struct brick_entry *entry)
{
    size_t sx = place->core[0] + 1, sy = place->core[1] + 1;
    if (!lo) { /* level 0: the padded voxels themselves, from core voxel 0 on */
        sx = place->stored[0];
        sy = place->stored[1];
        size_t at = ((size_t)grid->border * sy + grid->border) * sx + grid->border;
        lo = hi = (const unsigned char *)voxels + at * brick_type_bytes(grid->type);
    }
    ranges_of_brick(scratch->kernels, grid, place, lo, hi, sx, sy, macrocells, scratch->folds, entry);
    entry->mask =
        occupancy_mask(grid->type, lo, hi, sx, sy, place->core, entry->min, entry->max, scratch->bins);
}

static uint64_t clamp_index(int64_t i, uint64_t n)
{
    return i < 0 ? 0 : (uint64_t)i < n ? (uint64_t)i : n - 1;
}

/* memcpy of short rows, by moves of constant size that overlap: a call to the library costs more than the
 * copy. */
static inline void copy_row(unsigned char *dst, const unsigned char *src, size_t n)
{
    if (n >= 64) {
        for (size_t i = 0; i + 64 < n; i += 64)
            memcpy(dst + i, src + i, 64);
        memcpy(dst + n - 64, src + n - 64, 64);
    } else if (n >= 32) {
        memcpy(dst, src, 32);
        memcpy(dst + n - 32, src + n - 32, 32);
    } else {
        memcpy(dst, src, n);
    }
}

/* Copy the box [lo, lo + size) of one of a window's arrays to dst, the volume's edge repeated. */
static void gather(const struct window *w, const unsigned char *slices, size_t width, const int64_t lo[3],
                   const uint32_t size[3], unsigned char *dst)
{
    const uint64_t *dims = w->level->dims;
    uint32_t left = lo[0] < 0 ? (uint32_t)-lo[0] : 0;
    uint64_t from = (uint64_t)(lo[0] + left), inside = dims[0] - from;
    uint32_t middle = inside < size[0] - left ? (uint32_t)inside : size[0] - left;
    size_t line = (size_t)w->size[0] * width;
    const unsigned char *next = slices + window_at(w, from, w->lo[1], clamp_index(lo[2], dims[2]));
    for (uint32_t z = 0; z < size[2]; z++) {
        const unsigned char *slice = next;
        next = slices + window_at(w, from, w->lo[1], clamp_index(lo[2] + z + 1, dims[2]));
        for (uint32_t y = 0; y < size[1]; y++) {
            size_t at = (clamp_index(lo[1] + y, dims[1]) - w->lo[1]) * line;
            const unsigned char *row = slice + at;
            /* Rows are far apart, which processors do not foresee: ask for the next slice's while copying
             * this. */
            for (size_t i = 0; i < middle * width; i += 64)
                __builtin_prefetch(next + at + i);
            for (uint32_t x = 0; x < left; x++, dst += width)
                memcpy(dst, row, width);
            copy_row(dst, row, middle * width);
            dst += middle * width;
            for (uint32_t x = left + middle; x < size[0]; x++, dst += width)
                memcpy(dst, row + (middle - 1) * width, width);
        }
    }
}

static bool all_equal(const unsigned char *bytes, size_t n, size_t width)
{
    return n == width || memcmp(bytes, bytes + width, n - width) == 0;
}

int encode_brick(struct encoder *e, const struct brick_grid *grid, const struct window *w, uint64_t id,
                 enum brick_codec codec, int codec_level, struct tally *tally, struct encoded *out,
                 struct costs *costs, struct brick_error *err)
{
    uint64_t clock = brick_thread_ns();
    struct brick_place place;
    brick_grid_place(grid, id, &place);
    size_t width = brick_type_bytes(grid->type), voxel_bytes = brick_place_voxel_bytes(grid, &place);
    out->id = id;
    out->level0 = place.level == 0;
    out->written = false;
    out->entry = (struct brick_entry){.codec = (uint8_t)codec};
    out->moments = (struct tally_moments){0};
    gather(w, w->voxels, width, place.lo, place.stored, e->payload);
    costs_add(costs, BRICK_STAGE_GATHER, &clock, voxel_bytes);
    /* A lossy codec comes first: everything below describes the voxels that a reader will see. */
    struct brick_codec_shape shape = brick_codec_shape(grid, &place);
    bool equal = all_equal(e->payload, voxel_bytes, width);
    size_t room = brick_codec_bound(codec, shape.bytes), lossy_bytes = 0;
    if (brick_codec_is_lossy(codec) && !equal) {
        /* Noise is cheaper to keep than to approximate closely: the lossless size is the one to beat. */
        struct brick_codec_shape voxels = shape;
        size_t lossless_bytes;
        voxels.bytes = voxel_bytes;
        int code = brick_codec_encode(LOSSY_FALLBACK, codec_level, &voxels, e->payload, out->payload, room,
                                      &lossless_bytes, err);
        if (code || (code = brick_codec_encode_lossy(codec, e->tolerance, &shape, e->payload, out->payload,
                                                     lossless_bytes, &lossy_bytes, err)))
            return code;
        costs_add(costs, BRICK_STAGE_COMPRESS, &clock, voxel_bytes);
    }
    const void *lo = NULL, *hi = NULL;
    if (place.level > 0) {
        int64_t from[3];
        uint32_t size[3];
        for (int a = 0; a < 3; a++) {
            from[a] = place.lo[a] + grid->border;
            size[a] = place.core[a] + 1;
        }
        gather(w, w->min, width, from, size, e->lo);
        gather(w, w->max, width, from, size, e->hi);
        lossy_widen(grid->type, e->lo, e->hi, (size_t)size[0] * size[1] * size[2], e->tolerance);
        lo = e->lo;
        hi = e->hi;
        costs_add(costs, BRICK_STAGE_GATHER, &clock, 0);
    }
    encode_ranges(grid, &place, e->payload, lo, hi, e->payload + voxel_bytes, e, &out->entry);
    costs_add(costs, BRICK_STAGE_RANGES, &clock, voxel_bytes);
    if (out->level0) {
        out->entry.nonfinite =
            tally_brick(tally, e->kernels, grid, &place, e->payload, e->payload + voxel_bytes, &out->moments);
        costs_add(costs, BRICK_STAGE_COUNT, &clock, voxel_bytes);
    }

    /* One range for the whole brick and one bit pattern for every voxel: the index says it all. (Not so for
     * -0, whose range is that of 0.) */
    float value = (float)brick_type_load(grid->type, e->payload, 0), range[2] = {value, value};
    if (place.level > 0 && isfinite(value))
        lossy_widen_value(grid->type, range, e->tolerance);
    bool one_range = isfinite(value) ? out->entry.min == range[0] && out->entry.max == range[1] &&
                                           !(value == 0 && signbit(value))
                                     : !(out->entry.min <= out->entry.max);
    if (one_range && equal) {
        out->entry.flags = BRICK_FLAG_CONSTANT;
        out->entry.codec = BRICK_CODEC_NONE;
        if (grid->type == BRICK_F32) /* the bits: a conversion would change those of some NaN */
            memcpy(&value, e->payload, sizeof value);
        memcpy(&out->entry.value, &value, sizeof value);
        out->bytes = 0;
        return BRICK_OK;
    }
    if (lossy_bytes) {
        memcpy(out->payload + lossy_bytes, e->payload + voxel_bytes, shape.bytes - voxel_bytes);
        out->bytes = lossy_bytes + shape.bytes - voxel_bytes;
        return BRICK_OK;
    }
    if (brick_codec_is_lossy(codec))
        codec = LOSSY_FALLBACK;
    out->entry.codec = (uint8_t)codec;
    int code =
        brick_codec_encode(codec, codec_level, &shape, e->payload, out->payload, room, &out->bytes, err);
    costs_add(costs, BRICK_STAGE_COMPRESS, &clock, shape.bytes);
    return code;
}
