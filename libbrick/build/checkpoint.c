/* The finest of the coarser levels have by far the largest slices, and need them for the shortest time: they
 * are made again from the last rows of level 0. A checkpoint comes one row before a multiple of four, where
 * levels 1 and 2, all axes being halved, wait with only half a row of bricks and their border. Three rows of
 * level 0 make that again but for the border of level 2, so that, with bricks of 32, two slices of that level
 * and 18 or 34 of each coarser one are put down: a hundredth of the source's bytes since the last one.
 */
#include "checkpoint.h"

#include <string.h>

enum {
    ROWS_AGAIN = 3,
    ROWS_APART = 4,
    MOST = 16,  /* checkpoints in a volume, but for the one at its end */
    WORTH = 16, /* the slices are at most this part of level 0's bytes since the last one */
    PAIRS = 2048,
    BUFFER_BYTES = 1 << 16
};

/* How a note begins. Then come the histogram's bins that are not 0, each with its count; then slices. */
struct head {
    uint64_t rows, bins;
    struct tally_moments moments;
    double min, max;
};

static bool has_place(const struct brick_grid *grid, uint64_t rows)
{
    uint64_t all = grid->level[0].bricks[2], apart = ROWS_APART;
    while (apart * MOST < all)
        apart *= 2;
    return rows == all || rows % apart == apart - 1;
}

static uint64_t first_again(const struct brick_grid *grid, uint64_t rows)
{
    return rows == grid->level[0].bricks[2] ? rows : rows - ROWS_AGAIN;
}

static uint64_t slice_bytes(const struct brick_grid *grid, uint32_t l)
{
    return grid->level[l].dims[0] * grid->level[l].dims[1] * brick_type_bytes(grid->type);
}

bool checkpoint_due(const struct checkpoint *c, uint64_t rows)
{
    const struct brick_grid *grid = c->pyramid->grid;
    uint64_t lo[BRICK_MAX_LEVELS], hi[BRICK_MAX_LEVELS], bytes = 0;
    if (!brick_writer_is_journaled(c->writer) || rows <= c->last || !has_place(grid, rows))
        return false;
    pyramid_carry(c->pyramid, first_again(grid, rows), lo, hi);
    for (uint32_t l = 1; l < grid->levels; l++)
        bytes += 3 * (hi[l] - lo[l]) * slice_bytes(grid, l);
    return bytes <= (rows - c->last) * grid->edge * slice_bytes(grid, 0) / WORTH;
}

struct cursor {
    struct brick_writer *writer;
    bool saving;
    uint64_t at; /* when loading */
};

static int move(struct cursor *c, void *bytes, size_t n, struct brick_error *err)
{
    if (c->saving)
        return brick_writer_note_add(c->writer, bytes, n, err);
    c->at += n;
    return brick_writer_note_read(c->writer, c->at - n, bytes, n, err);
}

static int move_spooled(struct cursor *c, const struct spool *spool, uint64_t array, uint64_t z,
                        uint64_t bytes, struct brick_error *err)
{
    unsigned char buffer[BUFFER_BYTES];
    uint64_t at = spool_at(spool, array, 0, 0, z);
    int code = BRICK_OK;
    while (!code && bytes) {
        size_t n = bytes < sizeof buffer ? (size_t)bytes : sizeof buffer;
        if ((c->saving && (code = brick_io_read_at(&spool->io, at, buffer, n, err))) ||
            (code = move(c, buffer, n, err)) ||
            (!c->saving && (code = brick_io_write_at(&spool->io, at, buffer, n, err))))
            return code;
        at += n;
        bytes -= n;
    }
    return code;
}

static int move_slices(struct cursor *c, const struct pyramid *p, uint64_t first, struct brick_error *err)
{
    uint64_t lo[BRICK_MAX_LEVELS], hi[BRICK_MAX_LEVELS];
    int code = BRICK_OK;
    pyramid_carry(p, first, lo, hi);
    for (uint32_t l = 1; l < p->grid->levels; l++) {
        const struct window *w = &p->window[l];
        unsigned char *const arrays[3] = {w->voxels, w->min, w->max};
        uint64_t bytes = slice_bytes(p->grid, l);
        for (uint64_t i = 3 * lo[l]; !code && i < 3 * hi[l]; i++)
            code = l < p->plan->first_in_memory
                       ? move_spooled(c, &p->spool[l], i % 3, i / 3, bytes, err)
                       : move(c, arrays[i % 3] + window_at(w, 0, 0, i / 3), bytes, err);
    }
    return code;
}

static int save_bins(struct cursor *c, const uint64_t *bins, struct brick_error *err)
{
    uint64_t pairs[PAIRS][2];
    size_t n = 0;
    int code = BRICK_OK;
    for (uint64_t i = 0; !code && i < TALLY_BINS; i++) {
        if (bins[i]) {
            pairs[n][0] = i;
            pairs[n++][1] = bins[i];
        }
        if (n == PAIRS || (n && i + 1 == TALLY_BINS)) {
            code = move(c, pairs, n * sizeof pairs[0], err);
            n = 0;
        }
    }
    return code;
}

int checkpoint_save(struct checkpoint *c, uint64_t rows, struct brick_error *err)
{
    struct cursor cursor = {c->writer, true, 0};
    int code = drain_flush(c->drain, c->pyramid->tickets, err);
    if (code || (code = brick_writer_note_begin(c->writer, err)))
        return code;
    tally_gather(c->tallies, c->threads);
    struct head head = {
        .rows = rows, .moments = c->drain->moments, .min = c->drain->min, .max = c->drain->max};
    for (uint32_t i = 0; i < TALLY_BINS; i++)
        head.bins += c->tallies[0].bins[i] != 0;
    if ((code = move(&cursor, &head, sizeof head, err)) ||
        (code = save_bins(&cursor, c->tallies[0].bins, err)) ||
        (code = move_slices(&cursor, c->pyramid, first_again(c->pyramid->grid, rows), err)))
        return code;
    c->last = rows;
    return brick_writer_note_end(c->writer, err);
}

/* Are the bricks there that were made when the pyramid is as it is now? */
static bool has_bricks(const struct checkpoint *c, uint64_t rows)
{
    const struct brick_grid *grid = c->pyramid->grid;
    for (uint32_t l = 0; l < grid->levels; l++) {
        const uint64_t *n = grid->level[l].bricks;
        if (brick_writer_kept(c->writer, l) < n[0] * n[1] * (l ? c->pyramid->next_row[l] : rows))
            return false;
    }
    return true;
}

int checkpoint_open(struct checkpoint *c, struct brick_error *err)
{
    const struct brick_grid *grid = c->pyramid->grid;
    struct cursor cursor = {c->writer, false, 0};
    struct head head;
    c->rows = c->first = c->last = 0;
    if (!brick_writer_note_bytes(c->writer))
        return BRICK_OK;
    int code = move(&cursor, &head, sizeof head, err);
    if (code)
        return code;
    /* The note's checksum is right: only another program's would fail here. */
    bool good = head.rows <= grid->level[0].bricks[2] && has_place(grid, head.rows);
    if (good) {
        pyramid_seek(c->pyramid, head.rows);
        good = has_bricks(c, head.rows);
    }
    for (uint64_t i = 0; good && i < head.bins; i++) {
        uint64_t pair[2];
        if ((code = move(&cursor, pair, sizeof pair, err)))
            return code;
        good = pair[0] < TALLY_BINS;
        if (good)
            c->tallies[0].bins[pair[0]] = pair[1];
    }
    if (!good)
        return brick_fail(
            err, BRICK_ERR_FORMAT,
            "what the interrupted conversion has noted makes no sense; without --resume it starts again");
    c->drain->moments = head.moments;
    c->drain->min = head.min;
    c->drain->max = head.max;
    c->rows = c->last = head.rows;
    c->first = first_again(grid, head.rows);
    c->slices_at = cursor.at;
    pyramid_seek(c->pyramid, c->first);
    return BRICK_OK;
}

int checkpoint_load_slices(const struct checkpoint *c, struct brick_error *err)
{
    struct cursor cursor = {c->writer, false, c->slices_at};
    return move_slices(&cursor, c->pyramid, c->first, err);
}
