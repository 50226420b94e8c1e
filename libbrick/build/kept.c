/* Invariant: a brick is taken only after its checksum was right, so that what was in the file before a power
 * cut is either used whole or made again. */
#include "kept.h"

#include <string.h>

struct job {
    struct kept *kept;
    const struct window *window;
    uint64_t first_brick, first_ticket;
};

static int check_one(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    const struct job *j = context;
    struct brick_scratch *scratch = &j->kept->encoders[worker].stored;
    int code = brick_writer_check(j->kept->writer, j->first_brick + item, scratch, err);
    if (code && err)
        err->brick = j->first_brick + item;
    return code;
}

int kept_check(struct kept *k, const struct tile *tile, uint64_t *bricks, struct brick_error *err)
{
    struct job j = {.kept = k, .first_brick = tile_first_brick(k->grid, tile)};
    uint64_t n = k->bricks > j.first_brick ? k->bricks - j.first_brick : 0;
    *bricks = n < tile_bricks(tile) ? n : tile_bricks(tile);
    if (*bricks == 0)
        return BRICK_OK;
    struct brick_error error = {0};
    int code = brick_pool_run(k->pool, *bricks, check_one, &j, &error);
    if (code == BRICK_ERR_CHECKSUM || code == BRICK_ERR_FORMAT) {
        k->bricks = error.brick;
        *bricks = error.brick - j.first_brick;
        return brick_writer_cut(k->writer, k->bricks, err);
    }
    if (code && err)
        *err = error;
    return code;
}

/* The core of a decoded brick to its place. */
static void lay_out(const struct brick_grid *grid, const struct brick_place *place, const struct window *w,
                    const unsigned char *voxels)
{
    size_t stride[2] = {place->stored[0] * w->width, (size_t)place->stored[1] * place->stored[0] * w->width};
    uint64_t lo[3];
    for (int a = 0; a < 3; a++)
        lo[a] = place->at[a] * grid->edge;
    voxels += grid->border * (stride[1] + stride[0] + w->width);
    for (uint32_t z = 0; z < place->core[2]; z++)
        for (uint32_t y = 0; y < place->core[1]; y++)
            memcpy(w->voxels + window_at(w, lo[0], lo[1] + y, lo[2] + z),
                   voxels + z * stride[1] + y * stride[0], place->core[0] * w->width);
}

static int take_one(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    const struct job *j = context;
    struct kept *k = j->kept;
    struct encoder *e = &k->encoders[worker];
    uint64_t id = j->first_brick + item, ticket = j->first_ticket + item, start = brick_now_ns();
    struct encoded *out = drain_slot(k->drain, ticket);
    k->costs[worker].wait_write_ns += brick_now_ns() - start;
    if (!out)
        return drain_flush(k->drain, ticket, err);
    uint64_t clock = brick_thread_ns();
    int code = brick_writer_read(k->writer, id, e->payload, &e->stored, err);
    if (code)
        return code;
    struct brick_place place;
    brick_grid_place(k->grid, id, &place);
    size_t voxel_bytes = brick_place_voxel_bytes(k->grid, &place);
    if (j->window)
        lay_out(k->grid, &place, j->window, e->payload);
    costs_add(&k->costs[worker], BRICK_STAGE_RESUME, &clock, voxel_bytes);
    out->id = id;
    out->level0 = out->written = true;
    out->entry = *brick_writer_entry(k->writer, id);
    out->bytes = out->entry.bytes;
    tally_brick(&k->tallies[worker], e->kernels, k->grid, &place, e->payload, e->payload + voxel_bytes,
                &out->moments);
    costs_add(&k->costs[worker], BRICK_STAGE_COUNT, &clock, voxel_bytes);
    drain_ready(k->drain, ticket);
    return BRICK_OK;
}

int kept_take(struct kept *k, const struct tile *tile, uint64_t bricks, const struct window *window,
              uint64_t ticket, struct brick_error *err)
{
    struct job j = {k, window, tile_first_brick(k->grid, tile), ticket};
    return bricks ? brick_pool_run(k->pool, bricks, take_one, &j, err) : BRICK_OK;
}
