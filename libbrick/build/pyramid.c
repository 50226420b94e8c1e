/* Invariants: a level's store (ring of slices in memory, or spool) holds every slice that its next row of
 * bricks needs and that has been made; rows are encoded as soon as they are complete, so the order of bricks
 * depends on the sizes alone; a tile's bricks and the next level's voxels under it are made in one go, all
 * workers on both. */
#include "pyramid.h"

#include <stdlib.h>
#include <string.h>

#include "downsample.h"

enum { ITEM_BYTES = 64 << 10 }; /* of input to one item of downsampling */

static int allocate(struct window *w, uint64_t bytes, struct brick_error *err)
{
    w->voxels = malloc(bytes);
    w->min = malloc(bytes);
    w->max = malloc(bytes);
    return w->voxels && w->min && w->max
               ? BRICK_OK
               : brick_fail(err, BRICK_ERR_MEMORY, "out of memory for slabs of %llu bytes",
                            (unsigned long long)bytes);
}

static void release(struct window *w)
{
    free(w->voxels);
    free(w->min);
    free(w->max);
}

int pyramid_init(struct pyramid *p, const char *path, struct brick_error *err)
{
    size_t width = brick_type_bytes(p->grid->type);
    int code = BRICK_OK;
    for (uint32_t l = 0; l < BRICK_MAX_LEVELS; l++)
        p->spool[l].io = (struct brick_io)BRICK_IO_CLOSED;
    for (uint32_t l = 1; !code && l < p->grid->levels; l++) {
        const struct brick_level *level = &p->grid->level[l];
        uint64_t slices = plan_coarse_slices(p->grid, l);
        if (l < p->plan->first_in_memory) {
            code = spool_init(&p->spool[l], path, level, slices, width, err);
            continue;
        }
        struct window *w = &p->window[l];
        *w = (struct window){
            .level = level, .size = {level->dims[0], level->dims[1]}, .capacity = slices, .width = width};
        code = allocate(w, window_slice_bytes(w) * slices, err);
    }
    p->in.width = p->out.width = width;
    if (!code && p->plan->in_bytes)
        code = allocate(&p->in, p->plan->in_bytes, err);
    if (!code && p->plan->out_bytes)
        code = allocate(&p->out, p->plan->out_bytes, err);
    return code;
}

void pyramid_finish(struct pyramid *p)
{
    for (uint32_t l = 1; p->grid && l < p->grid->levels; l++) {
        release(&p->window[l]);
        spool_finish(&p->spool[l]);
    }
    release(&p->in);
    release(&p->out);
    memset(p, 0, sizeof *p);
}

static void cover(struct window *w, const struct brick_level *level, const struct box *box)
{
    w->level = level;
    w->capacity = box->hi[2] - box->lo[2];
    for (int a = 0; a < 2; a++) {
        w->lo[a] = box->lo[a];
        w->size[a] = box->hi[a] - box->lo[a];
    }
}

struct tile_job {
    struct pyramid *p;
    const struct window *fine, *coarse;
    struct box box; /* of coarse voxels */
    bool halved[3];
    uint64_t first_brick, bricks, first_ticket;
    uint64_t lines; /* of an item of downsampling */
};

/* Lines [item * lines, (item + 1) * lines) of the box, counted through all its slices. */
static void downsample_item(const struct tile_job *j, uint64_t item, struct costs *costs)
{
    uint64_t clock = brick_thread_ns(), n = j->box.hi[0] - j->box.lo[0], ny = j->box.hi[1] - j->box.lo[1];
    uint64_t line = item * j->lines, end = line + j->lines, all = ny * (j->box.hi[2] - j->box.lo[2]);
    uint64_t below = j->fine->width << (j->halved[0] + j->halved[1] + j->halved[2]);
    if (end > all)
        end = all;
    costs->stage[BRICK_STAGE_DOWNSAMPLE].bytes += n * (end - line) * below;
    for (; line < end; line++)
        downsample_row(j->p->kernels, j->fine, j->coarse, j->halved, j->p->grid->type, j->p->nearest,
                       j->box.lo[0], n, j->box.lo[1] + line % ny, j->box.lo[2] + line / ny);
    costs_add(costs, BRICK_STAGE_DOWNSAMPLE, &clock, 0);
}

static int tile_item(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    const struct tile_job *j = context;
    if (item < j->bricks)
        return j->p->brick(j->p->context, j->fine, j->first_brick + item, j->first_ticket + item, worker,
                           err);
    downsample_item(j, item - j->bricks, &j->p->costs[worker]);
    return BRICK_OK;
}

static void charge_spool(struct pyramid *p, const struct box *box, uint64_t start)
{
    uint64_t voxels = 1;
    for (int a = 0; a < 3; a++)
        voxels *= box->hi[a] - box->lo[a];
    p->spool_cost.ns += (brick_now_ns() - start) * brick_pool_threads(p->pool);
    p->spool_cost.bytes += 3 * voxels * p->in.width;
}

int pyramid_tile(struct pyramid *p, const struct tile *tile, const struct window *window,
                 struct brick_error *err)
{
    uint32_t next = tile->level + 1;
    bool coarser = next < p->grid->levels, spooled = coarser && next < p->plan->first_in_memory;
    struct tile_job j = {.p = p,
                         .fine = window,
                         .first_brick = tile_first_brick(p->grid, tile),
                         .bricks = tile_bricks(tile),
                         .first_ticket = p->tickets};
    uint64_t first_new = p->first_new[tile->level];
    if (first_new > j.first_brick) {
        uint64_t skip = first_new - j.first_brick < j.bricks ? first_new - j.first_brick : j.bricks;
        j.first_brick += skip;
        j.bricks -= skip;
    }
    uint64_t items = j.bricks;
    p->tickets += j.bricks;
    if (coarser) {
        j.box = tile_coarse(p->grid, tile, j.halved);
        j.coarse = spooled ? &p->out : &p->window[next];
        if (spooled)
            cover(&p->out, &p->grid->level[next], &j.box);
        uint64_t lines = (j.box.hi[1] - j.box.lo[1]) * (j.box.hi[2] - j.box.lo[2]);
        j.lines = 1 + ITEM_BYTES / 8 / ((j.box.hi[0] - j.box.lo[0]) * window->width);
        if (lines <= j.lines)
            downsample_item(&j, 0, &p->costs[0]); /* less work than waking a worker */
        else
            items += (lines + j.lines - 1) / j.lines;
    }
    int code = brick_pool_run(p->pool, items, tile_item, &j, err);
    if (code || !spooled)
        return code;
    uint64_t start = brick_now_ns();
    code = spool_write(&p->spool[next], p->pool, &p->out, &j.box, err);
    charge_spool(p, &j.box, start);
    return code;
}

/* Slices that row `row` needs: [0, row_end). */
static uint64_t row_end(const struct pyramid *p, uint32_t l, uint64_t row)
{
    uint64_t end = (row + 1) * p->grid->edge + p->grid->border, n = p->grid->level[l].dims[2];
    return end < n ? end : n;
}

static int encode_row(struct pyramid *p, uint32_t l, struct brick_error *err)
{
    struct tile tile = tile_first(p->grid, p->plan->shape, l, p->next_row[l]);
    bool spooled = l < p->plan->first_in_memory;
    int code = BRICK_OK;
    do {
        const struct window *w = spooled ? &p->in : &p->window[l];
        if (spooled) {
            struct box box = tile_stored(p->grid, &tile);
            uint64_t start = brick_now_ns();
            cover(&p->in, &p->grid->level[l], &box);
            code = spool_read(&p->spool[l], p->pool, &p->in, &box, err);
            charge_spool(p, &box, start);
        }
        if (!code)
            code = pyramid_tile(p, &tile, w, err);
    } while (!code && tile_next(p->grid, p->plan->shape, &tile));
    return code;
}

/* How many slices of level l the rows [0, rows) of the finer level make. */
static uint64_t slices_made(const struct pyramid *p, uint32_t l, uint64_t rows)
{
    bool halved[3];
    if (rows == 0)
        return 0;
    struct tile tile = tile_first(p->grid, p->plan->shape, l - 1, rows - 1);
    return tile_coarse(p->grid, &tile, halved).hi[2];
}

static bool row_is_complete(const struct pyramid *p, uint32_t l)
{
    return p->next_row[l] < p->grid->level[l].bricks[2] && p->filled[l] >= row_end(p, l, p->next_row[l]);
}

int pyramid_row_done(struct pyramid *p, uint32_t l, uint64_t row, struct brick_error *err)
{
    uint32_t next = l + 1;
    if (next == p->grid->levels)
        return BRICK_OK;
    p->filled[next] = slices_made(p, next, row + 1);
    int code = BRICK_OK;
    while (!code && row_is_complete(p, next)) {
        code = encode_row(p, next, err);
        if (!code)
            code = pyramid_row_done(p, next, p->next_row[next]++, err);
    }
    return code;
}

void pyramid_seek(struct pyramid *p, uint64_t rows)
{
    for (uint32_t l = 1; l < p->grid->levels; l++) {
        p->filled[l] = slices_made(p, l, rows);
        for (p->next_row[l] = 0; row_is_complete(p, l);)
            p->next_row[l]++;
        rows = p->next_row[l];
    }
}

void pyramid_carry(const struct pyramid *p, uint64_t from, uint64_t lo[], uint64_t hi[])
{
    const uint64_t edge = p->grid->edge, border = p->grid->border;
    for (uint32_t l = 1; l < p->grid->levels; l++) {
        uint64_t core = p->next_row[l] * edge, made = slices_made(p, l, from);
        hi[l] = p->filled[l] < made ? p->filled[l] : made;
        lo[l] = core > border ? core - border : 0;
        if (lo[l] > hi[l] || p->next_row[l] == p->grid->level[l].bricks[2])
            lo[l] = hi[l];
        from = (made + edge - 1) / edge; /* rows that are made again from their first slice on */
    }
}
