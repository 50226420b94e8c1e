/* What is left of a file. Invariants: nothing is taken from the file that a checksum does not confirm but
 * index entries, and of these only such as could be right; sizes are held against the caller's memory, since
 * the file's own length says nothing any more. */
#include <brick/damaged.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/codec.h>

#include "opened.h"

/* Entries that can be read and could be right; the others stay zero. */
static int read_entries(struct brick_volume *v, const struct layout_header *h, struct brick_error *err)
{
    free(v->entries);
    if (!(v->entries = calloc(v->grid.bricks, sizeof *v->entries)))
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory for an index of %llu bricks", v->io.path,
                          (unsigned long long)v->grid.bricks);
    enum { CHUNK = 85 }; /* entries: about a page, which is what disks lose */
    unsigned char bytes[CHUNK * LAYOUT_ENTRY_BYTES];
    const struct layout_extent *index = &h->table[LAYOUT_INDEX];
    const size_t payload = brick_grid_max_payload_bytes(&v->grid);
    uint64_t file_bytes = 0;
    int code = brick_io_size(&v->io, &file_bytes, err);
    for (uint64_t id = 0; !code && id < v->grid.bricks; id += CHUNK) {
        size_t n = v->grid.bricks - id < CHUNK ? (size_t)(v->grid.bricks - id) : CHUNK;
        uint64_t at = index->offset + id * LAYOUT_ENTRY_BYTES;
        if (at >= file_bytes)
            break;
        if ((file_bytes - at) / LAYOUT_ENTRY_BYTES < n)
            n = (size_t)((file_bytes - at) / LAYOUT_ENTRY_BYTES);
        if (brick_io_read_at(&v->io, at, bytes, n * LAYOUT_ENTRY_BYTES, NULL))
            continue; /* what cannot be read is lost, and no more than that */
        for (size_t i = 0; i < n; i++) {
            struct brick_entry e;
            layout_get_entry(&e, bytes + i * LAYOUT_ENTRY_BYTES);
            uint64_t start = e.offset;
            bool placed = e.flags & BRICK_FLAG_CONSTANT || e.offset >= LAYOUT_HEADER_BYTES;
            placed = placed && e.bytes <= brick_codec_bound((enum brick_codec)e.codec, payload);
            if (placed && start <= h->table[0].offset && opened_entry_sane(v, &e, h->table[0].offset, &start))
                v->entries[id + i] = e;
        }
    }
    return code;
}

static int read_tables(struct brick_volume *v, const struct layout_header *h, struct brick_damage *damage,
                       struct brick_error *err)
{
    const struct layout_extent *t = h->table;
    damage->levels = opened_read_levels(v, &t[LAYOUT_LEVELS], NULL) != 0;
    if ((damage->stats = opened_read_stats(v, &t[LAYOUT_STATS], NULL) != 0))
        v->stats = (struct brick_stats){.min = INFINITY, .max = -INFINITY};
    damage->provenance = opened_read_provenance(v, &t[LAYOUT_PROVENANCE], NULL) != 0;
    if (damage->provenance && !(v->provenance = calloc(1, 1)))
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", v->io.path);
    damage->index = opened_read_index(v, &t[LAYOUT_INDEX], t[0].offset, NULL) != 0;
    return damage->index ? read_entries(v, h, err) : BRICK_OK;
}

int brick_volume_open_damaged(struct brick_volume **volume, const char *path, uint64_t memory_bytes,
                              struct brick_damage *damage, struct brick_error *err)
{
    *volume = NULL;
    *damage = (struct brick_damage){0};
    unsigned char bytes[LAYOUT_HEADER_BYTES];
    struct layout_header h;
    struct brick_volume *v = calloc(1, sizeof *v);
    int code;
    if (!v)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    v->io.fd = -1;
    if ((code = brick_io_open(&v->io, path, err)) || (code = brick_io_size(&v->io, &damage->bytes, err)))
        goto fail;
    if (damage->bytes < LAYOUT_HEADER_BYTES) {
        code = brick_fail(err, BRICK_ERR_FORMAT,
                          "%s: %llu bytes are less than the header, without which nothing can be told", path,
                          (unsigned long long)damage->bytes);
        goto fail;
    }
    if ((code = brick_io_read_at(&v->io, 0, bytes, sizeof bytes, err)))
        goto fail;
    static const unsigned char zeros[LAYOUT_HEADER_BYTES];
    if (memcmp(bytes, zeros, sizeof bytes) == 0) {
        code = brick_fail(err, BRICK_ERR_FORMAT,
                          "%s: not damaged but unfinished: brick convert --resume goes on with it", path);
        goto fail;
    }
    damage->header = layout_mend_header(bytes);
    if ((code = layout_get_header(&h, bytes, path, err)) || (code = opened_set_header(v, &h, err)) ||
        (code = opened_check_extents(v, &h, err)))
        goto fail;
    if (v->grid.bricks > memory_bytes / sizeof *v->entries) {
        code = brick_fail(err, BRICK_ERR_MEMORY,
                          "%s: the index of %llu bricks needs %llu MiB, more than --memory %llu MiB allows",
                          path, (unsigned long long)v->grid.bricks,
                          (unsigned long long)(v->grid.bricks * sizeof *v->entries / 1048576 + 1),
                          (unsigned long long)(memory_bytes / 1048576));
        goto fail;
    }
    if ((code = read_tables(v, &h, damage, err)))
        goto fail;
    *volume = v;
    return BRICK_OK;
fail:
    brick_volume_close(&v);
    return code;
}

uint64_t brick_volume_payload_end(const struct brick_volume *volume)
{
    return volume->payload_end;
}

int brick_volume_read_bytes(const struct brick_volume *volume, uint64_t offset, void *dst, size_t n,
                            struct brick_error *err)
{
    return brick_io_read_at(&volume->io, offset, dst, n, err);
}

void brick_volume_set_entry(struct brick_volume *volume, uint64_t id, const struct brick_entry *entry)
{
    volume->entries[id] = *entry;
}
