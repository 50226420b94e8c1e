/* The writer. Invariants: PATH is untouched until the rename; PATH.part begins with 512 zero bytes until
 * everything behind them is on disk, so that it never opens as complete; the file's order is level 0, level
 * 1, ... whatever order the levels' bricks come in, because coarser levels wait: each one's first payloads
 * in chunks of memory, the rest in a scratch file of its own. What is left for resuming is level 0 alone, for
 * coarser levels can be made from it. */
#include <brick/writer.h>

#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include <brick/io.h>

#include "journal.h"
#include "layout.h"
#include "payload.h"

enum {
    CHUNK_BYTES = 1 << 20,
    WRITEBACK_BYTES = 8 << 20 /* the disk is told to begin in pieces of this size, so that syncing is short */
};

struct chunk {
    struct chunk *next;
    unsigned char bytes[CHUNK_BYTES];
};

struct level_file {
    struct brick_io
        io;         /* level 0: PATH.part; others: scratch, opened by the first payload that is not kept */
    uint64_t bytes; /* payload bytes so far */
    uint64_t next_brick; /* id that must come next */
    /* The first `kept` of `bytes` are in chunks, in order; io holds the others, from its byte 0 on. */
    struct chunk *first, *last;
    uint64_t kept;
};

struct brick_writer {
    char *path, *part_path, *journal_path;
    struct brick_grid grid;
    struct brick_entry *entries; /* offsets relative to the level's first payload until finishing */
    struct level_file level[BRICK_MAX_LEVELS];
    bool part_exists; /* PATH.part is this writer's */
    bool spoiled;     /* its header may say that it is complete, and it is not */
    bool leave;       /* it stays when the writer goes */
    bool journaled;
    struct journal journal;
    uint64_t kept;
    double tolerance;
    uint64_t may_keep; /* bytes of chunks still allowed */
    uint64_t flushed;  /* PATH.part's first bytes that the disk has been told to write */
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
    return brick_io_write_at(&w->level[0].io, 0, zeros, sizeof zeros, err);
}

/* Payloads end where level 0's do, and what was behind them is gone. */
static int drop_rest(struct brick_writer *w, struct brick_error *err)
{
    uint64_t size, end = LAYOUT_HEADER_BYTES + w->level[0].bytes;
    int code = brick_io_size(&w->level[0].io, &size, err);
    w->flushed = end;
    return code || size <= end ? code : brick_io_truncate(&w->level[0].io, end, err);
}

static uint64_t level_end(const struct brick_grid *g, uint32_t l)
{
    return l + 1 < g->levels ? g->level[l + 1].first_brick : g->bricks;
}

/* Begin PATH.part, or go on with what is there. identity may be NULL. */
static int open_part(struct brick_writer *w, const char *identity, bool resume, struct brick_error *err)
{
    struct level_file *part = &w->level[0];
    uint64_t size = 0;
    int code = brick_io_update(&part->io, w->part_path, err);
    if (code)
        return code;
    w->part_exists = true;
    code = resume ? brick_io_size(&part->io, &size, err) : brick_io_truncate(&part->io, 0, err);
    if (code)
        return code;
    w->leave = size > 0; /* should it be another's work */
    if (size && (code = journal_open(&w->journal, w->journal_path, identity, w->part_path, w->entries,
                                     level_end(&w->grid, 0), &w->kept, err)))
        return code;
    w->leave = w->kept > 0;
    for (uint64_t id = 0; id < w->kept; id++)
        part->bytes += w->entries[id].bytes;
    part->next_brick = w->kept;
    if ((code = unseal(w, err)) || (code = drop_rest(w, err)))
        return code;
    return size || !identity ? BRICK_OK : journal_create(&w->journal, w->journal_path, identity, err);
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
    w->journal.io = (struct brick_io)BRICK_IO_CLOSED;
    for (int l = 0; l < BRICK_MAX_LEVELS; l++)
        w->level[l].io.fd = -1;
    for (uint32_t l = 0; l < grid->levels; l++)
        w->level[l].next_brick = grid->level[l].first_brick;
    w->grid = *grid;
    w->journaled = identity != NULL;
    w->path = strdup(path);
    w->part_path = append(path, ".part");
    w->journal_path = append(path, ".part.journal");
    w->entries = calloc(grid->bricks, sizeof *w->entries);
    if (!w->path || !w->part_path || !w->journal_path || !w->entries)
        brick_fail(err, code, "%s: out of memory for an index of %llu bricks", path,
                   (unsigned long long)grid->bricks);
    else
        code = open_part(w, identity, resume && identity, err);
    if (code)
        brick_writer_destroy(&w);
    else
        *writer = w;
    return code;
}

uint64_t brick_writer_kept(const struct brick_writer *w)
{
    return w->kept;
}

const struct brick_entry *brick_writer_entry(const struct brick_writer *w, uint64_t id)
{
    return &w->entries[id];
}

/* As it is in PATH.part. */
static struct brick_entry entry_in_part(const struct brick_writer *w, uint64_t id)
{
    struct brick_entry e = w->entries[id];
    if (!(e.flags & BRICK_FLAG_CONSTANT))
        e.offset += LAYOUT_HEADER_BYTES;
    return e;
}

int brick_writer_check(const struct brick_writer *w, uint64_t id, struct brick_scratch *scratch,
                       struct brick_error *err)
{
    struct brick_entry e = entry_in_part(w, id);
    return e.flags & BRICK_FLAG_CONSTANT ? BRICK_OK : payload_fetch(&w->level[0].io, &e, scratch, err);
}

int brick_writer_read(const struct brick_writer *w, uint64_t id, void *dst, struct brick_scratch *scratch,
                      struct brick_error *err)
{
    struct brick_entry e = entry_in_part(w, id);
    return payload_read(&w->level[0].io, &w->grid, id, &e, dst, scratch, err);
}

int brick_writer_cut(struct brick_writer *w, uint64_t kept, struct brick_error *err)
{
    for (uint64_t id = kept; id < w->kept; id++)
        w->level[0].bytes -= w->entries[id].bytes;
    w->kept = w->level[0].next_brick = kept;
    int code = journal_cut(&w->journal, w->entries, kept, err);
    return code ? code : drop_rest(w, err);
}

uint64_t brick_writer_leave(struct brick_writer *w)
{
    if (!w->journaled || w->spoiled)
        return 0;
    (void)journal_flush(&w->journal, NULL); /* a full disk: what was written before is enough */
    w->leave = w->leave || w->journal.entries > 0;
    return w->journal.entries;
}

static void free_chunks(struct level_file *level)
{
    for (struct chunk *c = level->first, *next; c; c = next) {
        next = c->next;
        free(c);
    }
    level->first = level->last = NULL;
}

void brick_writer_destroy(struct brick_writer **writer)
{
    struct brick_writer *w = *writer;
    if (!w)
        return;
    if (w->part_exists && (!w->leave || w->spoiled)) {
        unlink(w->part_path);
        if (w->journaled)
            unlink(w->journal_path);
    }
    journal_close(&w->journal);
    for (int l = 0; l < BRICK_MAX_LEVELS; l++) {
        free_chunks(&w->level[l]);
        brick_io_close(&w->level[l].io);
    }
    free(w->path);
    free(w->part_path);
    free(w->journal_path);
    free(w->entries);
    free(w);
    *writer = NULL;
}

void brick_writer_set_tolerance(struct brick_writer *writer, double tolerance)
{
    writer->tolerance = tolerance;
}

void brick_writer_keep(struct brick_writer *w, uint64_t bytes)
{
    w->may_keep = bytes;
}

/* Keep what fits of a payload; how much that was. All of it is kept, or what follows goes to the scratch file
 * for good. */
static size_t keep(struct brick_writer *w, struct level_file *level, const unsigned char *payload,
                   size_t bytes)
{
    size_t done = 0;
    while (done < bytes && level->kept == level->bytes + done) {
        size_t used = (size_t)(level->kept % CHUNK_BYTES);
        if (used == 0) {
            struct chunk *chunk = w->may_keep >= sizeof *chunk ? malloc(sizeof *chunk) : NULL;
            if (!chunk)
                break;
            w->may_keep -= sizeof *chunk;
            chunk->next = NULL;
            if (level->last)
                level->last->next = chunk;
            else
                level->first = chunk;
            level->last = chunk;
        }
        size_t n = bytes - done < CHUNK_BYTES - used ? bytes - done : CHUNK_BYTES - used;
        memcpy(level->last->bytes + used, payload + done, n);
        level->kept += n;
        done += n;
    }
    return done;
}

/* Write to PATH.part, and have the disk begin on what is complete. */
static int write_part(struct brick_writer *w, uint64_t offset, const void *bytes, size_t n,
                      struct brick_error *err)
{
    int code = brick_io_write_at(&w->level[0].io, offset, bytes, n, err);
    uint64_t end = offset + n;
    if (!code && end >= w->flushed + WRITEBACK_BYTES) {
        brick_io_start_writeback(&w->level[0].io, w->flushed, end - w->flushed);
        w->flushed = end;
    }
    return code;
}

static int append_payload(struct brick_writer *w, uint32_t l, const unsigned char *payload, size_t bytes,
                          struct brick_error *err)
{
    struct level_file *level = &w->level[l];
    if (l == 0)
        return write_part(w, LAYOUT_HEADER_BYTES + level->bytes, payload, bytes, err);
    size_t kept = keep(w, level, payload, bytes);
    int code = BRICK_OK;
    if (kept < bytes && level->io.fd < 0)
        code = brick_io_create_scratch(&level->io, w->path, err);
    if (kept < bytes && !code)
        code = brick_io_write_at(&level->io, level->bytes + kept - level->kept, payload + kept, bytes - kept,
                                 err);
    return code;
}

int brick_writer_put(struct brick_writer *w, uint64_t id, const struct brick_entry *entry,
                     const void *payload, size_t bytes, struct brick_error *err)
{
    uint32_t l = 0;
    while (l + 1 < w->grid.levels && id >= w->grid.level[l + 1].first_brick)
        l++;
    struct level_file *level = &w->level[l];
    bool constant = entry->flags & BRICK_FLAG_CONSTANT;
    if (id >= w->grid.bricks || id != level->next_brick || constant != (bytes == 0) || bytes > UINT32_MAX)
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
        int code = append_payload(w, l, payload, bytes, err);
        if (code)
            return code;
        level->bytes += bytes;
    }
    level->next_brick++;
    return l == 0 && w->journaled ? journal_put(&w->journal, e, err) : BRICK_OK;
}

/* Append what waited of a level at `end`. */
static int append_level(struct brick_writer *w, uint32_t l, uint64_t end, unsigned char *buffer, size_t room,
                        struct brick_error *err)
{
    struct level_file *level = &w->level[l];
    int code = BRICK_OK;
    uint64_t at = 0;
    for (struct chunk *c = level->first; c && !code; c = c->next) {
        size_t n = level->kept - at < CHUNK_BYTES ? (size_t)(level->kept - at) : CHUNK_BYTES;
        code = write_part(w, end + at, c->bytes, n, err);
        at += n;
    }
    free_chunks(level);
    while (!code && at < level->bytes) {
        size_t n = level->bytes - at < room ? (size_t)(level->bytes - at) : room;
        code = brick_io_read_at(&level->io, at - level->kept, buffer, n, err);
        if (!code)
            code = write_part(w, end + at, buffer, n, err);
        at += n;
    }
    brick_io_close(&level->io);
    return code;
}

static int write_table(struct brick_writer *w, struct layout_extent *extent, uint64_t *end, const void *bytes,
                       size_t n, struct brick_error *err)
{
    *extent = (struct layout_extent){*end, n, XXH3_64bits(bytes, n)};
    *end += n;
    return brick_io_write_at(&w->level[0].io, extent->offset, bytes, n, err);
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
        code = brick_io_write_at(&w->level[0].io, *end, buffer, n, err);
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
            code = append_level(w, l, end, buffer, room, err);
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
    if ((code = brick_io_sync(&w->level[0].io, err)))
        goto done;
    sealed = true;
    if ((code = brick_io_write_at(&w->level[0].io, 0, header, sizeof header, err)) ||
        (code = brick_io_sync(&w->level[0].io, err)) || (code = brick_io_rename(w->part_path, w->path, err)))
        goto done;
    w->part_exists = false;
    if (w->journaled)
        unlink(w->journal_path);
    *file_bytes = end;
done:
    /* What may be left must not open as complete, not even when only the last sync or the new name failed. */
    if (code && sealed)
        w->spoiled = unseal(w, NULL) != BRICK_OK;
    free(buffer);
    return code;
}
