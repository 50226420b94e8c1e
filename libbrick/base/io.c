/* Positioned I/O. Every loop over short transfers and EINTR in the project is in this file. */
#include <brick/io.h>

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* Linux transfers at most 0x7ffff000 bytes a call; staying below keeps the loops simple everywhere. */
#define MAX_TRANSFER_BYTES ((size_t)1 << 30)
#define READING_BYTES      ((uint64_t)128 << 10)
#define LOCK_TURNS         50 /* of 10 ms */

static int open_as(struct brick_io *io, const char *path, int flags, struct brick_error *err)
{
    io->fd = -1;
    io->path = strdup(path);
    if (!io->path)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    do
        io->fd = open(path, flags | O_CLOEXEC, 0666);
    while (io->fd < 0 && errno == EINTR);
    if (io->fd < 0) {
        int code = brick_fail(err, BRICK_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
        brick_io_close(io);
        return code;
    }
    return BRICK_OK;
}

static int require_regular(struct brick_io *io, struct brick_error *err)
{
    struct stat st;
    if (fstat(io->fd, &st) == 0 && S_ISREG(st.st_mode))
        return BRICK_OK;
    int code = brick_fail(err, BRICK_ERR_IO, "%s: is not a regular file", io->path);
    brick_io_close(io);
    return code;
}

int brick_io_open(struct brick_io *io, const char *path, struct brick_error *err)
{
    /* O_NONBLOCK: opening a named pipe must not wait for a writer before it is refused. */
    int code = open_as(io, path, O_RDONLY | O_NONBLOCK, err);
    return code ? code : require_regular(io, err);
}

/* The file may have got another name while it was opened: then the lock is on what another process has
 * finished, and writing to it would damage that. */
static bool still_named(const struct brick_io *io)
{
    struct stat opened, named;
    return fstat(io->fd, &opened) == 0 && stat(io->path, &named) == 0 && opened.st_dev == named.st_dev &&
           opened.st_ino == named.st_ino;
}

/* A process that was killed holds its locks until the system has taken it apart: that is waited for. */
static bool lock(const struct brick_io *io)
{
    const struct timespec pause = {.tv_nsec = 10000000};
    for (int turn = 0; flock(io->fd, LOCK_EX | LOCK_NB); turn++) {
        if (turn == LOCK_TURNS)
            return false;
        nanosleep(&pause, NULL);
    }
    return still_named(io);
}

int brick_io_update(struct brick_io *io, const char *path, struct brick_error *err)
{
    int code = open_as(io, path, O_RDWR | O_CREAT | O_NONBLOCK, err);
    if (code || (code = require_regular(io, err)))
        return code;
    if (lock(io))
        return BRICK_OK;
    code = brick_fail(err, BRICK_ERR_IO, "%s: another process is writing it", path);
    brick_io_close(io);
    return code;
}

int brick_io_create(struct brick_io *io, const char *path, struct brick_error *err)
{
    int code = brick_io_update(io, path, err);
    if (!code && (code = brick_io_truncate(io, 0, err)))
        brick_io_close(io);
    return code;
}

/* A file without a name, in the folder of path; -1 where the file system has none. */
static int open_nameless(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *folder = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    int fd = folder ? open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600) : -1;
    free(folder);
    return fd;
}

int brick_io_create_scratch(struct brick_io *io, const char *path, struct brick_error *err)
{
    size_t n = strlen(path);
    io->fd = -1;
    io->path = malloc(n + sizeof ".spool-XXXXXX");
    if (!io->path)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    memcpy(io->path, path, n);
    memcpy(io->path + n, ".spool-XXXXXX", sizeof ".spool-XXXXXX");
    if ((io->fd = open_nameless(path)) >= 0)
        return BRICK_OK;
    io->fd = mkostemp(io->path, O_CLOEXEC);
    if (io->fd < 0) {
        int code = brick_fail(err, BRICK_ERR_IO, "%s: cannot create a scratch file beside it: %s", path,
                              strerror(errno));
        brick_io_close(io);
        return code;
    }
    unlink(io->path);
    return BRICK_OK;
}

void brick_io_close(struct brick_io *io)
{
    if (io->fd >= 0)
        close(io->fd);
    free(io->path);
    io->fd = -1;
    io->path = NULL;
}

int brick_io_size(const struct brick_io *io, uint64_t *bytes, struct brick_error *err)
{
    struct stat st;
    if (fstat(io->fd, &st))
        return brick_fail(err, BRICK_ERR_IO, "%s: cannot tell its size: %s", io->path, strerror(errno));
    *bytes = (uint64_t)st.st_size;
    return BRICK_OK;
}

int brick_io_changed(const struct brick_io *io, int64_t *ns, struct brick_error *err)
{
    struct stat st;
    if (fstat(io->fd, &st))
        return brick_fail(err, BRICK_ERR_IO, "%s: cannot tell its age: %s", io->path, strerror(errno));
    *ns = (int64_t)st.st_mtim.tv_sec * 1000000000 + st.st_mtim.tv_nsec;
    return BRICK_OK;
}

int brick_io_truncate(const struct brick_io *io, uint64_t bytes, struct brick_error *err)
{
    if (ftruncate(io->fd, (off_t)bytes))
        return brick_fail(err, BRICK_ERR_IO, "%s: cannot truncate: %s", io->path, strerror(errno));
    return BRICK_OK;
}

int brick_io_read_at(const struct brick_io *io, uint64_t offset, void *dst, size_t n, struct brick_error *err)
{
    unsigned char *p = dst;
    while (n) {
        if (offset > INT64_MAX - MAX_TRANSFER_BYTES)
            return brick_fail_at(err, BRICK_ERR_FORMAT, offset, BRICK_NO_BRICK,
                                 "%s: offset %llu is beyond any file", io->path, (unsigned long long)offset);
        ssize_t got = pread(io->fd, p, n < MAX_TRANSFER_BYTES ? n : MAX_TRANSFER_BYTES, (off_t)offset);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return brick_fail_at(err, BRICK_ERR_IO, offset, BRICK_NO_BRICK,
                                 "%s: read at byte %llu failed: %s", io->path, (unsigned long long)offset,
                                 strerror(errno));
        if (got == 0)
            return brick_fail_at(err, BRICK_ERR_FORMAT, offset, BRICK_NO_BRICK,
                                 "%s: the file ends at byte %llu, %zu bytes too early", io->path,
                                 (unsigned long long)offset, n);
        p += got;
        offset += (uint64_t)got;
        n -= (size_t)got;
    }
    return BRICK_OK;
}

int brick_io_write_at(const struct brick_io *io, uint64_t offset, const void *src, size_t n,
                      struct brick_error *err)
{
    const unsigned char *p = src;
    while (n) {
        ssize_t put = pwrite(io->fd, p, n < MAX_TRANSFER_BYTES ? n : MAX_TRANSFER_BYTES, (off_t)offset);
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            return brick_fail_at(err, BRICK_ERR_IO, offset, BRICK_NO_BRICK,
                                 "%s: write at byte %llu failed: %s", io->path, (unsigned long long)offset,
                                 strerror(put < 0 ? errno : ENOSPC));
        p += put;
        offset += (uint64_t)put;
        n -= (size_t)put;
    }
    return BRICK_OK;
}

/* Linux begins no more a call than the device takes at once, or its read-ahead: 128 KiB unless it is set. */
void brick_io_start_reading(const struct brick_io *io, uint64_t offset, uint64_t n)
{
#ifdef POSIX_FADV_WILLNEED
    for (uint64_t some; n; offset += some, n -= some) {
        some = n < READING_BYTES ? n : READING_BYTES;
        (void)posix_fadvise(io->fd, (off_t)offset, (off_t)some, POSIX_FADV_WILLNEED);
    }
#else
    (void)io;
    (void)offset;
    (void)n;
#endif
}

void brick_io_start_writeback(const struct brick_io *io, uint64_t offset, uint64_t n)
{
#ifdef SYNC_FILE_RANGE_WRITE
    (void)sync_file_range(io->fd, (off_t)offset, (off_t)n, SYNC_FILE_RANGE_WRITE);
#else
    (void)io;
    (void)offset;
    (void)n;
#endif
}

int brick_io_sync(const struct brick_io *io, struct brick_error *err)
{
    if (fsync(io->fd))
        return brick_fail(err, BRICK_ERR_IO, "%s: sync failed: %s", io->path, strerror(errno));
    return BRICK_OK;
}

int brick_io_rename(const char *from, const char *to, struct brick_error *err)
{
    if (rename(from, to))
        return brick_fail(err, BRICK_ERR_IO, "%s: cannot rename %s to it: %s", to, from, strerror(errno));
    char *folder = strdup(to);
    if (!folder)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", to);
    char *slash = strrchr(folder, '/');
    if (slash)
        slash[slash == folder ? 1 : 0] = 0;
    int fd = open(slash ? folder : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    free(folder);
    if (fd >= 0) { /* some file systems cannot sync a folder; the rename itself has succeeded */
        (void)fsync(fd);
        close(fd);
    }
    return BRICK_OK;
}

int brick_part_create(struct brick_part *part, const char *path, struct brick_error *err)
{
    char *name = NULL;
    part->path = strdup(path);
    if (!part->path || asprintf(&name, "%s.part", path) < 0)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    int code = brick_io_create(&part->io, name, err);
    free(name);
    return code;
}

int brick_part_publish(struct brick_part *part, struct brick_error *err)
{
    int code = brick_io_sync(&part->io, err);
    if (!code)
        code = brick_io_rename(part->io.path, part->path, err);
    if (!code)
        brick_io_close(&part->io);
    return code;
}

void brick_part_discard(struct brick_part *part)
{
    if (part->io.fd >= 0)
        unlink(part->io.path);
    brick_io_close(&part->io);
    free(part->path);
    part->path = NULL;
}
