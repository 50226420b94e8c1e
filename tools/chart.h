/* Charts as inline SVG: axes with round ticks, and bars, lines, bands or a picture within them. Colours come
 * from the page's style sheet. */
#ifndef TOOLS_CHART_H
#define TOOLS_CHART_H

#include <stdbool.h>

#include "page.h"

struct chart {
    FILE *out;
    const char *title; /* for those who do not see it */
    const char *x_label, *y_label;
    double x[2], y[2]; /* ends of the axes, ascending */
    bool y_log;        /* y[0] > 0 */
};

/* Draws the axes; the chart is constant from then on. The plot's place and the axes' ends are attributes of
 * the svg element (data-plot: left, top, width, height), so that programs can read a curve. */
void chart_begin(const struct chart *chart);
void chart_end(const struct chart *chart);

/* n bars side by side, bar i from low + i * width on, y[0] high where count is below y[0]. */
void chart_bars(const struct chart *chart, double low, double width, const double *count, uint32_t n);
/* Points with ascending x. style: a class. */
void chart_line(const struct chart *chart, const char *style, const double *x, const double *y, uint32_t n);
/* From x0 to x1, behind what follows. */
void chart_band(const struct chart *chart, double x0, double x1);
/* From the corner (x[0], y[0]) to (x[1], y[1]) in between the axes; linear ones. */
void chart_diagonal(const struct chart *chart);
/* A picture over the whole plot. */
int chart_picture(const struct chart *chart, const struct fmt_samples *samples, struct brick_error *err);

#endif
