/* Why: every header format needs the same care with hostile text, and has it here once. Nothing after the
 * first mebibyte is read as text, no line holds a zero byte, and a number is accepted only as a whole. */
#include "text.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PRINTABLE_MAX_BYTES 1000

int fmt_text_load(struct fmt_text *text, const struct brick_io *io, struct brick_error *err)
{
    *text = (struct fmt_text){.path = io->path};
    uint64_t file_bytes;
    int code = brick_io_size(io, &file_bytes, err);
    if (code)
        return code;
    text->whole = file_bytes <= FMT_TEXT_MAX_BYTES;
    text->count = text->whole ? (size_t)file_bytes : FMT_TEXT_MAX_BYTES;
    text->bytes = malloc(text->count + 1);
    if (!text->bytes)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory for the header", io->path);
    code = brick_io_read_at(io, 0, text->bytes, text->count, err);
    if (code)
        fmt_text_finish(text);
    return code;
}

void fmt_text_finish(struct fmt_text *text)
{
    free(text->bytes);
    text->bytes = NULL;
    text->count = 0;
}

int fmt_text_line(struct fmt_text *text, char **line, struct brick_error *err)
{
    size_t left = text->count - text->at;
    if (left == 0 && text->whole)
        return 0;
    char *start = text->bytes + text->at;
    char *end = left ? memchr(start, '\n', left) : NULL;
    if (!end && !text->whole)
        return brick_fail_at(err, BRICK_ERR_FORMAT, text->at, BRICK_NO_BRICK,
                             "%s: the header does not end within %zu bytes", text->path, FMT_TEXT_MAX_BYTES);
    size_t length = end ? (size_t)(end - start) : left;
    text->line++;
    if (memchr(start, 0, length))
        return brick_fail_at(err, BRICK_ERR_FORMAT, text->at, BRICK_NO_BRICK,
                             "%s: line %u of the header is not text", text->path, text->line);
    text->at += length + (end ? 1 : 0);
    start[length] = 0;
    if (length && start[length - 1] == '\r')
        start[length - 1] = 0;
    *line = start;
    return 1;
}

char *fmt_text_trim(char *s)
{
    while (isspace((unsigned char)*s))
        s++;
    size_t n = strlen(s);
    while (n && isspace((unsigned char)s[n - 1]))
        n--;
    s[n] = 0;
    return s;
}

char *fmt_text_word(char **at)
{
    char *s = *at;
    while (isspace((unsigned char)*s))
        s++;
    if (!*s)
        return NULL;
    char *end = s;
    while (*end && !isspace((unsigned char)*end))
        end++;
    if (*end)
        *end++ = 0;
    *at = end;
    return s;
}

bool fmt_parse_u64(const char *s, uint64_t *value)
{
    if (!isdigit((unsigned char)*s))
        return false;
    char *end;
    errno = 0;
    unsigned long long v = strtoull(s, &end, 10);
    if (errno || *end)
        return false;
    *value = v;
    return true;
}

bool fmt_parse_i64(const char *s, int64_t *value)
{
    if (!isdigit((unsigned char)*s) && *s != '-' && *s != '+')
        return false;
    char *end;
    errno = 0;
    long long v = strtoll(s, &end, 10);
    if (errno || *end || end == s)
        return false;
    *value = v;
    return true;
}

bool fmt_parse_f64(const char *s, double *value)
{
    if (!*s || isspace((unsigned char)*s) || strpbrk(s, "xX"))
        return false;
    char *end;
    errno = 0;
    double v = strtod(s, &end);
    if (*end || end == s || (errno == ERANGE && isinf(v)))
        return false;
    *value = v;
    return true;
}

bool fmt_parse_u64s(char *s, uint64_t *values, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        char *word = fmt_text_word(&s);
        if (!word || !fmt_parse_u64(word, &values[i]))
            return false;
    }
    return !fmt_text_word(&s);
}

bool fmt_parse_f64s(char *s, double *values, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        char *word = fmt_text_word(&s);
        if (!word || !fmt_parse_f64(word, &values[i]))
            return false;
    }
    return !fmt_text_word(&s);
}

char *fmt_text_printable(const char *s)
{
    char *copy = strndup(s, PRINTABLE_MAX_BYTES);
    if (!copy)
        return NULL;
    for (char *c = copy; *c; c++)
        if ((unsigned char)*c < 0x20 || (unsigned char)*c > 0x7e)
            *c = '?';
    return copy;
}
