/* A progress line on stderr: bar, MB/s, time left. Only on a terminal; otherwise every call does nothing. */
#ifndef TOOLS_PROGRESS_H
#define TOOLS_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

struct tool_progress {
    bool on;
    const char *label;
    uint64_t bytes; /* of the whole; 0: unknown, no MB/s */
    uint64_t start_ns, shown_ns;
};

/* label lives as long as the progress. */
void tool_progress_init(struct tool_progress *progress, const char *label, uint64_t bytes, bool quiet);
/* context is a struct tool_progress; fits the callbacks of libbrick. */
void tool_progress_update(void *context, uint64_t done, uint64_t total);
/* Erase the line. */
void tool_progress_finish(struct tool_progress *progress);

#endif
