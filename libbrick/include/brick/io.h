/* Positioned I/O on whole byte ranges: short reads and writes and EINTR are dealt with here, and nowhere
 * else. All offsets are 64-bit. Reading and writing at explicit offsets is safe from several threads at once.
 */
#ifndef BRICK_IO_H
#define BRICK_IO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <brick/error.h>

#ifdef __cplusplus
extern "C" {
#endif

struct brick_io {
    int fd;     /* -1 when closed */
    char *path; /* owned; for messages */
};

#define BRICK_IO_CLOSED                                                                                      \
    {                                                                                                        \
        -1, NULL                                                                                             \
    }

/* Open an existing regular file for reading. BRICK_ERR_IO when missing, a folder, or not readable. */
int brick_io_open(struct brick_io *io, const char *path, struct brick_error *err);
/* Create or truncate for reading and writing; locked, so that a second writer of the same path fails. */
int brick_io_create(struct brick_io *io, const char *path, struct brick_error *err);
/* The same, but what is in the file stays. */
int brick_io_update(struct brick_io *io, const char *path, struct brick_error *err);
/* A scratch file in the same folder as path, without a name: it is gone when closed, or when killed. */
int brick_io_create_scratch(struct brick_io *io, const char *path, struct brick_error *err);
/* Safe on a closed io. Does not sync. */
void brick_io_close(struct brick_io *io);

int brick_io_size(const struct brick_io *io, uint64_t *bytes, struct brick_error *err);
/* When its bytes last changed, in ns since 1970. */
int brick_io_changed(const struct brick_io *io, int64_t *ns, struct brick_error *err);
int brick_io_truncate(const struct brick_io *io, uint64_t bytes, struct brick_error *err);
/* Exactly n bytes or an error (BRICK_ERR_IO; BRICK_ERR_FORMAT when the file ends before). */
int brick_io_read_at(const struct brick_io *io, uint64_t offset, void *dst, size_t n,
                     struct brick_error *err);
int brick_io_write_at(const struct brick_io *io, uint64_t offset, const void *src, size_t n,
                      struct brick_error *err);
/* A hint: begin to read these bytes into the page cache without waiting. */
void brick_io_start_reading(const struct brick_io *io, uint64_t offset, uint64_t n);
/* A hint: begin to write these bytes to disk without waiting, so that a later sync is short. */
void brick_io_start_writeback(const struct brick_io *io, uint64_t offset, uint64_t n);
int brick_io_sync(const struct brick_io *io, struct brick_error *err);
/* rename(from, to), then sync the folder, so that the name survives a power cut. */
int brick_io_rename(const char *from, const char *to, struct brick_error *err);

/* A file that is complete where it carries its name: until it is published it is called PATH.part. */
struct brick_part {
    struct brick_io io; /* of PATH.part; closed: there is none */
    char *path;         /* the final name, owned */
};
/* part: zero bytes and a closed io, as discard leaves it. */
int brick_part_create(struct brick_part *part, const char *path, struct brick_error *err);
/* Sync, rename, close. */
int brick_part_publish(struct brick_part *part, struct brick_error *err);
/* Remove what is not published; always called at the end. */
void brick_part_discard(struct brick_part *part);

#ifdef __cplusplus
}
#endif
#endif
