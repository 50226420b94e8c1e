/* Voxels that are lost have a next best: a neighbour's border repeats the outermost ones exactly; a coarser
 * level has the mean of every few. Invariant: level 0 made so leaves coarser voxels over a lost brick as they
 * were, where they came from the next level; and it agrees with every brick that is whole. */
#include "patch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

uint64_t patch_bytes(const struct brick_grid *grid)
{
    return 4 * (uint64_t)brick_grid_max_payload_bytes(grid);
}

static int read_brick(struct patch *p, uint64_t id, struct brick_place *place, struct brick_error *err)
{
    brick_grid_place(p->salvage->grid, id, place);
    return brick_volume_read(p->salvage->volume, id, p->brick, &p->scratch, err);
}

/* Of a brick's voxels, by numbers in its level: p->brick. */
static const unsigned char *stored_at(const struct patch *p, const struct brick_place *place,
                                      const uint64_t at[3])
{
    size_t local[3];
    for (int a = 0; a < 3; a++)
        local[a] = (size_t)((int64_t)at[a] - place->lo[a]);
    return p->brick + ((local[2] * place->stored[1] + local[1]) * place->stored[0] + local[0]) *
                          brick_type_bytes(p->salvage->grid->type);
}

/* Fill the core from the finest coarser brick that is whole; its level, or 0. */
static int fill_from_levels(struct patch *p, const struct brick_place *lost, uint32_t *level,
                            struct brick_error *err)
{
    const struct brick_grid *grid = p->salvage->grid;
    size_t width = brick_type_bytes(grid->type);
    uint64_t at[3] = {lost->at[0], lost->at[1], lost->at[2]};
    int halvings[3] = {0, 0, 0};
    for (uint32_t l = 1; l < grid->levels; l++) {
        for (int a = 0; a < 3; a++)
            if (grid->level[l].scale[a] > grid->level[l - 1].scale[a]) {
                at[a] /= 2;
                halvings[a]++;
            }
        uint64_t id = brick_grid_id(grid, l, at[0], at[1], at[2]);
        if (!(p->salvage->state[id] & SALVAGE_VOXELS))
            continue;
        struct brick_place place;
        int code = read_brick(p, id, &place, err);
        if (code)
            return code;
        unsigned char *to = p->core;
        for (uint32_t z = 0; z < lost->core[2]; z++)
            for (uint32_t y = 0; y < lost->core[1]; y++)
                for (uint32_t x = 0; x < lost->core[0]; x++, to += width) {
                    const uint32_t in[3] = {x, y, z};
                    uint64_t coarse[3];
                    for (int a = 0; a < 3; a++)
                        coarse[a] = (lost->at[a] * grid->edge + in[a]) >> halvings[a];
                    memcpy(to, stored_at(p, &place, coarse), width);
                }
        *level = l;
        return BRICK_OK;
    }
    *level = 0;
    size_t n = (size_t)lost->core[0] * lost->core[1] * lost->core[2];
    for (size_t i = 0; i < n; i++)
        brick_type_store(grid->type, p->core, i, p->fill);
    return BRICK_OK;
}

/* Copy what a whole neighbour's border holds of the core. */
static int take_from_neighbour(struct patch *p, const struct brick_place *lost, uint64_t neighbour,
                               struct brick_error *err)
{
    const struct brick_grid *grid = p->salvage->grid;
    size_t width = brick_type_bytes(grid->type);
    struct brick_place place;
    int code = read_brick(p, neighbour, &place, err);
    if (code)
        return code;
    uint64_t from[3], to[3], origin[3];
    for (int a = 0; a < 3; a++) {
        origin[a] = lost->at[a] * grid->edge;
        int64_t lo = place.lo[a], hi = lo + place.stored[a];
        from[a] = lo > (int64_t)origin[a] ? (uint64_t)lo : origin[a];
        to[a] = hi < (int64_t)(origin[a] + lost->core[a]) ? (uint64_t)hi : origin[a] + lost->core[a];
    }
    uint64_t v[3];
    for (v[2] = from[2]; v[2] < to[2]; v[2]++)
        for (v[1] = from[1]; v[1] < to[1]; v[1]++)
            for (v[0] = from[0]; v[0] < to[0]; v[0]++) {
                size_t i =
                    (size_t)(((v[2] - origin[2]) * lost->core[1] + (v[1] - origin[1])) * lost->core[0] +
                             (v[0] - origin[0]));
                memcpy(p->core + i * width, stored_at(p, &place, v), width);
                p->known[i] = 1;
            }
    return BRICK_OK;
}

int patch_lost(struct patch *p, uint64_t id, struct brick_loss *loss, struct brick_error *err)
{
    const struct salvage *s = p->salvage;
    const uint64_t *bricks = s->grid->level[0].bricks;
    struct brick_place lost;
    brick_grid_place(s->grid, id, &lost);
    uint32_t n = lost.core[0] * lost.core[1] * lost.core[2];
    *loss = (struct brick_loss){.brick = id, .at = {lost.at[0], lost.at[1], lost.at[2]}, .voxels = n};
    memset(p->known, 0, n);
    int code = fill_from_levels(p, &lost, &loss->from_level, err);
    for (int i = 0; !code && i < 27; i++) {
        const int step[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        uint64_t at[3];
        bool inside = true;
        for (int a = 0; a < 3; a++) {
            at[a] = lost.at[a] + (uint64_t)(int64_t)step[a];
            inside = inside && at[a] < bricks[a];
        }
        uint64_t neighbour = inside ? brick_grid_id(s->grid, 0, at[0], at[1], at[2]) : id;
        if (neighbour != id && s->state[neighbour] & SALVAGE_VOXELS)
            code = take_from_neighbour(p, &lost, neighbour, err);
    }
    for (uint32_t i = 0; i < n; i++)
        loss->from_neighbours += p->known[i];
    return code;
}

/* A brick's part of the slab. */
static int fill_slab(struct patch *p, uint64_t id, struct brick_error *err)
{
    const struct brick_grid *grid = p->salvage->grid;
    size_t width = brick_type_bytes(grid->type);
    struct brick_place place;
    struct brick_loss loss;
    bool whole = p->salvage->state[id] & SALVAGE_VOXELS;
    int code = whole ? read_brick(p, id, &place, err) : patch_lost(p, id, &loss, err);
    if (code)
        return code;
    brick_grid_place(grid, id, &place);
    uint64_t origin[3], from[3], to[3];
    for (int a = 0; a < 3; a++) {
        origin[a] = place.at[a] * grid->edge;
        from[a] = origin[a] > p->slab.lo[a] ? origin[a] : p->slab.lo[a];
        to[a] = origin[a] + place.core[a] < p->slab.hi[a] ? origin[a] + place.core[a] : p->slab.hi[a];
    }
    const uint64_t nx = p->slab.hi[0] - p->slab.lo[0], ny = p->slab.hi[1] - p->slab.lo[1];
    for (uint64_t z = from[2]; z < to[2]; z++)
        for (uint64_t y = from[1]; y < to[1]; y++) {
            const uint64_t at[3] = {from[0], y, z};
            size_t core = (size_t)(((z - origin[2]) * place.core[1] + (y - origin[1])) * place.core[0] +
                                   (from[0] - origin[0]));
            size_t i =
                (size_t)(((z - p->slab.lo[2]) * ny + (y - p->slab.lo[1])) * nx + (from[0] - p->slab.lo[0]));
            memcpy(p->slab_voxels + i * width, whole ? stored_at(p, &place, at) : p->core + core * width,
                   (size_t)(to[0] - from[0]) * width);
        }
    return BRICK_OK;
}

/* The row of bricks that slice z is in, as far as a box goes in x and y. */
static int need_slab(struct patch *p, const uint64_t lo[3], const uint64_t hi[3], uint64_t z,
                     struct brick_error *err)
{
    const struct brick_grid *grid = p->salvage->grid;
    const struct brick_level *level = &grid->level[0];
    if (p->slab_bytes && z >= p->slab.lo[2] && z < p->slab.hi[2] && lo[0] == p->slab.lo[0] &&
        lo[1] == p->slab.lo[1] && hi[0] == p->slab.hi[0] && hi[1] == p->slab.hi[1])
        return BRICK_OK;
    uint64_t row = z / grid->edge, end = (row + 1) * grid->edge;
    p->slab = (struct box){{lo[0], lo[1], row * grid->edge},
                           {hi[0], hi[1], end < level->dims[2] ? end : level->dims[2]}};
    size_t bytes = (size_t)((hi[0] - lo[0]) * (hi[1] - lo[1])) * grid->edge * brick_type_bytes(grid->type);
    if (bytes > p->slab_bytes) {
        free(p->slab_voxels);
        p->slab_voxels = malloc(bytes);
        p->slab_bytes = p->slab_voxels ? bytes : 0;
        if (!p->slab_voxels)
            return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory for a row of bricks",
                              brick_volume_path(p->salvage->volume));
    }
    int code = BRICK_OK;
    for (uint64_t y = lo[1] / grid->edge; !code && y <= (hi[1] - 1) / grid->edge; y++)
        for (uint64_t x = lo[0] / grid->edge; !code && x <= (hi[0] - 1) / grid->edge; x++)
            code = fill_slab(p, brick_grid_id(grid, 0, x, y, row), err);
    return code;
}

static int read_box(struct brick_source *source, const uint64_t lo[3], const uint64_t hi[3], void *dst,
                    struct brick_error *err)
{
    struct patch *p = (struct patch *)source;
    size_t slice = (size_t)((hi[0] - lo[0]) * (hi[1] - lo[1])) * brick_type_bytes(source->type);
    for (uint64_t z = lo[2]; z < hi[2];) {
        int code = need_slab(p, lo, hi, z, err);
        if (code) {
            p->slab = (struct box){{0}, {0}};
            return code;
        }
        uint64_t end = hi[2] < p->slab.hi[2] ? hi[2] : p->slab.hi[2];
        memcpy((unsigned char *)dst + (size_t)(z - lo[2]) * slice,
               p->slab_voxels + (size_t)(z - p->slab.lo[2]) * slice, (size_t)(end - z) * slice);
        z = end;
    }
    return BRICK_OK;
}

static int read_slices(struct brick_source *source, uint64_t z, uint64_t count, void *dst,
                       struct brick_error *err)
{
    const uint64_t *n = source->geometry.dims;
    return read_box(source, (const uint64_t[3]){0, 0, z}, (const uint64_t[3]){n[0], n[1], z + count}, dst,
                    err);
}

int patch_init(struct patch *p, const struct salvage *s, struct brick_error *err)
{
    const struct brick_grid *grid = s->grid;
    size_t payload = brick_grid_max_payload_bytes(grid);
    *p = (struct patch){.salvage = s,
                        .fill = INFINITY,
                        .brick = malloc(payload),
                        .core = malloc(payload),
                        .known = malloc((size_t)grid->edge * grid->edge * grid->edge)};
    p->base = (struct brick_source){.geometry = {.slope = grid->slope, .intercept = grid->intercept},
                                    .type = grid->type,
                                    .provenance = brick_volume_provenance(s->volume),
                                    .held_slices = grid->edge,
                                    .read = read_slices,
                                    .read_box = read_box};
    memcpy(p->base.geometry.dims, grid->dims, sizeof grid->dims);
    memcpy(p->base.geometry.affine, grid->affine, sizeof grid->affine);
    uint64_t end = grid->levels > 1 ? grid->level[1].first_brick : grid->bricks;
    for (uint64_t id = 0; id < end; id++)
        if (s->state[id] & SALVAGE_VOXELS)
            p->fill = fmin(p->fill, (double)brick_volume_entry(s->volume, id)->min);
    if (grid->type == BRICK_F32)
        p->fill = NAN;
    else if (isinf(p->fill))
        p->fill = 0.0;
    return p->brick && p->core && p->known
               ? BRICK_OK
               : brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", brick_volume_path(s->volume));
}

void patch_finish(struct patch *p)
{
    brick_scratch_finish(&p->scratch);
    free(p->brick);
    free(p->core);
    free(p->known);
    free(p->slab_voxels);
    *p = (struct patch){0};
}
