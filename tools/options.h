/* Command lines: one table of options a command, which is parsed, checked and printed as help from the same
 * rows. */
#ifndef TOOLS_OPTIONS_H
#define TOOLS_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

#include "parse.h"

/* A row. Fields not named are zero. */
struct tool_option {
    const char *name;
    char letter;       /* short form, or 0 */
    const char *value; /* what the value looks like, in help and messages; NULL: a flag */
    tool_parse *parse; /* fills target; NULL for a flag, whose target is a bool */
    void *target;      /* keeps its value, the default, when the option is not given */
    bool *given;       /* set when the option is given; may be NULL */
    bool required;     /* not on a flag */
    const char *help;  /* lines separated by \n */
    struct tool_limits limits;
};

struct tool_usage {
    const char *command;   /* "convert", for messages */
    const char *arguments; /* after the command's name in the help's first line */
    const char *summary;
    struct {
        const struct tool_option *row;
        size_t count;
    } options;
    struct {
        int min, max;
        const char *what; /* for messages: "one SRC" */
    } positional;
};

#define TOOL_COUNT(array) (sizeof(array) / sizeof *(array))

/* -1: go on, *first is the index in argv of the first positional argument. Otherwise the exit code: help was
 * printed, or a usage error. */
int tool_options(const struct tool_usage *usage, int argc, char **argv, int *first);

/* Rows that several commands share. */
#define TOOL_OPTION_JSON(target_)                                                                            \
    {                                                                                                        \
        "json", .target = (target_), .help = "print one JSON object on stdout"                               \
    }
#define TOOL_OPTION_QUIET(target_)                                                                           \
    {                                                                                                        \
        "quiet", .letter = 'q', .target = (target_), .help = "no progress, notes or summary"                 \
    }
#define TOOL_OPTION_THREADS(target_)                                                                         \
    {                                                                                                        \
        "threads", .value = "N", .parse = tool_parse_u32, .target = (target_),                               \
                   .limits = {.min = 1, .max = 256}, .help = "threads to use (default: one a core)"          \
    }

#endif
