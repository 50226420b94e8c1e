/* Names of the data files that a header points to. Private to formats/. */
#ifndef FORMATS_FILE_NAMES_H
#define FORMATS_FILE_NAMES_H

#include <stddef.h>
#include <stdint.h>

#include <brick/error.h>

#define FMT_MAX_FILES ((size_t)1 << 20)

struct fmt_file_names {
    char **path; /* owned */
    size_t count;
};

void fmt_file_names_finish(struct fmt_file_names *names);
/* Add one: relative to the folder of header_path unless absolute. */
int fmt_file_names_add(struct fmt_file_names *names, const char *header_path, const char *name,
                       struct brick_error *err);
/* Add those of a numbered series, "PATTERN FIRST LAST [STEP]" with one %d (%03d, ...) in the pattern. Cuts
 * spec. What follows the step, if allowed, is left in *rest. */
int fmt_file_names_add_series(struct fmt_file_names *names, const char *header_path, char *spec,
                              const char **rest, struct brick_error *err);

#endif
