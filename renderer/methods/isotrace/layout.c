/* The orders that the paper compares: one array, x fastest, and two levels of tiles (appendix B). Both are
 * copies of a whole level with the same borders as bricks, so that the walk through them is the same walk. */
#include "layout.h"

#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>

#include "pins.h"

/* Tiles of 4^3 voxels, 64 to 256 bytes, in tiles of 3^3 of those: 12 divides the 36 voxels of a brick of 32
 * with its border. (The paper: a tile as long as a cache line, 5 of them a side for 16 bits.) */
enum { TILE = 4, TILES = 3, SUPER = TILE * TILES };

void vr_iso_layout_finish(struct vr_iso_layout_copy *copy)
{
    free(copy->blocks);
    free(copy->voxels);
    free(copy->ranges);
    for (int i = 0; i < 3; i++)
        free(copy->table[i]);
    *copy = (struct vr_iso_layout_copy){.layout = copy->layout};
}

static int64_t clamped(int64_t i, uint64_t n)
{
    return i < 0 ? 0 : i >= (int64_t)n ? (int64_t)n - 1 : i;
}

static int make_flat(struct vr_iso_layout_copy *copy, const struct brick_volume *volume,
                     uint32_t level_number, uint64_t budget_bytes, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_level *level = &grid->level[level_number];
    const size_t size = brick_type_bytes(grid->type);
    const uint64_t origin[3] = {0, 0, 0};
    uint64_t stored[3], count, bytes, source_bytes;
    for (int i = 0; i < 3; i++)
        stored[i] = level->dims[i] + 2 * (uint64_t)grid->border;
    if (!brick_mul3_u64(stored[0], stored[1], stored[2], &count) || !brick_mul_u64(count, size, &bytes) ||
        bytes > budget_bytes || level->dims[0] > INT32_MAX / 2 || level->dims[1] > INT32_MAX / 2 ||
        level->dims[2] > INT32_MAX / 2)
        return brick_fail(err, BRICK_ERR_MEMORY,
                          "isotrace: the level as one array does not fit --host-cache");
    source_bytes = level->dims[0] * level->dims[1] * level->dims[2] * size;
    unsigned char *source = malloc((size_t)source_bytes), *voxels = malloc((size_t)bytes);
    struct vr_iso_block *block = calloc(1, sizeof *block);
    copy->voxels = voxels;
    copy->blocks = block;
    int code = source && voxels && block
                   ? brick_volume_read_box(volume, level_number, origin, level->dims, source, err)
                   : brick_fail(err, BRICK_ERR_MEMORY, "isotrace: no memory for the level as one array");
    for (uint64_t z = 0; z < stored[2] && !code; z++)
        for (uint64_t y = 0; y < stored[1]; y++) {
            size_t sz = (size_t)clamped((int64_t)z - grid->border, level->dims[2]);
            size_t sy = (size_t)clamped((int64_t)y - grid->border, level->dims[1]);
            const unsigned char *from = source + (sz * level->dims[1] + sy) * level->dims[0] * size;
            unsigned char *to = voxels + (z * stored[1] + y) * stored[0] * size;
            for (uint64_t x = 0; x < stored[0]; x++)
                memcpy(to + x * size,
                       from + (size_t)clamped((int64_t)x - grid->border, level->dims[0]) * size, size);
        }
    free(source);
    if (code)
        return code;
    *block = (struct vr_iso_block){.voxels = voxels,
                                   .part_shift = 30,
                                   .row = (size_t)stored[0],
                                   .slice = (size_t)(stored[0] * stored[1])};
    for (int i = 0; i < 3; i++) {
        block->lo[i] = -(int64_t)grid->border;
        block->first[i] = (int32_t)grid->border;
        block->end[i] = (int32_t)(grid->border + level->dims[i]);
        block->edge_low[i] = block->edge_high[i] = true;
        block->parts[i] = 1;
    }
    return BRICK_OK;
}

/* F of appendix B for one axis: its contribution to a voxel's place. `axis` counts from the fastest inside a
 * tile. */
static uint32_t place_on(uint32_t i, int axis, uint32_t supers)
{
    const uint32_t tile_voxels = TILE * TILE * TILE, super_voxels = SUPER * SUPER * SUPER;
    uint32_t in_tile = i % TILE, tile = i / TILE % TILES, super = i / SUPER;
    for (int a = 0; a < axis; a++) {
        in_tile *= TILE;
        tile *= TILES;
        super *= supers;
    }
    return super * super_voxels + tile * tile_voxels + in_tile;
}

static int make_tiled(struct vr_iso_layout_copy *copy, const struct brick_volume *volume,
                      uint32_t level_number, uint64_t budget_bytes, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_level *level = &grid->level[level_number];
    const size_t size = brick_type_bytes(grid->type), payload_max = brick_grid_max_payload_bytes(grid);
    const uint32_t stored = grid->edge + 2 * grid->border, supers = (stored + SUPER - 1) / SUPER;
    const uint64_t voxels_a_brick = (uint64_t)supers * supers * supers * SUPER * SUPER * SUPER;
    uint64_t bricks = level->bricks[0] * level->bricks[1] * level->bricks[2], bytes;
    struct brick_scratch scratch = {0};
    int code = BRICK_OK;
    if (!brick_mul3_u64(bricks, voxels_a_brick, size, &bytes) || bytes > budget_bytes)
        return brick_fail(err, BRICK_ERR_MEMORY, "isotrace: the level in tiles does not fit --host-cache");
    unsigned char *payload = malloc(payload_max), *voxels = malloc((size_t)bytes);
    unsigned char *ranges = malloc((size_t)bricks * payload_max / 4); /* 2 of each 4^3 voxels or more */
    copy->voxels = voxels;
    copy->ranges = ranges;
    copy->blocks = calloc((size_t)bricks, sizeof *copy->blocks);
    for (int i = 0; i < 3; i++) {
        copy->table[i] = malloc(supers * SUPER * sizeof *copy->table[i]);
        for (uint32_t x = 0; copy->table[i] && x < supers * SUPER; x++)
            copy->table[i][x] = place_on(x, i, supers);
    }
    if (!payload || !voxels || !ranges || !copy->blocks || !copy->table[0] || !copy->table[1] ||
        !copy->table[2])
        code = brick_fail(err, BRICK_ERR_MEMORY, "isotrace: no memory for the level in tiles");
    for (uint64_t b = 0; b < bricks && !code; b++) {
        struct vr_iso_block *block = &copy->blocks[b];
        code = brick_volume_read(volume, level->first_brick + b, payload, &scratch, err);
        if (code)
            break;
        vr_iso_block_of_brick(grid, level->first_brick + b, payload, block);
        uint32_t sides[3] = {(uint32_t)block->row, (uint32_t)(block->slice / block->row), 0};
        sides[2] = (uint32_t)(block->end[2] + (int32_t)grid->border);
        for (uint32_t z = 0; z < sides[2]; z++)
            for (uint32_t y = 0; y < sides[1]; y++)
                for (uint32_t x = 0; x < sides[0]; x++)
                    memcpy(voxels + (b * voxels_a_brick + copy->table[0][x] + copy->table[1][y] +
                                     copy->table[2][z]) *
                                        size,
                           payload + (z * block->slice + y * block->row + x) * size, size);
        size_t range_bytes = 2 * size * (size_t)(block->macros[0] * block->macros[1] * block->macros[2]);
        memcpy(ranges + b * (payload_max / 4), block->ranges, range_bytes);
        block->voxels = voxels + b * voxels_a_brick * size;
        block->ranges = ranges + b * (payload_max / 4);
        for (int i = 0; i < 3; i++)
            block->table[i] = copy->table[i];
    }
    brick_scratch_finish(&scratch);
    free(payload);
    return code;
}

int vr_iso_layout_make(struct vr_iso_layout_copy *copy, const struct brick_volume *volume, uint32_t level,
                       uint64_t budget_bytes, struct brick_error *err)
{
    if (copy->layout == VR_ISO_BRICKS || (copy->ready && copy->level == level))
        return BRICK_OK;
    vr_iso_layout_finish(copy);
    int code = copy->layout == VR_ISO_FLAT ? make_flat(copy, volume, level, budget_bytes, err)
                                           : make_tiled(copy, volume, level, budget_bytes, err);
    if (code) {
        vr_iso_layout_finish(copy);
        return code;
    }
    copy->level = level;
    copy->ready = true;
    return BRICK_OK;
}
