/* Why: long conversions should show that they move and when they will end, and logs should stay free of it.
 * The line is redrawn at most ten times a second. */
#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <brick/threads.h>

#define BAR_WIDTH   30
#define INTERVAL_NS UINT64_C(100000000)

void tool_progress_init(struct tool_progress *progress, const char *label, uint64_t bytes, bool quiet)
{
    *progress = (struct tool_progress){
        .on = !quiet && isatty(STDERR_FILENO), .label = label, .bytes = bytes, .start_ns = brick_now_ns()};
}

void tool_progress_update(void *context, uint64_t done, uint64_t total)
{
    struct tool_progress *progress = context;
    if (!progress->on || !total)
        return;
    uint64_t now = brick_now_ns();
    if (progress->shown_ns && now - progress->shown_ns < INTERVAL_NS)
        return;
    progress->shown_ns = now;

    double share = (double)done / (double)total, seconds = 1e-9 * (double)(now - progress->start_ns);
    char bar[BAR_WIDTH + 1];
    int filled = (int)(share * BAR_WIDTH);
    memset(bar, '.', BAR_WIDTH);
    memset(bar, '#', (size_t)(filled > BAR_WIDTH ? BAR_WIDTH : filled));
    bar[BAR_WIDTH] = 0;
    fprintf(stderr, "\r%s [%s] %3.0f%%", progress->label, bar, 100 * share);
    if (progress->bytes && seconds > 0)
        fprintf(stderr, " %7.1f MB/s", share * (double)progress->bytes / seconds * 1e-6);
    if (share > 0 && seconds > 1) {
        double left = seconds * (1 - share) / share;
        fprintf(stderr, " %3.0f:%02d left", (double)(uint64_t)(left / 60), (int)((uint64_t)left % 60));
    }
    fputs("\033[K", stderr);
    fflush(stderr);
}

void tool_progress_finish(struct tool_progress *progress)
{
    if (progress->on && progress->shown_ns)
        fputs("\r\033[K", stderr);
    progress->on = false;
}
