/* Errors: every function that can fail returns 0 or a negative enum brick_result and, when its last
 * argument is not NULL, describes the failure there: what, which file, which offset or brick, what to do. */
#ifndef BRICK_ERROR_H
#define BRICK_ERROR_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum brick_result {
    BRICK_OK = 0,
    BRICK_ERR_ARGUMENT = -1,    /* the caller's argument is out of its documented range */
    BRICK_ERR_MEMORY = -2,      /* an allocation failed, or a budget would be exceeded */
    BRICK_ERR_IO = -3,          /* the system refused a read, write, open or rename */
    BRICK_ERR_FORMAT = -4,      /* the bytes of a file contradict its format */
    BRICK_ERR_CHECKSUM = -5,    /* the bytes of a file contradict their checksum */
    BRICK_ERR_UNSUPPORTED = -6, /* valid, but not something this build or version does */
    BRICK_ERR_INEXACT = -7,     /* a value does not fit the requested type */
    BRICK_ERR_CANCELLED = -8    /* the caller asked to stop */
};

#define BRICK_NO_OFFSET UINT64_MAX
#define BRICK_NO_BRICK  UINT64_MAX

/* Caller owned; plain data; one line of text without a newline. */
struct brick_error {
    int code;        /* enum brick_result */
    uint64_t offset; /* byte in the file, or BRICK_NO_OFFSET */
    uint64_t brick;  /* brick number, or BRICK_NO_BRICK */
    char message[640];
};

/* Fill err (may be NULL) and return code, so that a failing function can end in one statement. */
#if defined __GNUC__
__attribute__((format(printf, 3, 4)))
#endif
int brick_fail(struct brick_error *err, int code, const char *format, ...);

/* The same, for a failure that belongs to one byte offset and/or one brick. */
#if defined __GNUC__
__attribute__((format(printf, 5, 6)))
#endif
int brick_fail_at(struct brick_error *err, int code, uint64_t offset, uint64_t brick, const char *format, ...);

#ifdef __cplusplus
}
#endif
#endif
