/* The writer. Invariants: PATH is untouched until the rename; PATH.part begins with 512 zero bytes until
 * everything behind them is on disk, so that it never opens as complete; the file's order is level 0, level
 * 1, ... whatever order the levels' bricks come in, because coarser levels wait in a file of their own, each
 * in a part of it that all its payloads fit into: a file with holes, the coarsest level first, so that the
 * largest part is the last. */
#include <brick/writer.h>

#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include <brick/codec.h>
#include <brick/io.h>

#include "journal.h"
#include "layout.h"
#include "payload.h"

enum {
    WRITEBACK_BYTES = 8 << 20 /* the disk is told to begin in pieces of this size, so that syncing is short */
};

struct level_part {
    struct brick_io *io;
    uint64_t start;      /* of its payloads in io */
    uint64_t bytes;      /* of its payloads so far */
    uint64_t next_brick; /* id that must come next */
    uint64_t kept;       /* bricks that were there */
};

struct brick_writer {
    char *path, *part_path, *coarse_path, *journal_path;
    struct brick_io part, coarse; /* coarse: a scratch file when there is no journal */
    struct brick_grid grid;
    struct brick_entry *entries; /* offsets relative to the level's first payload until finishing */
    struct level_part level[BRICK_MAX_LEVELS];
    uint64_t room;    /* of the largest payload */
    bool part_exists; /* PATH.part is this writer's */
    bool spoiled;     /* its header may say that it is complete, and it is not */
    bool leave;       /* it stays when the writer goes */
    bool journaled;
    struct journal journal;
    double tolerance;
    uint64_t flushed; /* PATH.part's first bytes that the disk has been told to write */
};

static char *append(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    char *text = malloc(n + m + 1);
    if (text) {
        memcpy(text, path, n);
        memcpy(text + n, ending, m + 1);
    }
    return text;
}

/* An empty header: the file is not complete. */
static int unseal(const struct brick_writer *w, struct brick_error *err)
{
    static const unsigned char zeros[LAYOUT_HEADER_BYTES];
    return brick_io_write_at(&w->part, 0, zeros, sizeof zeros, err);
}

/* Payloads end where level 0's do, and what was behind them is gone. */
static int drop_rest(struct brick_writer *w, struct brick_error *err)
{
    uint64_t size, end = LAYOUT_HEADER_BYTES + w->level[0].bytes;
    int code = brick_io_size(&w->part, &size, err);
    w->flushed = end;
    return code || size <= end ? code : brick_io_truncate(&w->part, end, err);
}

static uint64_t level_end(const struct brick_grid *g, uint32_t l)
{
    return l + 1 < g->levels ? g->level[l + 1].first_brick : g->bricks;
}

static uint32_t level_of(const struct brick_grid *g, uint64_t id)
{
    uint32_t l = 0;
    while (l + 1 < g->levels && id >= g->level[l + 1].first_brick)
        l++;
    return l;
}

static void lay_out_levels(struct brick_writer *w)
{
    uint64_t start = 0;
    w->room = brick_codec_bound(BRICK_CODEC_LZ4, brick_grid_max_payload_bytes(&w->grid));
    for (uint32_t l = w->grid.levels; l-- > 0;) {
        uint64_t first = w->grid.level[l].first_brick;
        w->level[l] = (struct level_part){&w->coarse, start, .next_brick = first};
        start += (level_end(&w->grid, l) - first) * w->room;
    }
    w->level[0].io = &w->part;
    w->level[0].start = LAYOUT_HEADER_BYTES;
}

int brick_writer_cut(struct brick_writer *w, const uint64_t limit[], struct brick_error *err)
{
    int code = journal_read(&w->journal, w->entries, limit, err);
    for (uint32_t l = 0; l < w->grid.levels; l++) {
        struct level_part *level = &w->level[l];
        uint64_t id = w->grid.level[l].first_brick;
        level->kept = w->journal.bricks[l];
        level->bytes = 0;
        for (level->next_brick = id + level->kept; id < level->next_brick; id++)
            level->bytes += w->entries[id].bytes;
    }
    return code ? code : drop_rest(w, err);
}

/* Begin the files, or go on with what is there. identity may be NULL. */
static int open_files(struct brick_writer *w, const char *identity, bool resume, struct brick_error *err)
{
    uint64_t size = 0, all[BRICK_MAX_LEVELS];
    int code = brick_io_update(&w->part, w->part_path, err);
    if (code)
        return code;
    w->part_exists = true;
    code = resume ? brick_io_size(&w->part, &size, err) : brick_io_truncate(&w->part, 0, err);
    if (code)
        return code;
    w->leave = size > 0; /* should it be another's work */
    if (size && (code = journal_open(&w->journal, w->journal_path, &w->grid, identity, w->part_path, err)))
        return code;
    for (uint32_t l = 0; l < w->grid.levels; l++)
        all[l] = level_end(&w->grid, l) - w->grid.level[l].first_brick;
    if ((code = unseal(w, err)) || (code = size ? brick_writer_cut(w, all, err) : BRICK_OK))
        return code;
    w->leave = w->level[0].kept > 0;
    if (!identity)
        return brick_io_create_scratch(&w->coarse, w->path, err);
    if ((code = w->leave ? brick_io_update(&w->coarse, w->coarse_path, err)
                         : brick_io_create(&w->coarse, w->coarse_path, err)))
        return code;
    return size ? BRICK_OK : journal_create(&w->journal, w->journal_path, &w->grid, identity, err);
}

int brick_writer_create(struct brick_writer **writer, const char *path, const struct brick_grid *grid,
                        struct brick_error *err)
{
    return brick_writer_create_journaled(writer, path, grid, NULL, false, err);
}

int brick_writer_create_journaled(struct brick_writer **writer, const char *path,
                                  const struct brick_grid *grid, const char *identity, bool resume,
                                  struct brick_error *err)
{
    *writer = NULL;
    int code = BRICK_ERR_MEMORY;
    struct brick_writer *w = calloc(1, sizeof *w);
    if (!w)
        return brick_fail(err, code, "%s: out of memory", path);
    w->journal.io = w->part = w->coarse = (struct brick_io)BRICK_IO_CLOSED;
    w->grid = *grid;
    lay_out_levels(w);
    w->journaled = identity != NULL;
    w->path = strdup(path);
    w->part_path = append(path, ".part");
    w->coarse_path = append(path, ".part.levels");
    w->journal_path = append(path, ".part.journal");
    w->entries = calloc(grid->bricks, sizeof *w->entries);
    if (!w->path || !w->part_path || !w->coarse_path || !w->journal_path || !w->entries)
        brick_fail(err, code, "%s: out of memory for an index of %llu bricks", path,
                   (unsigned long long)grid->bricks);
    else
        code = open_files(w, identity, resume && identity, err);
    if (code)
        brick_writer_destroy(&w);
    else
        *writer = w;
    return code;
}

uint64_t brick_writer_kept(const struct brick_writer *w, uint32_t level)
{
    return w->level[level].kept;
}

const struct brick_entry *brick_writer_entry(const struct brick_writer *w, uint64_t id)
{
    return &w->entries[id];
}

/* The file that a kept brick is in, and its entry there. */
static const struct brick_io *find(const struct brick_writer *w, uint64_t id, struct brick_entry *e)
{
    const struct level_part *level = &w->level[level_of(&w->grid, id)];
    *e = w->entries[id];
    if (!(e->flags & BRICK_FLAG_CONSTANT))
        e->offset += level->start;
    return level->io;
}

int brick_writer_check(const struct brick_writer *w, uint64_t id, struct brick_scratch *scratch,
                       struct brick_error *err)
{
    struct brick_entry e;
    const struct brick_io *io = find(w, id, &e);
    return e.flags & BRICK_FLAG_CONSTANT ? BRICK_OK : payload_fetch(io, &e, scratch, err);
}

int brick_writer_read(const struct brick_writer *w, uint64_t id, void *dst, struct brick_scratch *scratch,
                      struct brick_error *err)
{
    struct brick_entry e;
    const struct brick_io *io = find(w, id, &e);
    return payload_read(io, &w->grid, id, &e, dst, scratch, err);
}

bool brick_writer_is_journaled(const struct brick_writer *w)
{
    return w->journaled;
}

int brick_writer_note_begin(struct brick_writer *w, struct brick_error *err)
{
    return journal_note_begin(&w->journal, err);
}

int brick_writer_note_add(struct brick_writer *w, const void *bytes, size_t n, struct brick_error *err)
{
    return journal_note_add(&w->journal, bytes, n, err);
}

int brick_writer_note_end(struct brick_writer *w, struct brick_error *err)
{
    return journal_note_end(&w->journal, err);
}

uint64_t brick_writer_note_bytes(const struct brick_writer *w)
{
    return w->journal.note_bytes;
}

int brick_writer_note_read(const struct brick_writer *w, uint64_t at, void *bytes, size_t n,
                           struct brick_error *err)
{
    return journal_note_read(&w->journal, at, bytes, n, err);
}

uint64_t brick_writer_leave(struct brick_writer *w)
{
    uint64_t bricks = 0;
    if (!w->journaled || w->spoiled)
        return 0;
    (void)journal_flush(&w->journal, NULL); /* a full disk: what was written before is enough */
    for (uint32_t l = 0; l < w->grid.levels; l++)
        bricks += w->journal.bricks[l];
    w->leave = w->leave || bricks > 0;
    return bricks;
}

static void remove_files_for_resuming(const struct brick_writer *w)
{
    if (!w->journaled)
        return;
    unlink(w->coarse_path);
    unlink(w->journal_path);
}

void brick_writer_destroy(struct brick_writer **writer)
{
    struct brick_writer *w = *writer;
    if (!w)
        return;
    if (w->part_exists && (!w->leave || w->spoiled)) {
        unlink(w->part_path);
        remove_files_for_resuming(w);
    }
    journal_close(&w->journal);
    brick_io_close(&w->part);
    brick_io_close(&w->coarse);
    free(w->path);
    free(w->part_path);
    free(w->coarse_path);
    free(w->journal_path);
    free(w->entries);
    free(w);
    *writer = NULL;
}

void brick_writer_set_tolerance(struct brick_writer *writer, double tolerance)
{
    writer->tolerance = tolerance;
}

/* Write to PATH.part, and have the disk begin on what is complete. */
static int write_part(struct brick_writer *w, uint64_t offset, const void *bytes, size_t n,
                      struct brick_error *err)
{
    int code = brick_io_write_at(&w->part, offset, bytes, n, err);
    uint64_t end = offset + n;
    if (!code && end >= w->flushed + WRITEBACK_BYTES) {
        brick_io_start_writeback(&w->part, w->flushed, end - w->flushed);
        w->flushed = end;
    }
    return code;
}

int brick_writer_put(struct brick_writer *w, uint64_t id, const struct brick_entry *entry,
                     const void *payload, size_t bytes, struct brick_error *err)
{
    uint32_t l = level_of(&w->grid, id);
    struct level_part *level = &w->level[l];
    bool constant = entry->flags & BRICK_FLAG_CONSTANT;
    if (id >= w->grid.bricks || id != level->next_brick || constant != (bytes == 0) || bytes > w->room)
        return brick_fail_at(err, BRICK_ERR_ARGUMENT, BRICK_NO_OFFSET, id,
                             "%s: brick %llu is out of order or has an impossible payload", w->path,
                             (unsigned long long)id);
    struct brick_entry *e = &w->entries[id];
    *e = *entry;
    e->offset = constant ? 0 : level->bytes;
    e->bytes = (uint32_t)bytes;
    e->checksum = constant ? 0 : XXH3_64bits(payload, bytes);
    e->reserved = 0;
    if (!constant) {
        uint64_t at = level->start + level->bytes;
        int code = l ? brick_io_write_at(level->io, at, payload, bytes, err)
                     : write_part(w, at, payload, bytes, err);
        if (code)
            return code;
        level->bytes += bytes;
    }
    level->next_brick++;
    return w->journaled ? journal_put(&w->journal, l, e, err) : BRICK_OK;
}

/* Append what waited of a coarser level at `end`. */
static int append_level(struct brick_writer *w, const struct level_part *level, uint64_t end,
                        unsigned char *buffer, size_t room, struct brick_error *err)
{
    int code = BRICK_OK;
    for (uint64_t at = 0; !code && at < level->bytes;) {
        size_t n = level->bytes - at < room ? (size_t)(level->bytes - at) : room;
        code = brick_io_read_at(level->io, level->start + at, buffer, n, err);
        if (!code)
            code = write_part(w, end + at, buffer, n, err);
        at += n;
    }
    return code;
}

static int write_table(struct brick_writer *w, struct layout_extent *extent, uint64_t *end, const void *bytes,
                       size_t n, struct brick_error *err)
{
    *extent = (struct layout_extent){*end, n, XXH3_64bits(bytes, n)};
    *end += n;
    return brick_io_write_at(&w->part, extent->offset, bytes, n, err);
}

static int write_index(struct brick_writer *w, struct layout_extent *extent, uint64_t *end,
                       unsigned char *buffer, size_t room, struct brick_error *err)
{
    XXH3_state_t *hash = XXH3_createState();
    if (!hash)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", w->path);
    XXH3_64bits_reset(hash);
    extent->offset = *end;
    int code = BRICK_OK;
    for (uint64_t id = 0; !code && id < w->grid.bricks;) {
        size_t n = 0;
        for (; id < w->grid.bricks && n + LAYOUT_ENTRY_BYTES <= room; id++, n += LAYOUT_ENTRY_BYTES)
            layout_put_entry(&w->entries[id], buffer + n);
        XXH3_64bits_update(hash, buffer, n);
        code = brick_io_write_at(&w->part, *end, buffer, n, err);
        *end += n;
    }
    extent->bytes = *end - extent->offset;
    extent->checksum = XXH3_64bits_digest(hash);
    XXH3_freeState(hash);
    return code;
}

int brick_writer_finish(struct brick_writer *w, const struct brick_stats *stats, const char *provenance,
                        uint64_t *file_bytes, struct brick_error *err)
{
    const struct brick_grid *g = &w->grid;
    struct layout_header h = {.type = g->type,
                              .edge = g->edge,
                              .border = g->border,
                              .macrocell = g->macrocell,
                              .levels = g->levels,
                              .geometry = {.slope = g->slope, .intercept = g->intercept},
                              .tolerance = w->tolerance};
    memcpy(h.geometry.dims, g->dims, sizeof g->dims);
    memcpy(h.geometry.affine, g->affine, sizeof g->affine);
    size_t stats_bytes = LAYOUT_STATS_BYTES + (size_t)8 * stats->bins, text_bytes = strlen(provenance);
    size_t room = (size_t)1 << 20;
    if (room < stats_bytes)
        room = stats_bytes;
    for (uint32_t l = 0; l < g->levels; l++)
        if (w->level[l].next_brick != level_end(g, l))
            return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: level %u is not complete", w->path, l);
    if (text_bytes > LAYOUT_MAX_TEXT)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: provenance of %zu bytes is too long", w->path,
                          text_bytes);
    bool sealed = false;
    unsigned char *buffer = malloc(room);
    if (!buffer)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", w->path);

    int code = w->journaled ? journal_flush(&w->journal, err) : BRICK_OK;
    uint64_t end = LAYOUT_HEADER_BYTES;
    for (uint32_t l = 0; !code && l < g->levels; l++) {
        for (uint64_t id = g->level[l].first_brick; id < w->level[l].next_brick; id++)
            if (!(w->entries[id].flags & BRICK_FLAG_CONSTANT))
                w->entries[id].offset += end;
        if (l)
            code = append_level(w, &w->level[l], end, buffer, room, err);
        end += w->level[l].bytes;
    }
    unsigned char levels[BRICK_MAX_LEVELS * LAYOUT_LEVEL_BYTES];
    for (uint32_t l = 0; l < g->levels; l++)
        layout_put_level(&g->level[l], levels + (size_t)l * LAYOUT_LEVEL_BYTES);
    if (code ||
        (code = write_table(w, &h.table[LAYOUT_LEVELS], &end, levels, (size_t)g->levels * LAYOUT_LEVEL_BYTES,
                            err)) ||
        (code = write_index(w, &h.table[LAYOUT_INDEX], &end, buffer, room, err)))
        goto done;
    layout_put_stats(stats, buffer);
    if ((code = write_table(w, &h.table[LAYOUT_STATS], &end, buffer, stats_bytes, err)) ||
        (code = write_table(w, &h.table[LAYOUT_PROVENANCE], &end, provenance, text_bytes, err)))
        goto done;
    h.file_bytes = end;
    unsigned char header[LAYOUT_HEADER_BYTES];
    layout_put_header(&h, header);
    if ((code = brick_io_sync(&w->part, err)))
        goto done;
    sealed = true;
    if ((code = brick_io_write_at(&w->part, 0, header, sizeof header, err)) ||
        (code = brick_io_sync(&w->part, err)) || (code = brick_io_rename(w->part_path, w->path, err)))
        goto done;
    w->part_exists = false;
    remove_files_for_resuming(w);
    *file_bytes = end;
done:
    /* What may be left must not open as complete, not even when only the last sync or the new name failed. */
    if (code && sealed)
        w->spoiled = unseal(w, NULL) != BRICK_OK;
    free(buffer);
    return code;
}
