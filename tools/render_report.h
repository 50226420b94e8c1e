/* What `brick render --json` says of its frames. */
#ifndef TOOLS_RENDER_REPORT_H
#define TOOLS_RENDER_REPORT_H

#include <renderer/renderer.h>

/* What is counted, over all frames; what is a state, of the last; seconds: of a frame, on average. count
 * >= 1. */
struct vr_report tool_render_sum(const struct vr_report *reports, size_t count);
/* The sum, and `frames`; final: all of them are what they were to be. Returns an exit code. */
int tool_render_json(const struct vr_report *reports, size_t count, bool final, double seconds);

#endif
