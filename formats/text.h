/* Text headers: bounded reading, line by line, and numbers that are numbers. Private to formats/. */
#ifndef FORMATS_TEXT_H
#define FORMATS_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <brick/error.h>
#include <brick/io.h>

/* A header is at most this long; what follows is not looked at. */
#define FMT_TEXT_MAX_BYTES ((size_t)1 << 20)

/* The first FMT_TEXT_MAX_BYTES of a file, handed out line by line. */
struct fmt_text {
    char *bytes; /* owned; lines are cut out of it in place */
    size_t count;
    size_t at;        /* first byte of the next line: after a header, where the voxels begin */
    unsigned line;    /* number of the last line handed out, from 1 */
    bool whole;       /* bytes reaches the file's end */
    const char *path; /* of the io, for messages */
};

int fmt_text_load(struct fmt_text *text, const struct brick_io *io, struct brick_error *err);
void fmt_text_finish(struct fmt_text *text);
/* 1 and the next line without its end (LF or CRLF), 0 at the file's end, or BRICK_ERR_FORMAT for a line with
 * a zero byte or a header that does not end. The line lives as long as text. */
int fmt_text_line(struct fmt_text *text, char **line, struct brick_error *err);

/* Without the white space at both ends; cuts in place. */
char *fmt_text_trim(char *s);
/* The next word, or NULL when none is left; cuts in place and moves *at behind it. */
char *fmt_text_word(char **at);

/* All of s is one number within range: no sign where none belongs, no rest, no overflow, decimal only.
 * fmt_parse_f64 accepts nan and inf: what they mean is the caller's to say. */
bool fmt_parse_u64(const char *s, uint64_t *value);
bool fmt_parse_i64(const char *s, int64_t *value);
bool fmt_parse_f64(const char *s, double *value);
/* Exactly n numbers between white space; cuts s. */
bool fmt_parse_u64s(char *s, uint64_t *values, size_t n);
bool fmt_parse_f64s(char *s, double *values, size_t n);

/* A copy for provenance, at most 1000 bytes: one line of printable ASCII. NULL without memory. */
char *fmt_text_printable(const char *s);

#endif
