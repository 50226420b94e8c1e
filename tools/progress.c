/* Why: long conversions should show that they move and when they will end, and logs should stay free of it.
 * The line is redrawn at most ten times a second, and fits the terminal: one that wraps could not be erased.
 * Speed is that of the last 10 to 20 seconds: what a resumed conversion has kept goes by faster than the
 * rest. */
#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <brick/threads.h>

#define BAR_WIDTH   30
#define BAR_MIN     10
#define TEXT_WIDTH  37 /* brackets and spaces, percent, MB/s, time left, and the cursor */
#define LIMIT_WIDTH 19 /* ", downsample limits" */
#define INTERVAL_NS UINT64_C(100000000)
#define WINDOW_NS   UINT64_C(10000000000)

void tool_progress_init(struct tool_progress *progress, const char *label, uint64_t bytes, bool quiet)
{
    *progress = (struct tool_progress){.on = !quiet && isatty(STDERR_FILENO), .label = label, .bytes = bytes};
    progress->from.ns = progress->next.ns = brick_now_ns();
}

/* What the terminal has room for beside the label and TEXT_WIDTH characters. */
static int room(const struct tool_progress *progress)
{
    struct winsize size;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) || !size.ws_col)
        return BAR_WIDTH;
    int columns = size.ws_col - (int)strlen(progress->label) - TEXT_WIDTH;
    return columns < 1 ? 1 : columns;
}

static int print_left(char *text, size_t bytes, double seconds)
{
    unsigned long long left = seconds < 1e9 ? (unsigned long long)seconds : 1000000000;
    if (left < 3600)
        return snprintf(text, bytes, " %3llu:%02llu left", left / 60, left % 60);
    return snprintf(text, bytes, " %llu:%02llu:%02llu left", left / 3600, left / 60 % 60, left % 60);
}

void tool_progress_update(void *context, uint64_t done, uint64_t total)
{
    struct tool_progress *p = context;
    if (!p->on || !total)
        return;
    uint64_t now = brick_now_ns();
    if (p->shown_ns && now - p->shown_ns < INTERVAL_NS && p->limit == p->shown_limit)
        return;
    p->shown_ns = now;
    p->shown_limit = p->limit;

    double share = (double)done / (double)total, seconds = 1e-9 * (double)(now - p->from.ns),
           advance = share - p->from.share;
    if (now - p->next.ns > WINDOW_NS) {
        p->from = p->next;
        p->next = (struct tool_progress_mark){now, share};
    }
    char text[96] = "", bar[BAR_WIDTH + 1];
    int n = snprintf(text, sizeof text, "%3.0f%%", 100 * share), width = room(p);
    if (p->bytes && seconds > 0)
        n += snprintf(text + n, sizeof text - (size_t)n, " %7.1f MB/s",
                      advance * (double)p->bytes / seconds * 1e-6);
    if (advance > 0 && seconds > 1)
        n += print_left(text + n, sizeof text - (size_t)n, seconds * (1 - share) / advance);
    if (p->limit && width >= LIMIT_WIDTH + BAR_MIN) {
        snprintf(text + n, sizeof text - (size_t)n, ", %s limits", p->limit);
        width -= LIMIT_WIDTH;
    }
    width = width > BAR_WIDTH ? BAR_WIDTH : width;
    int filled = (int)(share * width);
    memset(bar, '.', sizeof bar);
    memset(bar, '#', (size_t)(filled > width ? width : filled));
    bar[width] = 0;
    fprintf(stderr, "\r%s [%s] %s", p->label, bar, text);
    fputs("\033[K", stderr);
    fflush(stderr);
}

void tool_progress_finish(struct tool_progress *progress)
{
    if (progress->on && progress->shown_ns)
        fputs("\r\033[K", stderr);
    progress->on = false;
}
