/* The reader. Invariants once open: the grid is the one that the header's sizes give and the level table
 * repeats; payloads, then tables, lie one behind the other without a gap, so every byte of the file is under
 * a checksum; every entry's range is finite or empty and its codec known. Only payloads are trusted to their
 * checksums later. */
#include <brick/volume.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include <brick/checked.h>
#include <brick/io.h>

#include "opened.h"
#include "payload.h"

static int damaged(const struct brick_volume *v, uint64_t offset, const char *what, struct brick_error *err)
{
    return brick_fail_at(err, BRICK_ERR_CHECKSUM, offset, BRICK_NO_BRICK,
                         "%s: the %s's checksum does not match: the file is damaged", v->io.path, what);
}

/* One whole table in memory: for the small ones. */
static int read_table(struct brick_volume *v, const struct layout_extent *extent, const char *what,
                      unsigned char **bytes, struct brick_error *err)
{
    *bytes = malloc(extent->bytes ? extent->bytes : 1);
    if (!*bytes)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory for the %s", v->io.path, what);
    int code = brick_io_read_at(&v->io, extent->offset, *bytes, extent->bytes, err);
    if (!code && XXH3_64bits(*bytes, extent->bytes) != extent->checksum)
        code = damaged(v, extent->offset, what, err);
    return code;
}

int opened_check_extents(const struct brick_volume *v, const struct layout_header *h, struct brick_error *err)
{
    const struct layout_extent *t = h->table;
    uint64_t index_bytes = 0;
    bool ok = h->levels == v->grid.levels &&
              brick_mul_u64(v->grid.bricks, LAYOUT_ENTRY_BYTES, &index_bytes) &&
              t[LAYOUT_INDEX].bytes == index_bytes &&
              t[LAYOUT_LEVELS].bytes == (uint64_t)LAYOUT_LEVEL_BYTES * v->grid.levels &&
              t[LAYOUT_STATS].bytes >= LAYOUT_STATS_BYTES &&
              t[LAYOUT_STATS].bytes <= LAYOUT_STATS_BYTES + 8u * 65536u &&
              t[LAYOUT_PROVENANCE].bytes <= LAYOUT_MAX_TEXT;
    ok = ok && t[0].offset >= LAYOUT_HEADER_BYTES;
    for (int i = 0; ok && i < LAYOUT_TABLES; i++) {
        uint64_t end = 0;
        ok = brick_add_u64(t[i].offset, t[i].bytes, &end) &&
             end == (i + 1 < LAYOUT_TABLES ? t[i + 1].offset : h->file_bytes);
    }
    return ok ? BRICK_OK
              : brick_fail(err, BRICK_ERR_FORMAT, "%s: the header's table of contents contradicts itself",
                           v->io.path);
}

int opened_read_levels(struct brick_volume *v, const struct layout_extent *extent, struct brick_error *err)
{
    unsigned char *bytes = NULL, expected[LAYOUT_LEVEL_BYTES];
    int code = read_table(v, extent, "level table", &bytes, err);
    for (uint32_t l = 0; !code && l < v->grid.levels; l++) {
        layout_put_level(&v->grid.level[l], expected);
        if (memcmp(expected, bytes + (size_t)l * LAYOUT_LEVEL_BYTES, LAYOUT_LEVEL_BYTES) != 0)
            code = brick_fail(err, BRICK_ERR_FORMAT, "%s: level %u is not the one its sizes and spacing give",
                              v->io.path, l);
    }
    free(bytes);
    return code;
}

bool opened_entry_sane(const struct brick_volume *v, const struct brick_entry *e, uint64_t end,
                       uint64_t *expected)
{
    enum brick_type type = v->grid.type;
    if (brick_codec_is_lossy((enum brick_codec)e->codec) && v->tolerance == 0.0)
        return false;
    if (e->reserved || (e->flags & ~BRICK_FLAG_CONSTANT) || e->codec >= BRICK_CODEC_COUNT)
        return false;
    if (!(e->min <= e->max) ? !(e->min == INFINITY && e->max == -INFINITY)
                            : !(isfinite(e->min) && isfinite(e->max)))
        return false;
    if (type != BRICK_F32 && (!(e->min <= e->max) || e->min < -32768.0f || e->max > 65535.0f))
        return false;
    if (e->flags & BRICK_FLAG_CONSTANT)
        return e->offset == 0 && e->bytes == 0 && e->checksum == 0 && e->codec == BRICK_CODEC_NONE;
    if (e->value || e->offset != *expected || e->bytes == 0 || end - *expected < e->bytes)
        return false;
    *expected += e->bytes;
    return true;
}

int opened_read_index(struct brick_volume *v, const struct layout_extent *extent, uint64_t payload_end,
                      struct brick_error *err)
{
    enum { CHUNK = 4096 }; /* entries */
    unsigned char *bytes = malloc((size_t)CHUNK * LAYOUT_ENTRY_BYTES);
    XXH3_state_t *hash = XXH3_createState();
    v->entries = malloc(v->grid.bricks * sizeof *v->entries);
    int code = BRICK_OK;
    if (!bytes || !hash || !v->entries) {
        code = brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory for an index of %llu bricks", v->io.path,
                          (unsigned long long)v->grid.bricks);
        goto done;
    }
    XXH3_64bits_reset(hash);
    uint64_t expected = LAYOUT_HEADER_BYTES, bad = BRICK_NO_BRICK;
    for (uint64_t id = 0; id < v->grid.bricks;) {
        size_t n = v->grid.bricks - id < CHUNK ? (size_t)(v->grid.bricks - id) : CHUNK;
        if ((code = brick_io_read_at(&v->io, extent->offset + id * LAYOUT_ENTRY_BYTES, bytes,
                                     n * LAYOUT_ENTRY_BYTES, err)))
            goto done;
        XXH3_64bits_update(hash, bytes, n * LAYOUT_ENTRY_BYTES);
        for (size_t i = 0; i < n; i++, id++) {
            layout_get_entry(&v->entries[id], bytes + i * LAYOUT_ENTRY_BYTES);
            if (bad == BRICK_NO_BRICK && !opened_entry_sane(v, &v->entries[id], payload_end, &expected))
                bad = id;
        }
    }
    if (XXH3_64bits_digest(hash) != extent->checksum)
        code = damaged(v, extent->offset, "index", err);
    else if (bad != BRICK_NO_BRICK || expected != payload_end)
        code = brick_fail_at(err, BRICK_ERR_FORMAT, extent->offset, bad,
                             "%s: index entry %llu contradicts the format", v->io.path,
                             (unsigned long long)(bad == BRICK_NO_BRICK ? v->grid.bricks - 1 : bad));
done:
    XXH3_freeState(hash);
    free(bytes);
    return code;
}

int opened_read_stats(struct brick_volume *v, const struct layout_extent *extent, struct brick_error *err)
{
    unsigned char *bytes = NULL;
    v->histogram = malloc(extent->bytes);
    int code = v->histogram ? read_table(v, extent, "statistics table", &bytes, err)
                            : brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", v->io.path);
    if (!code)
        code = layout_get_stats(&v->stats, v->histogram, bytes, extent->bytes, v->grid.type, v->io.path, err);
    if (!code && v->stats.count + v->stats.nonfinite != v->grid.dims[0] * v->grid.dims[1] * v->grid.dims[2])
        code = brick_fail(err, BRICK_ERR_FORMAT,
                          "%s: the statistics table counts other voxels than the volume has", v->io.path);
    free(bytes);
    return code;
}

int opened_read_provenance(struct brick_volume *v, const struct layout_extent *extent,
                           struct brick_error *err)
{
    unsigned char *bytes = NULL;
    int code = read_table(v, extent, "provenance", &bytes, err);
    if (!code && !(v->provenance = malloc(extent->bytes + 1)))
        code = brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", v->io.path);
    if (!code) {
        memcpy(v->provenance, bytes, extent->bytes);
        v->provenance[extent->bytes] = 0;
    }
    free(bytes);
    return code;
}

int opened_set_header(struct brick_volume *v, const struct layout_header *h, struct brick_error *err)
{
    struct brick_error inner = {0};
    v->file_bytes = h->file_bytes;
    v->payload_end = h->table[0].offset;
    v->tolerance = h->tolerance;
    if (brick_grid_init(&v->grid, h->type, &h->geometry, h->edge, h->border, h->macrocell, &inner))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: impossible header: %.500s", v->io.path, inner.message);
    return BRICK_OK;
}

int brick_volume_open(struct brick_volume **volume, const char *path, struct brick_error *err)
{
    *volume = NULL;
    unsigned char bytes[LAYOUT_HEADER_BYTES];
    struct layout_header h;
    uint64_t file_bytes = 0;
    int code;
    struct brick_volume *v = calloc(1, sizeof *v);
    if (!v)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    v->io.fd = -1;
    if ((code = brick_io_open(&v->io, path, err)) || (code = brick_io_size(&v->io, &file_bytes, err)))
        goto fail;
    if (file_bytes < LAYOUT_HEADER_BYTES) {
        code = brick_fail(err, BRICK_ERR_FORMAT, "%s: not a .brick file: %llu bytes are less than its header",
                          path, (unsigned long long)file_bytes);
        goto fail;
    }
    if ((code = brick_io_read_at(&v->io, 0, bytes, sizeof bytes, err)) ||
        (code = layout_get_header(&h, bytes, path, err)))
        goto fail;
    if (file_bytes != h.file_bytes) {
        code = brick_fail_at(err, BRICK_ERR_FORMAT, file_bytes, BRICK_NO_BRICK,
                             "%s: %llu bytes long, but complete at %llu: the file was cut or appended to",
                             path, (unsigned long long)file_bytes, (unsigned long long)h.file_bytes);
        goto fail;
    }
    if ((code = opened_set_header(v, &h, err)))
        goto fail;
    if ((code = opened_check_extents(v, &h, err)) ||
        (code = opened_read_levels(v, &h.table[LAYOUT_LEVELS], err)) ||
        (code = opened_read_index(v, &h.table[LAYOUT_INDEX], h.table[0].offset, err)) ||
        (code = opened_read_stats(v, &h.table[LAYOUT_STATS], err)) ||
        (code = opened_read_provenance(v, &h.table[LAYOUT_PROVENANCE], err)))
        goto fail;
    *volume = v;
    return BRICK_OK;
fail:
    brick_volume_close(&v);
    return code;
}

void brick_volume_close(struct brick_volume **volume)
{
    struct brick_volume *v = *volume;
    if (!v)
        return;
    brick_io_close(&v->io);
    free(v->histogram);
    free(v->provenance);
    free(v->entries);
    free(v);
    *volume = NULL;
}

const struct brick_grid *brick_volume_grid(const struct brick_volume *volume)
{
    return &volume->grid;
}

const struct brick_stats *brick_volume_stats(const struct brick_volume *volume)
{
    return &volume->stats;
}

const char *brick_volume_provenance(const struct brick_volume *volume)
{
    return volume->provenance;
}

const char *brick_volume_path(const struct brick_volume *volume)
{
    return volume->io.path;
}

uint64_t brick_volume_file_bytes(const struct brick_volume *volume)
{
    return volume->file_bytes;
}

double brick_volume_tolerance(const struct brick_volume *volume)
{
    return volume->tolerance;
}

const struct brick_entry *brick_volume_entry(const struct brick_volume *volume, uint64_t id)
{
    return &volume->entries[id];
}

static void to_physical(const struct brick_grid *grid, double min, double max, double *lo, double *hi)
{
    double a = grid->slope * min + grid->intercept, b = grid->slope * max + grid->intercept;
    *lo = fmin(a, b);
    *hi = fmax(a, b);
}

bool brick_volume_physical_range(const struct brick_volume *volume, uint64_t id, double *lo, double *hi)
{
    const struct brick_entry *e = &volume->entries[id];
    if (!(e->min <= e->max)) {
        *lo = INFINITY;
        *hi = -INFINITY;
        return false;
    }
    to_physical(&volume->grid, (double)e->min, (double)e->max, lo, hi);
    return true;
}

void brick_volume_value_range(const struct brick_volume *volume, double range[2])
{
    range[0] = range[1] = 0.0;
    if (volume->stats.count)
        to_physical(&volume->grid, volume->stats.min, volume->stats.max, &range[0], &range[1]);
}

int brick_volume_read(const struct brick_volume *volume, uint64_t id, void *dst,
                      struct brick_scratch *scratch, struct brick_error *err)
{
    return payload_read(&volume->io, &volume->grid, id, &volume->entries[id], dst, scratch, err);
}
