/* What rendering took. */
#ifndef TOOLS_RENDER_REPORT_H
#define TOOLS_RENDER_REPORT_H

#include <stddef.h>

#include <renderer/renderer.h>

/* reports: of count >= 1 pictures; seconds: all of it, files included; final: as vr_render_continue
 * says. JSON on stdout; returns the exit code.
 */
int tool_render_json(const struct vr_report *reports, size_t count, bool final, double seconds);
/* A line on stderr. */
void tool_render_summary(const char *output, const char *mode, const struct vr_report *reports, size_t count,
                         bool final, double seconds);

#endif
