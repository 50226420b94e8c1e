/* Invariant: a brick is taken only after its checksum was right, so that what was in the file before a power
 * cut is either used whole or made again. */
#include "kept.h"

#include <string.h>

enum { CHECKED_AT_ONCE = 16 };

struct check {
    struct kept *kept;
    uint64_t first_brick;
    uint64_t *good; /* of the level's bricks: up to the first damaged one */
    pthread_mutex_t lock;
};

/* Several bricks at a time: one takes no longer than waking a worker. */
static int check_some(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct check *c = context;
    struct brick_scratch *scratch = &c->kept->encoders[worker].stored;
    uint64_t from = item * CHECKED_AT_ONCE, clock = brick_thread_ns();
    pthread_mutex_lock(&c->lock);
    uint64_t good = *c->good;
    pthread_mutex_unlock(&c->lock);
    for (uint64_t i = from; i < from + CHECKED_AT_ONCE && i < good; i++) {
        int code = brick_writer_check(c->kept->writer, c->first_brick + i, scratch, err);
        if (code != BRICK_ERR_CHECKSUM && code != BRICK_ERR_FORMAT) {
            if (code)
                return code;
            continue;
        }
        pthread_mutex_lock(&c->lock);
        *c->good = i < *c->good ? i : *c->good;
        pthread_mutex_unlock(&c->lock);
        break;
    }
    costs_add(&c->kept->costs[worker], BRICK_STAGE_RESUME, &clock, 0);
    return BRICK_OK;
}

int kept_check(struct kept *k, struct brick_error *err)
{
    uint64_t good[BRICK_MAX_LEVELS];
    bool all = true;
    for (uint32_t l = 0; l < k->grid->levels; l++) {
        uint64_t n = good[l] = brick_writer_kept(k->writer, l);
        struct check c = {k, k->grid->level[l].first_brick, &good[l], PTHREAD_MUTEX_INITIALIZER};
        int code = brick_pool_run(k->pool, (n + CHECKED_AT_ONCE - 1) / CHECKED_AT_ONCE, check_some, &c, err);
        if (code)
            return code;
        all = all && good[l] == n;
    }
    return all ? BRICK_OK : brick_writer_cut(k->writer, good, err);
}

uint64_t kept_in_tile(const struct kept *k, const struct tile *tile)
{
    uint64_t first = tile_first_brick(k->grid, tile), kept = brick_writer_kept(k->writer, 0);
    uint64_t n = kept > first ? kept - first : 0;
    return n < tile_bricks(tile) ? n : tile_bricks(tile);
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

struct take {
    struct kept *kept;
    const struct window *window;
    uint64_t first_brick, first_ticket;
};

static int take_one(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    const struct take *t = context;
    struct kept *k = t->kept;
    struct encoder *e = &k->encoders[worker];
    uint64_t id = t->first_brick + item, ticket = t->first_ticket + item, start = brick_now_ns();
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
    if (t->window)
        lay_out(k->grid, &place, t->window, e->payload);
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
    struct take t = {k, window, tile_first_brick(k->grid, tile), ticket};
    k->decoded += bricks;
    return bricks ? brick_pool_run(k->pool, bricks, take_one, &t, err) : BRICK_OK;
}
