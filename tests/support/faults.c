#include "faults.h"

#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static enum fault armed;
static unsigned long target, calls;
static int failure;

void faults_arm(enum fault fault, unsigned long at, int error)
{
    pthread_mutex_lock(&lock);
    armed = fault;
    target = at;
    failure = error;
    calls = 0;
    pthread_mutex_unlock(&lock);
}

unsigned long faults_calls(void)
{
    pthread_mutex_lock(&lock);
    unsigned long n = calls;
    pthread_mutex_unlock(&lock);
    return n;
}

/* What becomes of this call; errno is set when it fails. */
static enum fault next_call(bool is_write)
{
    pthread_mutex_lock(&lock);
    unsigned long n = calls++;
    bool later = n > target, half = n == target && is_write;
    enum fault fault = FAULT_NONE;
    if (n == target || (later && (armed == FAULT_FULL || armed == FAULT_SHORT)))
        fault = armed;
    if (fault == FAULT_FULL && !half)
        fault = FAULT_ONCE;
    if (fault == FAULT_SHORT && !is_write)
        fault = FAULT_NONE;
    if (fault == FAULT_TORN && !is_write)
        fault = FAULT_KILL;
    errno = failure;
    pthread_mutex_unlock(&lock);
    if (fault == FAULT_KILL)
        raise(SIGKILL);
    return fault;
}

/* The system's function, by the name that a 64-bit off_t gives it. */
static void *system_call(const char *name)
{
    void *function = dlsym(RTLD_NEXT, name);
    if (!function)
        abort();
    return function;
}

ssize_t pwrite(int fd, const void *bytes, size_t n, off_t offset)
{
    ssize_t (*real)(int, const void *, size_t, off_t);
    *(void **)&real = system_call("pwrite64");
    switch (next_call(true)) {
    case FAULT_NONE:
        return real(fd, bytes, n, offset);
    case FAULT_SHORT:
    case FAULT_FULL:
        return real(fd, bytes, (n + 1) / 2, offset);
    case FAULT_TORN:
        (void)real(fd, bytes, n / 2, offset);
        raise(SIGKILL);
        return -1;
    default:
        return -1;
    }
}

/* Counted, not done: no test can cut the power, and thousands of syncs take minutes. */
int fsync(int fd)
{
    (void)fd;
    return next_call(false) ? -1 : 0;
}

int ftruncate(int fd, off_t bytes)
{
    int (*real)(int, off_t);
    *(void **)&real = system_call("ftruncate64");
    return next_call(false) ? -1 : real(fd, bytes);
}

int rename(const char *from, const char *to)
{
    int (*real)(const char *, const char *);
    *(void **)&real = system_call("rename");
    return next_call(false) ? -1 : real(from, to);
}
