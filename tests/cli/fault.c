/* Preloaded into the program: its reads of .brick files count, and read number FAULT_AT fails in the way that
 * FAULT names, "error" (EIO), "half" (half of the bytes, then EIO) or "truncate" (the file is cut in the
 * middle of them first). All later reads see the same disk. With FAULT_LOG the number of reads is written
 * there. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static atomic_long reads;

static int path_of(int fd, char path[4096])
{
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(link, path, 4095);
    path[n > 0 ? n : 0] = 0;
    return n > 6 && strcmp(path + n - 6, ".brick") == 0;
}

ssize_t pread64(int fd, void *to, size_t n, off64_t offset)
{
    static ssize_t (*real)(int, void *, size_t, off64_t);
    char path[4096];
    if (!real)
        *(void **)&real = dlsym(RTLD_NEXT, "pread64");
    if (!path_of(fd, path))
        return real(fd, to, n, offset);
    const char *at = getenv("FAULT_AT"), *fault = getenv("FAULT");
    long mine = atomic_fetch_add(&reads, 1) + 1, when = at ? atol(at) : 0;
    if (when && fault && mine >= when) {
        if (!strcmp(fault, "truncate")) {
            if (mine == when && truncate(path, offset + (off64_t)(n / 2)))
                abort();
        } else if (!strcmp(fault, "error") || mine > when) {
            errno = EIO;
            return -1;
        } else {
            n = n / 2;
        }
    }
    return real(fd, to, n, offset);
}

ssize_t pread(int fd, void *to, size_t n, off_t offset)
{
    return pread64(fd, to, n, offset);
}

__attribute__((destructor)) static void log_reads(void)
{
    const char *path = getenv("FAULT_LOG");
    FILE *f = path ? fopen(path, "w") : NULL;
    if (f) {
        fprintf(f, "%ld\n", (long)reads);
        fclose(f);
    }
}
