/* Why: raw, NRRD and MetaImage differ in their headers only; how voxels come out of files is the same and is
 * here. Invariants: every file holds file_bytes of decoded voxels, start[i] is where file i's first stored
 * byte is, and the sizes were checked on creation. At most one file is open; `at` is the position in it, of a
 * compressed one. */
#include "file_source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <brick/io.h>

#include "geometry.h"
#include "inflate.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "big-endian hosts need the byte swap the other way round");

struct file_source {
    struct brick_source base;
    char **path; /* owned, files of them */
    uint64_t *start;
    size_t files;
    uint64_t file_bytes, slice_bytes;
    uint64_t decoded_skip, stored_bytes;
    enum fmt_encoding encoding;
    bool swap;
    struct brick_io io;
    size_t current; /* the file that io is, when open */
    struct fmt_inflate *inflate;
    uint64_t at;
    char *provenance;
    char *state;
    int64_t changed_ns;   /* the newest file */
    uint64_t fingerprint; /* of every file's size, time of change, and first byte */
    uint64_t bytes_on_disk;
};

static void close_current(struct file_source *s)
{
    fmt_inflate_destroy(&s->inflate);
    brick_io_close(&s->io);
}

static void destroy(struct brick_source *base)
{
    struct file_source *s = (struct file_source *)base;
    close_current(s);
    for (size_t i = 0; i < s->files && s->path; i++)
        free(s->path[i]);
    free(s->path);
    free(s->start);
    free(s->provenance);
    free(s->state);
    free(s);
}

/* Where the line after `lines` more lines begins. */
static int skip_lines(const struct brick_io *io, uint64_t size, uint64_t lines, uint64_t *offset,
                      struct brick_error *err)
{
    char block[4096];
    while (lines) {
        uint64_t left = *offset < size ? size - *offset : 0;
        size_t n = left < sizeof block ? (size_t)left : sizeof block;
        if (n == 0)
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: ends before the %llu lines to be skipped", io->path,
                              (unsigned long long)lines);
        int code = brick_io_read_at(io, *offset, block, n, err);
        if (code)
            return code;
        const char *at = block, *end = block + n, *newline;
        while (lines && (newline = memchr(at, '\n', (size_t)(end - at)))) {
            at = newline + 1;
            lines--;
        }
        *offset += lines ? n : (uint64_t)(at - block);
    }
    return BRICK_OK;
}

/* FNV-1a, a word at a time. */
static void mix(uint64_t *fingerprint, uint64_t word)
{
    *fingerprint = (*fingerprint ^ word) * UINT64_C(0x100000001b3);
}

static int note_state(struct file_source *s, const struct brick_io *io, uint64_t start,
                      struct brick_error *err)
{
    uint64_t size;
    int64_t changed_ns;
    int code = brick_io_size(io, &size, err);
    if (code || (code = brick_io_changed(io, &changed_ns, err)))
        return code;
    s->bytes_on_disk += size;
    if (changed_ns > s->changed_ns)
        s->changed_ns = changed_ns;
    mix(&s->fingerprint, size);
    mix(&s->fingerprint, (uint64_t)changed_ns);
    mix(&s->fingerprint, start);
    return BRICK_OK;
}

/* NULL when memory is out. */
static char *describe_state(const struct file_source *s)
{
    char date[32] = "", *text;
    time_t seconds = (time_t)(s->changed_ns / 1000000000);
    struct tm utc;
    if (gmtime_r(&seconds, &utc))
        strftime(date, sizeof date, "%F %T", &utc);
    return asprintf(&text, "%llu bytes of %s.%09lld UTC (%016llx)", (unsigned long long)s->bytes_on_disk,
                    date, (long long)(s->changed_ns % 1000000000), (unsigned long long)s->fingerprint) < 0
               ? NULL
               : text;
}

/* Find the first stored byte of a file's voxels and hold its size against what is needed. */
static int locate(struct file_source *s, const struct fmt_file_layout *layout, const struct brick_io *io,
                  uint64_t *start, struct brick_error *err)
{
    bool raw = s->encoding == FMT_ENCODING_RAW, tail = layout->skip_bytes == FMT_SKIP_TO_TAIL;
    uint64_t size, offset = layout->offset, stored = raw ? s->file_bytes : s->stored_bytes;
    int code = brick_io_size(io, &size, err);
    if (code)
        return code;
    code = skip_lines(io, size, layout->skip_lines, &offset, err);
    if (code)
        return code;
    if (tail) {
        if (stored == 0)
            return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                              "%s: compressed voxels at the end of a file need their compressed size said",
                              io->path);
        offset = offset <= size && stored <= size - offset ? size - stored : size;
    } else if (raw && __builtin_add_overflow(offset, (uint64_t)layout->skip_bytes, &offset)) {
        offset = UINT64_MAX;
    }
    uint64_t found = offset < size ? size - offset : 0;
    if (found < stored || (layout->exact && found > stored)) {
        uint64_t expected = stored;
        if (!tail && __builtin_add_overflow(offset, stored, &expected))
            expected = UINT64_MAX;
        const uint64_t *d = layout->geometry.dims;
        return brick_fail_at(
            err, BRICK_ERR_FORMAT, size, BRICK_NO_BRICK,
            layout->exact
                ? "%s: wrong size for --size %llux%llux%llu --type %s: expected %llu bytes, found "
                  "%llu; check --size and --type, or --skip for bytes before the voxels"
                : "%s: truncated: its volume of %llu x %llu x %llu voxels of %s needs a file of %llu "
                  "bytes, this one has %llu",
            io->path, (unsigned long long)d[0], (unsigned long long)d[1], (unsigned long long)d[2],
            brick_type_name(layout->type), (unsigned long long)expected, (unsigned long long)size);
    }
    if (!raw) {
        if (stored == 0)
            stored = found;
        uint64_t most;
        if (!__builtin_mul_overflow(stored, (uint64_t)FMT_INFLATE_MAX_RATIO, &most) && most < s->file_bytes)
            return brick_fail_at(err, BRICK_ERR_FORMAT, offset, BRICK_NO_BRICK,
                                 "%s: truncated: %llu compressed bytes cannot hold %llu bytes of voxels",
                                 io->path, (unsigned long long)stored, (unsigned long long)s->file_bytes);
    }
    s->base.input_bytes += stored;
    *start = offset;
    return BRICK_OK;
}

static int open_file(struct file_source *s, size_t i, struct brick_error *err)
{
    close_current(s);
    int code = brick_io_open(&s->io, s->path[i], err);
    if (code)
        return code;
    s->current = i;
    s->at = 0;
    if (s->encoding == FMT_ENCODING_RAW)
        return BRICK_OK;
    uint64_t size, stored = s->stored_bytes;
    code = brick_io_size(&s->io, &size, err);
    if (!code && stored == 0)
        stored = size > s->start[i] ? size - s->start[i] : 0;
    if (!code)
        code = fmt_inflate_create(&s->inflate, &s->io, s->start[i], stored, err);
    if (!code)
        code = fmt_inflate_skip(s->inflate, s->decoded_skip, err);
    if (code)
        close_current(s);
    return code;
}

static int read_part(struct file_source *s, size_t file, uint64_t within, void *dst, size_t n,
                     struct brick_error *err)
{
    if (s->io.fd < 0 || s->current != file) {
        int code = open_file(s, file, err);
        if (code)
            return code;
    }
    if (s->encoding == FMT_ENCODING_RAW)
        return brick_io_read_at(&s->io, s->start[file] + within, dst, n, err);
    if (within < s->at)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: compressed slices are read in ascending order",
                          s->io.path);
    int code = fmt_inflate_skip(s->inflate, within - s->at, err);
    if (code || (code = fmt_inflate_read(s->inflate, dst, n, err)))
        return code;
    s->at = within + n;
    return s->at == s->file_bytes ? fmt_inflate_check(s->inflate, err) : BRICK_OK;
}

/* n bytes of decoded voxels from `offset` of the volume, out of one file or several. */
static int read_bytes(struct file_source *s, uint64_t offset, unsigned char *dst, uint64_t n,
                      struct brick_error *err)
{
    while (n) {
        uint64_t within = offset % s->file_bytes, some = s->file_bytes - within;
        if (some > n)
            some = n;
        int code = read_part(s, (size_t)(offset / s->file_bytes), within, dst, (size_t)some, err);
        if (code)
            return code;
        dst += some;
        offset += some;
        n -= some;
    }
    return BRICK_OK;
}

static int read_slices(struct brick_source *base, uint64_t z, uint64_t count, void *dst,
                       struct brick_error *err)
{
    struct file_source *s = (struct file_source *)base;
    const uint64_t *dims = base->geometry.dims;
    if (z > dims[2] || count > dims[2] - z)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "slices %llu+%llu are outside the volume",
                          (unsigned long long)z, (unsigned long long)count);
    int code = read_bytes(s, z * s->slice_bytes, dst, count * s->slice_bytes, err);
    if (!code && s->swap)
        brick_type_swap_bytes(base->type, dst, (size_t)(count * dims[0] * dims[1]));
    return code;
}

/* Uncompressed files only. Lines that lie behind each other in the file are read at once. */
static int read_box(struct brick_source *base, const uint64_t lo[3], const uint64_t hi[3], void *dst,
                    struct brick_error *err)
{
    struct file_source *s = (struct file_source *)base;
    const uint64_t *dims = base->geometry.dims;
    for (int a = 0; a < 3; a++)
        if (lo[a] >= hi[a] || hi[a] > dims[a])
            return brick_fail(err, BRICK_ERR_ARGUMENT, "a box outside the volume");
    uint64_t width = brick_type_bytes(base->type), nx = hi[0] - lo[0], ny = hi[1] - lo[1];
    uint64_t lines = nx == dims[0] ? ny : 1;
    unsigned char *p = dst;
    for (uint64_t z = lo[2]; z < hi[2]; z++)
        for (uint64_t y = lo[1]; y < hi[1]; y += lines) {
            int code =
                read_bytes(s, z * s->slice_bytes + (y * dims[0] + lo[0]) * width, p, lines * nx * width, err);
            if (code)
                return code;
            p += lines * nx * width;
        }
    if (s->swap)
        brick_type_swap_bytes(base->type, dst, (size_t)((hi[2] - lo[2]) * ny * nx));
    return BRICK_OK;
}

static void fetch(struct brick_source *base, uint64_t z, uint64_t count)
{
    struct file_source *s = (struct file_source *)base;
    uint64_t offset = z * s->slice_bytes, end = offset + count * s->slice_bytes;
    while (offset < end) {
        uint64_t file = offset / s->file_bytes, within = offset % s->file_bytes, n = s->file_bytes - within;
        if (n > end - offset)
            n = end - offset;
        struct brick_io io;
        if (brick_io_open(&io, s->path[file], NULL))
            return; /* reading it will say why */
        brick_io_start_reading(&io, s->start[file] + within, n);
        brick_io_close(&io);
        offset += n;
    }
}

static char *describe(const struct fmt_file_layout *layout)
{
    static const char *const names[] = {"raw", "gzip", "zlib"};
    char *text;
    const char *endian = layout->big_endian ? "source_endian: big\n" : "source_endian: little\n";
    if (asprintf(&text, "format: %s\nsource_type: %s\n%sencoding: %s\n%s", layout->format,
                 brick_type_name(layout->type), brick_type_bytes(layout->type) > 1 ? endian : "",
                 names[layout->encoding], layout->notes ? layout->notes : "") < 0)
        return NULL;
    return text;
}

int fmt_file_source_create(struct brick_source **source, const struct fmt_file_layout *layout,
                           struct brick_error *err)
{
    const struct fmt_file_names *names = layout->names;
    struct file_source *s = NULL;
    struct brick_io io = BRICK_IO_CLOSED;
    uint64_t bytes;
    int code = fmt_geometry_bytes(layout->geometry.dims, layout->type, names->path[0], &bytes, err);
    if (code)
        return code;
    if (bytes % names->count)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: the volume is not %zu slabs of equal size",
                          names->path[0], names->count);
    s = calloc(1, sizeof *s);
    if (!s)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", names->path[0]);
    s->base.geometry = layout->geometry;
    s->base.type = layout->type;
    s->base.read = read_slices;
    if (layout->encoding == FMT_ENCODING_RAW) {
        s->base.read_box = read_box;
        s->base.fetch = fetch;
    }
    s->base.destroy = destroy;
    s->io = (struct brick_io)BRICK_IO_CLOSED;
    s->encoding = layout->encoding;
    s->swap = layout->big_endian && brick_type_bytes(layout->type) > 1;
    s->file_bytes = bytes / names->count;
    s->slice_bytes = bytes / layout->geometry.dims[2];
    s->stored_bytes = layout->stored_bytes;
    s->decoded_skip = layout->skip_bytes > 0 ? (uint64_t)layout->skip_bytes : 0;
    s->path = calloc(names->count, sizeof *s->path);
    s->start = calloc(names->count, sizeof *s->start);
    s->provenance = describe(layout);
    s->files = names->count;
    if (!s->path || !s->start || !s->provenance)
        goto memory;
    s->base.provenance = s->provenance;
    for (size_t i = 0; i < s->files; i++) {
        s->path[i] = strdup(names->path[i]);
        if (!s->path[i])
            goto memory;
        code = brick_io_open(&io, s->path[i], err);
        if (!code)
            code = locate(s, layout, &io, &s->start[i], err);
        if (!code)
            code = note_state(s, &io, s->start[i], err);
        brick_io_close(&io);
        if (code)
            goto fail;
    }
    mix(&s->fingerprint, s->decoded_skip);
    if (!(s->state = describe_state(s)))
        goto memory;
    s->base.state = s->state;
    code = open_file(
        s, 0, err); /* what this build cannot decompress fails here, not halfway through a conversion */
    if (code)
        goto fail;
    *source = &s->base;
    return BRICK_OK;
memory:
    code = brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", names->path[0]);
fail:
    destroy(&s->base);
    return code;
}
