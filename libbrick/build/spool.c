/* Layout: slot z % capacity holds three whole slices: voxels, min, max. */
#include "spool.h"

int spool_init(struct spool *s, const char *path, const struct brick_level *level, uint64_t capacity,
               size_t width, struct brick_error *err)
{
    *s = (struct spool){BRICK_IO_CLOSED, level, capacity, width};
    int code = brick_io_create_scratch(&s->io, path, err);
    /* Resuming reads slices that were not written, though nothing that lasts is made of them. */
    return code ? code : brick_io_truncate(&s->io, capacity * spool_at(s, 3, 0, 0, 0), err);
}

void spool_finish(struct spool *s)
{
    brick_io_close(&s->io);
}

uint64_t spool_at(const struct spool *s, uint64_t array, uint64_t x, uint64_t y, uint64_t z)
{
    const uint64_t *n = s->level->dims;
    return ((((z % s->capacity) * 3 + array) * n[1] + y) * n[0] + x) * (uint64_t)s->width;
}

struct transfer {
    const struct spool *spool;
    const struct window *window;
    const struct box *box;
    bool write;
};

static int transfer_slice(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    (void)worker;
    const struct transfer *t = context;
    const struct spool *s = t->spool;
    const struct box *box = t->box;
    const uint64_t *n = s->level->dims;
    unsigned char *const arrays[3] = {t->window->voxels, t->window->min, t->window->max};
    uint64_t z = box->lo[2] + item / 3, array = item % 3, lines = 1;
    /* rows that lie behind each other in both go at once */
    if (box->lo[0] == 0 && box->hi[0] == n[0] && t->window->size[0] == n[0])
        lines = box->hi[1] - box->lo[1];
    size_t bytes = (size_t)(lines * (box->hi[0] - box->lo[0])) * s->width;
    int code = BRICK_OK;
    for (uint64_t y = box->lo[1]; !code && y < box->hi[1]; y += lines) {
        uint64_t offset = spool_at(s, array, box->lo[0], y, z);
        unsigned char *memory = arrays[array] + window_at(t->window, box->lo[0], y, z);
        code = t->write ? brick_io_write_at(&s->io, offset, memory, bytes, err)
                        : brick_io_read_at(&s->io, offset, memory, bytes, err);
    }
    return code;
}

static int transfer(const struct spool *spool, struct brick_pool *pool, const struct window *window,
                    const struct box *box, bool write, struct brick_error *err)
{
    struct transfer t = {spool, window, box, write};
    return brick_pool_run(pool, 3 * (box->hi[2] - box->lo[2]), transfer_slice, &t, err);
}

int spool_write(const struct spool *spool, struct brick_pool *pool, const struct window *window,
                const struct box *box, struct brick_error *err)
{
    return transfer(spool, pool, window, box, true, err);
}

int spool_read(const struct spool *spool, struct brick_pool *pool, const struct window *window,
               const struct box *box, struct brick_error *err)
{
    return transfer(spool, pool, window, box, false, err);
}
