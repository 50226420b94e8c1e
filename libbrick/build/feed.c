/* Reading ahead. Invariants: the reading thread writes only slots that no unreleased tile uses; the source is
 * called from that thread only, in ascending order (whole slices) or tile by tile (boxes). */
#include "feed.h"

#include <stdlib.h>
#include <string.h>

#include <brick/threads.h>

#include "convert.h"

enum { CHUNK_BYTES = 4 << 20 };

int feed_init(struct feed *f, struct brick_source *source, const struct brick_grid *grid,
              const struct plan *plan, bool round_to_f32, struct brick_error *err)
{
    *f = (struct feed){.source = source, .grid = grid, .plan = plan, .round_to_f32 = round_to_f32};
    pthread_mutex_init(&f->lock, NULL);
    pthread_cond_init(&f->changed, NULL);
    const struct brick_level *level = &grid->level[0];
    for (int i = 0; i < (plan->boxes ? 2 : 1); i++) {
        struct window *w = &f->window[i];
        *w = (struct window){.level = level, .width = brick_type_bytes(grid->type)};
        w->capacity = plan->ring_slices;
        w->size[0] = level->dims[0];
        w->size[1] = level->dims[1];
        w->voxels = malloc(plan->boxes ? plan->box_bytes : window_slice_bytes(w) * w->capacity);
        w->min = w->max = w->voxels;
        if (!w->voxels)
            return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for level 0");
    }
    if (plan->staging_bytes && !(f->staging = malloc(plan->staging_bytes)))
        return brick_fail(err, BRICK_ERR_MEMORY, "out of memory to convert voxels");
    return BRICK_OK;
}

/* Read a box of one or more slices, whole ones unless the plan has boxes, to dst in the stored type. */
static int read_box(struct feed *f, const struct box *box, unsigned char *dst, struct brick_error *err)
{
    struct brick_source *s = f->source;
    uint64_t count = box->hi[2] - box->lo[2], nx = box->hi[0] - box->lo[0], ny = box->hi[1] - box->lo[1];
    uint64_t step = f->staging ? f->plan->staging_bytes / (nx * ny * brick_type_bytes(s->type)) : count;
    for (uint64_t done = 0; done < count;) {
        uint64_t n = count - done < step ? count - done : step, z = box->lo[2] + done;
        void *to = f->staging ? f->staging : dst;
        const uint64_t lo[3] = {box->lo[0], box->lo[1], z}, hi[3] = {box->hi[0], box->hi[1], z + n};
        int code = f->plan->boxes ? s->read_box(s, lo, hi, to, err) : s->read(s, z, n, to, err);
        for (uint64_t line = 0; f->staging && !code && line < n * ny; line++) {
            const uint64_t *dims = f->grid->level[0].dims;
            uint64_t first = ((z + line / ny) * dims[1] + box->lo[1] + line % ny) * dims[0] + box->lo[0];
            code = convert_to_f32(
                s->type, (unsigned char *)f->staging + line * nx * brick_type_bytes(s->type),
                (float *)(void *)dst + (done * ny + line) * nx, nx, f->round_to_f32, first, err);
        }
        if (code)
            return code;
        done += n;
    }
    return BRICK_OK;
}

/* Wait until `read` may grow by n: false when there is no one left to read for. */
static bool wait_for_room(struct feed *f, uint64_t n, uint64_t capacity)
{
    pthread_mutex_lock(&f->lock);
    while (!f->quit && f->read + n - f->released > capacity)
        pthread_cond_wait(&f->changed, &f->lock);
    bool go = !f->quit;
    pthread_mutex_unlock(&f->lock);
    return go;
}

static bool did_read(struct feed *f, uint64_t n, int code, const struct brick_error *error, uint64_t start,
                     uint64_t bytes)
{
    pthread_mutex_lock(&f->lock);
    f->read += code ? 0 : n;
    f->cost.ns += brick_now_ns() - start;
    f->cost.bytes += bytes;
    if (code) {
        f->code = code;
        f->error = *error;
    }
    pthread_cond_broadcast(&f->changed);
    pthread_mutex_unlock(&f->lock);
    return code == 0;
}

static void read_ring(struct feed *f)
{
    struct window *w = &f->window[0];
    const uint64_t *dims = f->grid->level[0].dims;
    size_t slice = window_slice_bytes(w);
    uint64_t chunk = 1 + CHUNK_BYTES / slice;
    for (uint64_t z = f->read; z < dims[2];) {
        uint64_t n = w->capacity - z % w->capacity; /* up to where the ring wraps */
        if (n > dims[2] - z)
            n = dims[2] - z;
        if (n > chunk)
            n = chunk;
        /* Waiting must not be for room that only the encoding of these slices makes: once every row that is
         * complete is encoded, less than `row` slices are in use; or these do not go beyond the next row. */
        uint64_t row = f->grid->edge + 2 * f->grid->border, rest = w->capacity > row ? w->capacity - row : 0;
        uint64_t to_row = f->grid->edge - (z + f->grid->edge - f->grid->border) % f->grid->edge;
        if (rest < to_row)
            rest = to_row;
        if (n > rest)
            n = rest;
        if (!wait_for_room(f, n, w->capacity))
            return;
        struct brick_error error = {0};
        uint64_t start = brick_now_ns();
        const struct box box = {{0, 0, z}, {dims[0], dims[1], z + n}};
        int code = read_box(f, &box, w->voxels + window_at(w, 0, 0, z), &error);
        if (!did_read(f, n, code, &error, start, n * slice))
            return;
        z += n;
    }
}

static void cover(struct window *w, const struct box *box)
{
    w->capacity = box->hi[2] - box->lo[2];
    for (int a = 0; a < 2; a++) {
        w->lo[a] = box->lo[a];
        w->size[a] = box->hi[a] - box->lo[a];
    }
}

/* Boxes hop from slice to slice, which disks do slowly: the source is told a row of bricks ahead, a tile's
 * share of it at a time, so that it can have all of it fetched in order. */
static void fetch_ahead(struct feed *f, const struct tile *tile)
{
    const struct brick_level *level = &f->grid->level[0];
    uint64_t line = level->bricks[0], done = tile->from[1] * line + tile->from[0] + tile_bricks(tile);
    uint64_t end = tile_stored(f->grid, tile).hi[2] + f->grid->edge * done / (line * level->bricks[1]);
    if (end > level->dims[2])
        end = level->dims[2];
    if (!f->source->fetch || end <= f->fetched)
        return;
    f->source->fetch(f->source, f->fetched, end - f->fetched);
    f->fetched = end;
}

static void read_boxes(struct feed *f)
{
    uint64_t rows = f->grid->level[0].bricks[2], turn = 0;
    struct tile tile = f->first;
    for (uint64_t row = tile.row; row < rows; row++, tile = tile_first(f->grid, f->plan->shape, 0, row)) {
        do {
            struct window *w = &f->window[turn++ % 2];
            if (!wait_for_room(f, 1, 2))
                return;
            struct box box = tile_stored(f->grid, &tile), slice = box;
            struct brick_error error = {0};
            uint64_t start = brick_now_ns();
            cover(w, &box);
            fetch_ahead(f, &tile);
            int code = BRICK_OK;
            for (uint64_t z = box.lo[2]; !code && z < box.hi[2]; z++) {
                slice.lo[2] = z;
                slice.hi[2] = z + 1;
                code = read_box(f, &slice, w->voxels + window_at(w, box.lo[0], box.lo[1], z), &error);
            }
            if (!did_read(f, 1, code, &error, start, w->capacity * window_slice_bytes(w)))
                return;
        } while (tile_next(f->grid, f->plan->shape, &tile));
    }
}

static void *feed_main(void *context)
{
    struct feed *f = context;
    if (f->plan->boxes)
        read_boxes(f);
    else
        read_ring(f);
    return NULL;
}

const struct window *feed_lend(struct feed *f, const struct tile *tile)
{
    struct box core = tile_core(f->grid, tile);
    if (f->plan->boxes)
        cover(&f->window[0], &core);
    return &f->window[0];
}

int feed_start(struct feed *f, const struct tile *first, struct brick_error *err)
{
    f->first = *first;
    f->fetched = tile_stored(f->grid, first).lo[2];
    if (!f->plan->boxes)
        f->read = f->released = tile_stored(f->grid, first).lo[2];
    f->running = brick_thread_start(&f->thread, feed_main, f);
    return f->running ? BRICK_OK
                      : brick_fail(err, BRICK_ERR_MEMORY, "the system refuses to start a thread for reading");
}

void feed_finish(struct feed *f)
{
    if (!f->source)
        return;
    pthread_mutex_lock(&f->lock);
    f->quit = true;
    pthread_cond_broadcast(&f->changed);
    pthread_mutex_unlock(&f->lock);
    if (f->running)
        pthread_join(f->thread, NULL);
    pthread_cond_destroy(&f->changed);
    pthread_mutex_destroy(&f->lock);
    free(f->window[0].voxels);
    free(f->window[1].voxels);
    free(f->staging);
    memset(f, 0, sizeof *f);
}

int feed_take(struct feed *f, const struct tile *tile, const struct window **window, struct brick_error *err)
{
    uint64_t need = f->plan->boxes ? f->taken + 1 : tile_stored(f->grid, tile).hi[2];
    uint64_t start = brick_now_ns();
    pthread_mutex_lock(&f->lock);
    while (!f->code && f->read < need)
        pthread_cond_wait(&f->changed, &f->lock);
    int code = f->read < need ? f->code : BRICK_OK;
    if (code && err)
        *err = f->error;
    pthread_mutex_unlock(&f->lock);
    f->wait_ns += brick_now_ns() - start;
    *window = &f->window[f->plan->boxes ? f->taken % 2 : 0];
    return code;
}

void feed_release(struct feed *f, const struct tile *tile, bool last_of_row)
{
    pthread_mutex_lock(&f->lock);
    f->taken++;
    if (f->plan->boxes)
        f->released++;
    else if (last_of_row)
        f->released = (tile->row + 1) * f->grid->edge - f->grid->border;
    pthread_cond_broadcast(&f->changed);
    pthread_mutex_unlock(&f->lock);
}
