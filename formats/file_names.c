/* Why: NRRD and MetaImage point to data files in the same three ways: one name, a list, a numbered series. A
 * pattern comes from a file, so it never reaches printf: its one conversion is parsed here. */
#include "file_names.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text.h"

#define MAX_DIGITS 20

void fmt_file_names_finish(struct fmt_file_names *names)
{
    for (size_t i = 0; i < names->count; i++)
        free(names->path[i]);
    free(names->path);
    *names = (struct fmt_file_names){0};
}

int fmt_file_names_add(struct fmt_file_names *names, const char *header_path, const char *name,
                       struct brick_error *err)
{
    if (names->count == FMT_MAX_FILES)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: names more than %zu data files", header_path,
                          FMT_MAX_FILES);
    if (!*name)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: the name of its data file is empty", header_path);
    const char *slash = strrchr(header_path, '/');
    int folder = *name == '/' || !slash ? 0 : (int)(slash - header_path) + 1;
    char *path = NULL;
    /* The array grows by doubling: its room is the next power of two. */
    if ((names->count & (names->count - 1)) == 0) {
        size_t room = names->count ? names->count * 2 : 1;
        char **grown = realloc(names->path, room * sizeof *grown);
        if (!grown)
            goto memory;
        names->path = grown;
    }
    if (asprintf(&path, "%.*s%s", folder, header_path, name) < 0)
        goto memory;
    names->path[names->count++] = path;
    return BRICK_OK;
memory:
    return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory for the names of its data files",
                      header_path);
}

/* Split "prefix%0Nd suffix" around its only conversion. */
static bool split_pattern(char *pattern, const char **suffix, int *width, bool *zeros)
{
    char *at = strchr(pattern, '%');
    if (!at || strchr(at + 1, '%'))
        return false;
    *at++ = 0;
    *zeros = *at == '0';
    *width = 0;
    for (; isdigit((unsigned char)*at); at++) {
        *width = *width * 10 + (*at - '0');
        if (*width > MAX_DIGITS)
            return false;
    }
    *suffix = at + 1;
    return *at == 'd' || *at == 'i' || *at == 'u';
}

int fmt_file_names_add_series(struct fmt_file_names *names, const char *header_path, char *spec,
                              const char **rest, struct brick_error *err)
{
    char *at = spec, *pattern = fmt_text_word(&at), *words[3];
    int64_t first, last, step = 1;
    const char *suffix;
    int width;
    bool zeros;
    for (int i = 0; i < 3; i++)
        words[i] = fmt_text_word(&at);
    if (!pattern || !split_pattern(pattern, &suffix, &width, &zeros) || !words[1] ||
        !fmt_parse_i64(words[0], &first) || !fmt_parse_i64(words[1], &last) ||
        (words[2] && !fmt_parse_i64(words[2], &step)))
        return brick_fail(err, BRICK_ERR_FORMAT,
                          "%s: its series of data files is not PATTERN FIRST LAST STEP with one %%d",
                          header_path);
    if (step == 0 || (step > 0 ? first > last : first < last) || first < -(INT64_C(1) << 40) ||
        first > INT64_C(1) << 40 || last < -(INT64_C(1) << 40) || last > INT64_C(1) << 40 ||
        step == INT64_MIN)
        return brick_fail(err, BRICK_ERR_FORMAT,
                          "%s: its series of data files runs from %lld to %lld by %lld", header_path,
                          (long long)first, (long long)last, (long long)step);
    *rest = fmt_text_trim(at);
    uint64_t steps = (uint64_t)((last - first) / step);
    if (steps >= FMT_MAX_FILES)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: names more than %zu data files", header_path,
                          FMT_MAX_FILES);
    for (uint64_t i = 0; i <= steps; i++) {
        long long number = first + (int64_t)i * step;
        char *name = NULL;
        if (asprintf(&name, zeros ? "%s%0*lld%s" : "%s%*lld%s", pattern, width, number, suffix) < 0)
            return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", header_path);
        int code = fmt_file_names_add(names, header_path, name, err);
        free(name);
        if (code)
            return code;
    }
    return BRICK_OK;
}
