/* A progress line on stderr: bar, MB/s, time left, and what limits. Only on a terminal; otherwise every call
 * does nothing. */
#ifndef TOOLS_PROGRESS_H
#define TOOLS_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

struct tool_progress {
    bool on;
    const char *label;
    uint64_t bytes;    /* of the whole; 0: unknown, no MB/s */
    const char *limit; /* what limits: the caller's to set and change; NULL: unknown */
    uint64_t shown_ns;
    const char *shown_limit;
    /* Speed and time left are those since `from`; `next` will take its place. */
    struct tool_progress_mark {
        uint64_t ns;
        double share;
    } from, next;
};

/* label lives as long as the progress. */
void tool_progress_init(struct tool_progress *progress, const char *label, uint64_t bytes, bool quiet);
/* context is a struct tool_progress; fits the callbacks of libbrick. */
void tool_progress_update(void *context, uint64_t done, uint64_t total);
/* Erase the line. */
void tool_progress_finish(struct tool_progress *progress);

#endif
