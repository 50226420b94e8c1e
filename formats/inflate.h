/* Sequential decompression of a gzip or zlib stream inside a file. Private to formats/. */
#ifndef FORMATS_INFLATE_H
#define FORMATS_INFLATE_H

#include <stddef.h>
#include <stdint.h>

#include <brick/error.h>
#include <brick/io.h>

/* Deflate cannot shrink data more than this (RFC 1951: 258 bytes from two bits, rounded up). */
#define FMT_INFLATE_MAX_RATIO 1032

struct fmt_inflate;

/* Decompress stored_bytes of io from offset on; gzip and zlib are told apart by their headers, and gzip
 * members may follow one another. io must outlive it. BRICK_ERR_UNSUPPORTED in a build without zlib. */
int fmt_inflate_create(struct fmt_inflate **stream, const struct brick_io *io, uint64_t offset,
                       uint64_t stored_bytes, struct brick_error *err);
void fmt_inflate_destroy(struct fmt_inflate **stream);

/* The next n bytes. BRICK_ERR_FORMAT when the stream ends before, or is none. */
int fmt_inflate_read(struct fmt_inflate *stream, void *dst, size_t n, struct brick_error *err);
int fmt_inflate_skip(struct fmt_inflate *stream, uint64_t n, struct brick_error *err);
/* After the last byte wanted: when the stream ends here, hold its checksum against what was read. */
int fmt_inflate_check(struct fmt_inflate *stream, struct brick_error *err);

#endif
