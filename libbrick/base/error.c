/* One line of text per failure, filled where the failure is understood best. */
#include <brick/error.h>

#include <stdarg.h>
#include <stdio.h>

static int fail_v(struct brick_error *err, int code, uint64_t offset, uint64_t brick, const char *format,
                  va_list args)
{
    if (err) {
        err->code = code;
        err->offset = offset;
        err->brick = brick;
        vsnprintf(err->message, sizeof err->message, format, args);
        for (char *c = err->message; *c; c++)
            if ((unsigned char)*c < ' ') /* names from files and command lines must not break the line */
                *c = '?';
    }
    return code;
}

int brick_fail(struct brick_error *err, int code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fail_v(err, code, BRICK_NO_OFFSET, BRICK_NO_BRICK, format, args);
    va_end(args);
    return code;
}

int brick_fail_at(struct brick_error *err, int code, uint64_t offset, uint64_t brick, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fail_v(err, code, offset, brick, format, args);
    va_end(args);
    return code;
}
