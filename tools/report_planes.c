/* Why: slices show what the numbers are about; maps of the same slices show where the bytes go. Map and
 * picture cover the same ground, so that they can be compared by eye. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "page.h"
#include "report.h"

/* The nearest patient direction at the low (0) or high (1) end of an index axis. */
static char direction(const struct inventory *inventory, int axis, bool high)
{
    static const char pairs[] = "LRPASI";
    char code = inventory->axes[axis];
    return high ? code : pairs[(strchr(pairs, code) - pairs) ^ 1];
}

static const char *plane_name(const struct inventory *inventory, const struct survey_plane *plane)
{
    char code = inventory->axes[plane->normal];
    return strchr("LR", code) ? "Sagittal" : strchr("PA", code) ? "Coronal" : "Axial";
}

/* A frame of the slice's shape; a very long one is cut down to what can be looked at. */
static void open_frame(FILE *out, const struct inventory *inventory, const struct survey_plane *plane,
                       const char *style)
{
    const uint64_t *dims = brick_volume_grid(inventory->volume)->dims;
    double aspect = (double)dims[plane->across] * inventory->spacing_mm[plane->across] /
                    ((double)dims[plane->down] * inventory->spacing_mm[plane->down]);
    aspect = fmin(fmax(aspect, 0.25), 8);
    fprintf(out, "<div class=\"frame%s\" style=\"aspect-ratio:%.5f;max-width:%.0fpx\">", style, aspect,
            aspect < 1 ? 420 * aspect : 420);
}

static int print_picture(FILE *out, const struct inventory *inventory, const struct survey_plane *plane,
                         struct brick_error *err)
{
    const struct brick_level *level = &brick_volume_grid(inventory->volume)->level[plane->level];
    fputs("<figure>\n<h3>", out);
    fprintf(out, "%s</h3>\n", plane_name(inventory, plane));
    open_frame(out, inventory, plane, "");
    fprintf(out, "<img alt=\"%s slice through the middle\" src=\"", plane_name(inventory, plane));
    int code = page_picture(out, &(struct fmt_samples){plane->width, plane->height, 1, plane->gray}, err);
    fprintf(out,
            "\"><b style=\"left:6px;top:calc(50%% - 6px)\">%c</b><b style=\"right:6px;top:calc(50%% - "
            "6px)\">%c</b>"
            "<b style=\"left:calc(50%% - 4px);top:6px\">%c</b><b style=\"left:calc(50%% - "
            "4px);bottom:6px\">%c</b>"
            "</div>\n",
            direction(inventory, plane->across, plane->across_turned),
            direction(inventory, plane->across, !plane->across_turned),
            direction(inventory, plane->down, plane->down_turned),
            direction(inventory, plane->down, !plane->down_turned));
    fprintf(out,
            "<figcaption>%c = %s (0 &hellip; %s), level %u, %u &times; %u pixels</figcaption>\n</figure>\n",
            "xyz"[plane->normal], page_count(plane->voxel).text,
            page_count(level->dims[plane->normal] - 1).text, plane->level, plane->width, plane->height);
    return code;
}

/* What a map shows: a number of each cell, with 1 at the end of the colours. */
struct scale {
    const char *name;
    size_t member; /* offset of a float in struct survey_cell */
    double most;
};

static int print_map(FILE *out, const struct inventory *inventory, const struct survey_plane *plane,
                     const struct scale *scale, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    size_t cells = (size_t)plane->columns * plane->rows;
    uint8_t *rgba = calloc(cells, 4);
    if (!rgba)
        return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a map of %zu bricks", cells);
    for (size_t i = 0; i < cells; i++) {
        float value;
        if (plane->cell[i].constant)
            continue; /* transparent */
        memcpy(&value, (const char *)&plane->cell[i] + scale->member, sizeof value);
        page_colour((double)value / scale->most, rgba + 4 * i);
        rgba[4 * i + 3] = 255;
    }
    /* The last cells may reach beyond the volume: the frame cuts them. */
    double width =
        100.0 * (double)(plane->columns * plane->stride * grid->edge) / (double)grid->dims[plane->across];
    double height =
        100.0 * (double)(plane->rows * plane->stride * grid->edge) / (double)grid->dims[plane->down];
    fputs("<figure>\n", out);
    open_frame(out, inventory, plane, " map");
    fprintf(out,
            "<img class=\"cells\" alt=\"%s of bricks\" style=\"width:%.4f%%;height:%.4f%%;%s:0;%s:0\" src=\"",
            scale->name, width, height, plane->across_turned ? "right" : "left",
            plane->down_turned ? "bottom" : "top");
    int code = page_picture(out, &(struct fmt_samples){plane->columns, plane->rows, 4, rgba}, err);
    fprintf(out, "\"></div>\n<figcaption>%s, layer %s of bricks on %c", scale->name,
            page_count(plane->layer).text, "xyz"[plane->normal]);
    if (plane->stride > 1)
        fprintf(out, ", one brick in %s on each axis", page_count(plane->stride).text);
    fputs("</figcaption>\n</figure>\n", out);
    free(rgba);
    return code;
}

static int print_maps(FILE *out, const struct inventory *inventory, const struct survey *survey,
                      const struct scale *scale, struct brick_error *err)
{
    int code = 0;
    fputs("<div class=\"planes\">\n", out);
    for (int i = 0; i < 3 && !code; i++)
        code = print_map(out, inventory, &survey->plane[i], scale, err);
    fputs("</div>\n", out);
    return code;
}

int report_planes(FILE *out, const struct inventory *inventory, const struct survey *survey,
                  struct brick_error *err)
{
    const struct scale entropy = {"Entropy", offsetof(struct survey_cell, entropy),
                                  fmax(1, ceil(survey->entropy_max))};
    const struct scale size = {"Stored share", offsetof(struct survey_cell, size), 1};
    const char *f32 =
        brick_volume_grid(inventory->volume)->type == BRICK_F32 ? " (of f32 the upper 16 bits)" : "";
    int code = 0;
    fprintf(out,
            "<section id=\"slices\">\n<h2>Slices through the middle</h2>\n<p>Black is %s, white %s (the "
            "0.5%% and 99.5%% percentiles). Letters: patient left, right, posterior, anterior, superior, "
            "inferior, as far as the file knows.</p>\n<div class=\"planes\">\n",
            page_value(survey->window[0]).text, page_value(survey->window[1]).text);
    for (int i = 0; i < 3 && !code; i++)
        code = print_picture(out, inventory, &survey->plane[i], err);
    fprintf(
        out,
        "</div>\n</section>\n<section id=\"entropy\">\n<h2>Entropy of bricks</h2>\n<p>Bits a voxel of the "
        "values in a brick%s, each voxel by itself: what noise costs any codec that does not predict. The "
        "same slices as above, one cell a brick.</p>\n"
        "<div class=\"scale\">0 <i class=\"ramp\"></i> %.0f bits a voxel <i class=\"map\"></i> "
        "constant</div>\n",
        f32, entropy.most);
    if (!code)
        code = print_maps(out, inventory, survey, &entropy, err);
    fputs("</section>\n<section id=\"compressibility\">\n<h2>Compressibility of bricks</h2>\n<p>Stored bytes "
          "by "
          "decoded bytes: what the codec left of each brick.</p>\n"
          "<div class=\"scale\">0% <i class=\"ramp\"></i> 100% <i class=\"map\"></i> constant, nothing "
          "stored</div>\n",
          out);
    if (!code)
        code = print_maps(out, inventory, survey, &size, err);
    fputs("</section>\n", out);
    return code;
}
