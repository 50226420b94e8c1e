/* What commands say: failures, usage errors and notes on stderr, JSON on stdout, sizes that people read. */
#ifndef TOOLS_MESSAGE_H
#define TOOLS_MESSAGE_H

#include <stdint.h>

#include <brick/error.h>

struct cJSON;

/* "brick COMMAND: message", exit code 1. */
int tool_fail(const char *command, const struct brick_error *err);
/* "brick COMMAND: ...; see 'brick COMMAND --help'", exit code 2. */
__attribute__((format(printf, 2, 3))) int tool_misuse(const char *command, const char *format, ...);
/* "brick COMMAND: note: ..." */
__attribute__((format(printf, 2, 3))) void tool_note(const char *command, const char *format, ...);

/* "13.5 MiB" */
struct tool_size {
    char text[24];
};
struct tool_size tool_size_text(uint64_t bytes);

/* Print an object and delete it. Exit code: 0, or 1 with a message when memory ran out while it was built. */
int tool_json_print(const char *command, struct cJSON *object);

#endif
