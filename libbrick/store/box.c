/* Voxels of a box of a level, gathered from the cores of the bricks it touches. */
#include <brick/volume.h>

#include <stdlib.h>
#include <string.h>

static void copy_part(const struct brick_grid *grid, const struct brick_place *place, const uint64_t lo[3],
                      const uint64_t hi[3], const unsigned char *brick, unsigned char *dst)
{
    size_t width = brick_type_bytes(grid->type);
    uint64_t from[3], to[3];
    for (int a = 0; a < 3; a++) {
        uint64_t core = place->at[a] * grid->edge;
        from[a] = core > lo[a] ? core : lo[a];
        to[a] = core + place->core[a] < hi[a] ? core + place->core[a] : hi[a];
    }
    size_t local[3];
    for (uint64_t z = from[2]; z < to[2]; z++)
        for (uint64_t y = from[1]; y < to[1]; y++) {
            local[0] = (size_t)((int64_t)from[0] - place->lo[0]);
            local[1] = (size_t)((int64_t)y - place->lo[1]);
            local[2] = (size_t)((int64_t)z - place->lo[2]);
            size_t src_at = (local[2] * place->stored[1] + local[1]) * place->stored[0] + local[0];
            size_t dst_at =
                (size_t)(((z - lo[2]) * (hi[1] - lo[1]) + (y - lo[1])) * (hi[0] - lo[0]) + from[0] - lo[0]);
            memcpy(dst + dst_at * width, brick + src_at * width, (size_t)(to[0] - from[0]) * width);
        }
}

int brick_volume_read_box(const struct brick_volume *volume, uint32_t level, const uint64_t lo[3],
                          const uint64_t hi[3], void *dst, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    if (level >= grid->levels)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: no level %u: it has %u", brick_volume_path(volume),
                          level, grid->levels);
    for (int a = 0; a < 3; a++)
        if (lo[a] >= hi[a] || hi[a] > grid->level[level].dims[a])
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "%s: voxels %llu..%llu on axis %c are not in level %u's 0..%llu",
                              brick_volume_path(volume), (unsigned long long)lo[a], (unsigned long long)hi[a],
                              "xyz"[a], level, (unsigned long long)grid -> level[level].dims[a]);
    unsigned char *brick = malloc(brick_grid_max_payload_bytes(grid));
    if (!brick)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory for a brick", brick_volume_path(volume));
    struct brick_scratch scratch = {0};
    int code = BRICK_OK;
    for (uint64_t bz = lo[2] / grid->edge; !code && bz <= (hi[2] - 1) / grid->edge; bz++)
        for (uint64_t by = lo[1] / grid->edge; !code && by <= (hi[1] - 1) / grid->edge; by++)
            for (uint64_t bx = lo[0] / grid->edge; !code && bx <= (hi[0] - 1) / grid->edge; bx++) {
                uint64_t id = brick_grid_id(grid, level, bx, by, bz);
                struct brick_place place;
                brick_grid_place(grid, id, &place);
                code = brick_volume_read(volume, id, brick, &scratch, err);
                if (!code)
                    copy_part(grid, &place, lo, hi, brick, dst);
            }
    brick_scratch_finish(&scratch);
    free(brick);
    return code;
}
