/* Why: the report's curves: how values spread over voxels, and over bricks, which is what paging and skipping
 * pay for. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/active.h>

#include "chart.h"
#include "report.h"

/* Square cells in the plot. */
#define RANGE_COLUMNS 84
#define RANGE_ROWS    44
#define RANGE_CELLS   (RANGE_COLUMNS * RANGE_ROWS)

/* The value axis, with a width also where there is only one value. */
static void value_axis(double axis[2], double low, double high)
{
    axis[0] = low;
    axis[1] = high > low ? high : low + fmax(1, fabs(low) * 1e-6);
}

static void chart_histogram(FILE *out, const struct inventory *inventory, const struct survey *survey)
{
    const struct histogram *histogram = &inventory->histogram;
    struct chart chart = {.out = out,
                          .title = "Histogram of the voxels' values, logarithmic",
                          .x_label = "physical value",
                          .y_label = "voxels (log scale)",
                          .y = {0.7, 1},
                          .y_log = true};
    double high = histogram->low + histogram->parts * histogram->width;
    value_axis(chart.x, histogram->low, high);
    for (uint32_t i = 0; i < histogram->parts; i++)
        chart.y[1] = fmax(chart.y[1], histogram->count[i]);
    chart.y[1] *= 2;
    fputs("<figure id=\"histogram\">\n<h3>Values</h3>\n", out);
    chart_begin(&chart);
    chart_band(&chart, survey->window[0], survey->window[1]);
    chart_bars(&chart, histogram->low, histogram->width > 0 ? histogram->width : chart.x[1] - chart.x[0],
               histogram->count, histogram->parts);
    chart_end(&chart);
    fprintf(
        out,
        "<figcaption>Voxels of level 0 in %u equal parts of the range, on a logarithmic scale. Shaded: the "
        "window of the slices above, %s to %s.</figcaption>\n</figure>\n",
        histogram->parts, page_value(survey->window[0]).text, page_value(survey->window[1]).text);
}

static void chart_active(FILE *out, const struct inventory *inventory)
{
    struct chart chart = {.out = out,
                          .title = "Share of active bricks by isovalue and threshold",
                          .x_label = "isovalue or threshold V (physical value)",
                          .y_label = "share (%)",
                          .y = {0, 100}};
    const double *value = inventory->active.value;
    const struct {
        const char *style, *key;
        const double *share;
    } curves[] = {{"voxels", "voxels &ge; V", inventory->active.voxels},
                  {"above", "bricks that reach V (window)", inventory->active.above},
                  {"crossed", "bricks that V crosses (isosurface)", inventory->active.crossed}};
    value_axis(chart.x, value[0], value[INVENTORY_SAMPLES - 1]);
    fputs("<figure id=\"active\">\n<h3>Active share</h3>\n", out);
    chart_begin(&chart);
    for (size_t i = 0; i < sizeof curves / sizeof *curves; i++) {
        double percent[INVENTORY_SAMPLES];
        for (int k = 0; k < INVENTORY_SAMPLES; k++)
            percent[k] = 100 * curves[i].share[k];
        chart_line(&chart, curves[i].style, value, percent, INVENTORY_SAMPLES);
    }
    chart_end(&chart);
    fputs("<div class=\"legend\">", out);
    for (size_t i = sizeof curves / sizeof *curves; i-- > 0;)
        fprintf(out, "<span><span class=\"key %s\"></span>%s</span>\n", curves[i].style, curves[i].key);
    fputs("</div>\n<figcaption>Of level 0&#39;s bricks, the share that a picture may have to load: for an "
          "isosurface at V, and for a window that shows everything from V up. The distance to the share of "
          "voxels is what bricks cost over voxels.</figcaption>\n</figure>\n",
          out);
}

/* Count bricks by (smallest, largest): row 0 has the largest maxima. Returns the highest count. */
static uint64_t count_ranges(const struct inventory *inventory, const double axis[2], uint64_t *cell)
{
    uint64_t peak = 0;
    for (uint64_t id = 0; id < inventory->level[0].bricks; id++) {
        double lo, hi;
        if (!brick_volume_physical_range(inventory->volume, id, &lo, &hi))
            continue;
        double x = (lo - axis[0]) / (axis[1] - axis[0]) * RANGE_COLUMNS;
        double y = (hi - axis[0]) / (axis[1] - axis[0]) * RANGE_ROWS;
        int column = x > 0 ? (int)fmin(x, RANGE_COLUMNS - 1) : 0,
            row = y > 0 ? (int)fmin(y, RANGE_ROWS - 1) : 0;
        uint64_t n = ++cell[(RANGE_ROWS - 1 - row) * RANGE_COLUMNS + column];
        peak = n > peak ? n : peak;
    }
    return peak;
}

static int chart_ranges(FILE *out, const struct inventory *inventory, struct brick_error *err)
{
    struct chart chart = {.out = out,
                          .title = "Bricks by their smallest and largest value",
                          .x_label = "smallest value of the brick (physical)",
                          .y_label = "largest value (physical)"};
    value_axis(chart.x, inventory->range[0], inventory->range[1]);
    memcpy(chart.y, chart.x, sizeof chart.y);
    uint64_t *cell = calloc(RANGE_CELLS, sizeof *cell);
    uint8_t *rgba = calloc(RANGE_CELLS, 4);
    int code = cell && rgba ? 0 : brick_fail(err, BRICK_ERR_MEMORY, "out of memory for the report");
    if (!code) {
        uint64_t peak = count_ranges(inventory, chart.x, cell);
        for (size_t i = 0; i < RANGE_CELLS; i++)
            if (cell[i]) {
                page_colour(peak > 1 ? log((double)cell[i]) / log((double)peak) : 0, rgba + 4 * i);
                rgba[4 * i + 3] = 255;
            }
        fputs("<figure id=\"ranges\">\n<h3>Ranges of bricks</h3>\n", out);
        chart_begin(&chart);
        chart_diagonal(&chart);
        code = chart_picture(&chart, &(struct fmt_samples){RANGE_COLUMNS, RANGE_ROWS, 4, rgba}, err);
        chart_end(&chart);
        fprintf(
            out,
            "<div class=\"scale\">1 brick <i class=\"ramp\"></i> %s (log scale)</div>\n"
            "<figcaption>Level 0&#39;s bricks by smallest and largest value. On the dashed line both are "
            "the same; far above it, bricks mix very different values and are seldom skipped.</figcaption>\n"
            "</figure>\n",
            page_count(peak).text);
    }
    free(cell);
    free(rgba);
    return code;
}

static void chart_sizes(FILE *out, const struct inventory *inventory)
{
    double count[INVENTORY_SIZE_PARTS], most = 1;
    for (int i = 0; i < INVENTORY_SIZE_PARTS; i++) {
        count[i] = (double)inventory->size.part[i];
        most = fmax(most, count[i]);
    }
    const struct chart chart = {.out = out,
                                .title = "Bricks by stored share of their decoded size",
                                .x_label = "stored / decoded bytes (%)",
                                .y_label = "bricks",
                                .x = {0, 100},
                                .y = {0, 1.05 * most}};
    fputs("<figure id=\"sizes\">\n<h3>Sizes of bricks</h3>\n", out);
    chart_begin(&chart);
    chart_bars(&chart, 0, 100.0 / INVENTORY_SIZE_PARTS, count, INVENTORY_SIZE_PARTS);
    chart_end(&chart);
    fprintf(out,
            "<figcaption>The %s bricks of all levels that have a payload, by what the codec leaves of them: "
            "%s to %s bytes, median %s. What did not get smaller counts in the last bar. %s constant bricks "
            "are not drawn.</figcaption>\n</figure>\n",
            page_count(inventory->size.count).text, page_count(inventory->size.smallest).text,
            page_count(inventory->size.largest).text,
            page_count(inventory->size.percentile[INVENTORY_PERCENTILES / 2]).text,
            page_count(inventory->constant).text);
}

int report_charts(FILE *out, const struct inventory *inventory, const struct survey *survey,
                  struct brick_error *err)
{
    int code = 0;
    bool values = brick_volume_stats(inventory->volume)->count > 0;
    fputs("<section>\n<h2>Values and bricks</h2>\n", out);
    if (!values)
        fputs("<p>No voxel is finite.</p>\n", out);
    fputs("<div class=\"charts\">\n", out);
    if (values) {
        chart_histogram(out, inventory, survey);
        chart_active(out, inventory);
        code = chart_ranges(out, inventory, err);
    }
    if (inventory->size.count)
        chart_sizes(out, inventory);
    fputs("</div>\n</section>\n", out);
    return code;
}
