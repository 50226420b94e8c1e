/* Why: compressed volumes are read front to back through a fixed buffer, never a whole stream in memory.
 * Invariant: z holds input bytes [.., next) of the file; `produced` bytes have been handed out. */
#include "inflate.h"

#ifdef HAVE_ZLIB

#include <stdbool.h>
#include <stdlib.h>
#include <zlib.h>

#define INPUT_BYTES      ((size_t)1 << 18)
#define MAX_OUTPUT_BYTES ((size_t)1 << 30) /* zlib counts in 32 bits */
#define AUTO_HEADER      (15 + 32)         /* gzip or zlib, the largest window */

struct fmt_inflate {
    const struct brick_io *io;
    uint64_t next, end; /* input still to be read from the file */
    uint64_t produced;
    bool ended; /* the last member has ended and no input is left */
    z_stream z;
    unsigned char input[INPUT_BYTES];
};

int fmt_inflate_create(struct fmt_inflate **out, const struct brick_io *io, uint64_t offset,
                       uint64_t stored_bytes, struct brick_error *err)
{
    struct fmt_inflate *stream = calloc(1, sizeof *stream);
    if (!stream)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", io->path);
    stream->io = io;
    stream->next = offset;
    stream->end = offset + stored_bytes;
    if (inflateInit2(&stream->z, AUTO_HEADER) != Z_OK) {
        free(stream);
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: zlib cannot start", io->path);
    }
    *out = stream;
    return BRICK_OK;
}

void fmt_inflate_destroy(struct fmt_inflate **stream)
{
    if (!*stream)
        return;
    inflateEnd(&(*stream)->z);
    free(*stream);
    *stream = NULL;
}

static int refill(struct fmt_inflate *stream, struct brick_error *err)
{
    if (stream->z.avail_in || stream->next == stream->end)
        return BRICK_OK;
    uint64_t left = stream->end - stream->next;
    size_t n = left < INPUT_BYTES ? (size_t)left : INPUT_BYTES;
    int code = brick_io_read_at(stream->io, stream->next, stream->input, n, err);
    if (code)
        return code;
    stream->next += n;
    stream->z.next_in = stream->input;
    stream->z.avail_in = (uInt)n;
    return BRICK_OK;
}

static uint64_t position(const struct fmt_inflate *stream)
{
    return stream->next - stream->z.avail_in;
}

static int damaged(const struct fmt_inflate *stream, struct brick_error *err)
{
    return brick_fail_at(err, BRICK_ERR_FORMAT, position(stream), BRICK_NO_BRICK,
                         "%s: compressed voxels are damaged near byte %llu: %s", stream->io->path,
                         (unsigned long long)position(stream),
                         stream->z.msg ? stream->z.msg : "not a gzip or zlib stream");
}

/* One call of inflate. *got is what it made of at most n bytes; 0 without `ended` means: call again. */
static int step(struct fmt_inflate *stream, void *dst, size_t n, size_t *got, struct brick_error *err)
{
    *got = 0;
    int code = refill(stream, err);
    if (code)
        return code;
    if (!stream->z.avail_in)
        return brick_fail_at(err, BRICK_ERR_FORMAT, stream->end, BRICK_NO_BRICK,
                             "%s: compressed voxels end early: truncated after %llu bytes of voxels",
                             stream->io->path, (unsigned long long)stream->produced);
    stream->z.next_out = dst;
    stream->z.avail_out = (uInt)n;
    int status = inflate(&stream->z, Z_NO_FLUSH);
    *got = n - stream->z.avail_out;
    stream->produced += *got;
    if (status == Z_MEM_ERROR)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: zlib is out of memory", stream->io->path);
    if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR)
        return damaged(stream, err);
    if (status == Z_STREAM_END) {
        code = refill(stream, err);
        if (code)
            return code;
        if (!stream->z.avail_in ||
            *stream->z.next_in != 0x1f) /* no further gzip member: padding is ignored */
            stream->ended = true;
        else if (inflateReset(&stream->z) != Z_OK)
            return damaged(stream, err);
    }
    return BRICK_OK;
}

int fmt_inflate_read(struct fmt_inflate *stream, void *dst, size_t n, struct brick_error *err)
{
    unsigned char *p = dst;
    while (n) {
        if (stream->ended)
            return brick_fail_at(err, BRICK_ERR_FORMAT, position(stream), BRICK_NO_BRICK,
                                 "%s: compressed voxels end early: %llu bytes found, more are needed",
                                 stream->io->path, (unsigned long long)stream->produced);
        size_t got;
        int code = step(stream, p, n < MAX_OUTPUT_BYTES ? n : MAX_OUTPUT_BYTES, &got, err);
        if (code)
            return code;
        p += got;
        n -= got;
    }
    return BRICK_OK;
}

int fmt_inflate_skip(struct fmt_inflate *stream, uint64_t n, struct brick_error *err)
{
    unsigned char discard[4096];
    while (n) {
        size_t part = n < sizeof discard ? (size_t)n : sizeof discard;
        int code = fmt_inflate_read(stream, discard, part, err);
        if (code)
            return code;
        n -= part;
    }
    return BRICK_OK;
}

int fmt_inflate_check(struct fmt_inflate *stream, struct brick_error *err)
{
    /* zlib compares the checksum when it meets the stream's end, which may need one more call; a byte that
     * comes out instead belongs to data that nobody asked for. */
    unsigned char extra;
    size_t got = 0;
    while (!stream->ended && !got) {
        int code = step(stream, &extra, 1, &got, err);
        if (code)
            return code;
    }
    return BRICK_OK;
}

#else

int fmt_inflate_create(struct fmt_inflate **stream, const struct brick_io *io, uint64_t offset,
                       uint64_t stored_bytes, struct brick_error *err)
{
    (void)stream, (void)offset, (void)stored_bytes;
    return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                      "%s: its voxels are compressed and this build has no zlib (Debian package zlib1g-dev)",
                      io->path);
}

void fmt_inflate_destroy(struct fmt_inflate **stream)
{
    (void)stream;
}

int fmt_inflate_read(struct fmt_inflate *stream, void *dst, size_t n, struct brick_error *err)
{
    (void)stream, (void)dst, (void)n;
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this build has no zlib");
}

int fmt_inflate_skip(struct fmt_inflate *stream, uint64_t n, struct brick_error *err)
{
    return fmt_inflate_read(stream, NULL, (size_t)n, err);
}

int fmt_inflate_check(struct fmt_inflate *stream, struct brick_error *err)
{
    return fmt_inflate_read(stream, NULL, 0, err);
}

#endif
