/* Why: one way to draw axes for every chart of a report. Invariant: nothing is drawn outside the plot; values
 * beyond an axis' ends are moved to it. */
#include "chart.h"

#include <math.h>

#define WIDTH  600
#define HEIGHT 330
#define LEFT   66
#define RIGHT  16
#define TOP    14
#define BOTTOM 48
#define TICKS  6
#define PLOT_W (WIDTH - LEFT - RIGHT)
#define PLOT_H (HEIGHT - TOP - BOTTOM)

static double clamped(double t)
{
    return t > 0 ? fmin(t, 1) : 0;
}

static double at_x(const struct chart *chart, double x)
{
    return LEFT + PLOT_W * clamped((x - chart->x[0]) / (chart->x[1] - chart->x[0]));
}

static double at_y(const struct chart *chart, double y)
{
    double t = chart->y_log ? log10(fmax(y, chart->y[0]) / chart->y[0]) / log10(chart->y[1] / chart->y[0])
                            : (y - chart->y[0]) / (chart->y[1] - chart->y[0]);
    return TOP + PLOT_H * (1 - clamped(t));
}

/* 1, 2 or 5 times a power of ten: the least that gives at most `most` steps. */
static double tick_step(double length, int most)
{
    double power = pow(10, floor(log10(length / most)));
    for (int i = 0; i < 3; i++) {
        double step = power * (double[]){1, 2, 5}[i];
        if (length / step <= most)
            return step;
    }
    return 10 * power;
}

static void tick_x(const struct chart *chart, double x)
{
    double place = at_x(chart, x);
    fprintf(
        chart->out,
        "<path class=\"grid\" d=\"M%.1f %d v%d\"/><text x=\"%.1f\" y=\"%d\" class=\"tick mid\">%s</text>\n",
        place, TOP, PLOT_H, place, HEIGHT - BOTTOM + 18, page_value(x).text);
}

static void tick_y(const struct chart *chart, double y, const char *text)
{
    double place = at_y(chart, y);
    fprintf(
        chart->out,
        "<path class=\"grid\" d=\"M%d %.1f h%d\"/><text x=\"%d\" y=\"%.1f\" class=\"tick end\">%s</text>\n",
        LEFT, place, PLOT_W, LEFT - 8, place + 4, text);
}

static void ticks_log(const struct chart *chart)
{
    static const char *const units[] = {"", "k", "M", "G", "T", "P", "E"};
    int first = (int)ceil(log10(chart->y[0]) - 1e-9), last = (int)floor(log10(chart->y[1]) + 1e-9);
    int each = (last - first) / 6 + 1;
    for (int decade = first; decade <= last; decade += each) {
        char text[32];
        int unit = decade >= 3 ? decade / 3 : 0;
        unit = unit > 6 ? 6 : unit;
        snprintf(text, sizeof text, "%g %s", pow(10, decade - 3 * unit), units[unit]);
        tick_y(chart, pow(10, decade), text);
    }
}

/* Ticks are whole multiples of the step, so that none is "0.30000000000000004". Their number is bounded also
 * where the axis is so short that a step is lost in rounding. */
static void ticks(const struct chart *chart)
{
    double step = tick_step(chart->x[1] - chart->x[0], TICKS), first = ceil(chart->x[0] / step - 1e-9);
    for (int i = 0; i <= TICKS && (first + i) * step <= chart->x[1] + 1e-9 * step; i++)
        tick_x(chart, (first + i) * step);
    if (chart->y_log) {
        ticks_log(chart);
        return;
    }
    step = tick_step(chart->y[1] - chart->y[0], TICKS);
    first = ceil(chart->y[0] / step - 1e-9);
    for (int i = 0; i <= TICKS && (first + i) * step <= chart->y[1] + 1e-9 * step; i++)
        tick_y(chart, (first + i) * step, page_value((first + i) * step).text);
}

void chart_begin(const struct chart *chart)
{
    fprintf(chart->out,
            "<svg viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"%s\" data-plot=\"%d %d %d %d\" "
            "data-x=\"%.17g %.17g\" data-y=\"%.17g %.17g\">\n",
            WIDTH, HEIGHT, chart->title, LEFT, TOP, PLOT_W, PLOT_H, chart->x[0], chart->x[1], chart->y[0],
            chart->y[1]);
    ticks(chart);
    fprintf(chart->out,
            "<text x=\"%d\" y=\"%d\" class=\"label mid\">%s</text>"
            "<text transform=\"translate(14 %d) rotate(-90)\" class=\"label mid\">%s</text>\n",
            LEFT + PLOT_W / 2, HEIGHT - 8, chart->x_label, TOP + PLOT_H / 2, chart->y_label);
}

void chart_end(const struct chart *chart)
{
    fprintf(chart->out, "<path class=\"axis\" d=\"M%d %d v%d h%d\"/></svg>\n", LEFT, TOP, PLOT_H, PLOT_W);
}

void chart_bars(const struct chart *chart, double low, double width, const double *count, uint32_t n)
{
    fprintf(chart->out, "<path class=\"bars\" d=\"M%.2f %d", at_x(chart, low), TOP + PLOT_H);
    for (uint32_t i = 0; i < n; i++)
        fprintf(chart->out, "V%.2fH%.2f", at_y(chart, count[i]), at_x(chart, low + (i + 1) * width));
    fprintf(chart->out, "V%dZ\"/>\n", TOP + PLOT_H);
}

void chart_line(const struct chart *chart, const char *style, const double *x, const double *y, uint32_t n)
{
    fprintf(chart->out, "<path class=\"line %s\" d=\"", style);
    for (uint32_t i = 0; i < n; i++)
        fprintf(chart->out, "%c%.2f %.2f", i ? 'L' : 'M', at_x(chart, x[i]), at_y(chart, y[i]));
    fputs("\"/>\n", chart->out);
}

void chart_band(const struct chart *chart, double x0, double x1)
{
    double left = at_x(chart, x0);
    fprintf(chart->out, "<rect class=\"band\" x=\"%.2f\" y=\"%d\" width=\"%.2f\" height=\"%d\"/>\n", left,
            TOP, at_x(chart, x1) - left, PLOT_H);
}

void chart_diagonal(const struct chart *chart)
{
    fprintf(chart->out, "<path class=\"diagonal\" d=\"M%d %d L%d %d\"/>\n", LEFT, TOP + PLOT_H, LEFT + PLOT_W,
            TOP);
}

int chart_picture(const struct chart *chart, const struct fmt_samples *samples, struct brick_error *err)
{
    fprintf(
        chart->out,
        "<image class=\"cells\" x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" preserveAspectRatio=\"none\" "
        "href=\"",
        LEFT, TOP, PLOT_W, PLOT_H);
    int code = page_picture(chart->out, samples, err);
    fputs("\"/>\n", chart->out);
    return code;
}
