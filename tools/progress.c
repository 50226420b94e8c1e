/* Why: long conversions should show that they move and when they will end, and logs should stay free of it.
 * The line is redrawn at most ten times a second, and fits the terminal: one that wraps could not be erased.
 */
#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <brick/threads.h>

#define BAR_WIDTH   30
#define TEXT_WIDTH  37 /* brackets and spaces, percent, MB/s, time left, and the cursor */
#define INTERVAL_NS UINT64_C(100000000)

void tool_progress_init(struct tool_progress *progress, const char *label, uint64_t bytes, bool quiet)
{
    *progress = (struct tool_progress){
        .on = !quiet && isatty(STDERR_FILENO), .label = label, .bytes = bytes, .start_ns = brick_now_ns()};
}

/* What the terminal has room for beside the label and TEXT_WIDTH characters. */
static int bar_width(const struct tool_progress *progress)
{
    struct winsize size;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) || !size.ws_col)
        return BAR_WIDTH;
    int room = size.ws_col - (int)strlen(progress->label) - TEXT_WIDTH;
    return room < 1 ? 1 : room > BAR_WIDTH ? BAR_WIDTH : room;
}

static void print_left(char *text, size_t bytes, double seconds)
{
    unsigned long long left = seconds < 1e9 ? (unsigned long long)seconds : 1000000000;
    if (left < 3600)
        snprintf(text, bytes, " %3llu:%02llu left", left / 60, left % 60);
    else
        snprintf(text, bytes, " %llu:%02llu:%02llu left", left / 3600, left / 60 % 60, left % 60);
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
    char text[80] = "", bar[BAR_WIDTH + 1];
    int n = snprintf(text, sizeof text, "%3.0f%%", 100 * share);
    if (progress->bytes && seconds > 0)
        n += snprintf(text + n, sizeof text - (size_t)n, " %7.1f MB/s",
                      share * (double)progress->bytes / seconds * 1e-6);
    if (share > 0 && seconds > 1)
        print_left(text + n, sizeof text - (size_t)n, seconds * (1 - share) / share);
    int width = bar_width(progress);
    int filled = (int)(share * width);
    memset(bar, '.', sizeof bar);
    memset(bar, '#', (size_t)(filled > width ? width : filled));
    bar[width] = 0;
    fprintf(stderr, "\r%s [%s] %s", progress->label, bar, text);
    fputs("\033[K", stderr);
    fflush(stderr);
}

void tool_progress_finish(struct tool_progress *progress)
{
    if (progress->on && progress->shown_ns)
        fputs("\r\033[K", stderr);
    progress->on = false;
}
