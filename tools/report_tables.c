/* Why: the report's numbers: what the volume is, what each level costs, and which bricks cost most. */
#include <inttypes.h>
#include <string.h>

#include "message.h"
#include "page.h"
#include "report.h"

#define HEAVIEST 20

static void fact(FILE *out, const char *name, const char *value, const char *more)
{
    fprintf(out, "<div><dt>%s</dt><dd>", name);
    page_text(out, value);
    if (*more) {
        fputs("<small>", out);
        page_text(out, more);
        fputs("</small>", out);
    }
    fputs("</dd></div>\n", out);
}

static void place_facts(FILE *out, const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    const double *spacing = inventory->spacing_mm;
    char value[256], more[256];
    snprintf(value, sizeof value, "%.5g \u00d7 %.5g \u00d7 %.5g", spacing[0], spacing[1], spacing[2]);
    snprintf(more, sizeof more, "mm; axes %s", inventory->axes);
    fact(out, "Spacing", value, more);
    snprintf(value, sizeof value, "%s \u00d7 %s \u00d7 %s",
             page_value((double)grid->dims[0] * spacing[0]).text,
             page_value((double)grid->dims[1] * spacing[1]).text,
             page_value((double)grid->dims[2] * spacing[2]).text);
    fact(out, "Extent", value, "mm");
    snprintf(value, sizeof value, "%s \u00d7 stored %s %s", page_value(grid->slope).text,
             grid->intercept < 0 ? "\u2212" : "+",
             page_value(grid->intercept < 0 ? -grid->intercept : grid->intercept).text);
    fact(out, "Physical value", value, "in the unit of the source");
}

static void brick_facts(FILE *out, const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    char value[256], more[256] = "";
    snprintf(more, sizeof more, "core %u\u00b3, border %u, macrocell %u", grid->edge, grid->border,
             grid->macrocell);
    fact(out, "Bricks", page_count(grid->bricks).text, more);
    snprintf(more, sizeof more, "%s bricks with one value and no payload",
             page_count(inventory->constant).text);
    fact(out, "Constant", page_percent((double)inventory->constant / (double)grid->bricks).text, more);
    uint64_t bytes = brick_volume_file_bytes(inventory->volume);
    snprintf(value, sizeof value, "%.2f", (double)inventory->level[0].voxel_bytes / (double)bytes);
    snprintf(more, sizeof more, "voxels of level 0 / file; codec");
    bool any = false;
    for (int codec = 0; codec < BRICK_CODEC_COUNT; codec++)
        if (inventory->codec_used[codec]) {
            strncat(more, " ", sizeof more - strlen(more) - 1);
            strncat(more, brick_codec_name((enum brick_codec)codec), sizeof more - strlen(more) - 1);
            any = true;
        }
    strncat(more, any ? "" : " none", sizeof more - strlen(more) - 1);
    fact(out, "Ratio", value, more);
}

void report_facts(FILE *out, const struct inventory *inventory)
{
    const struct brick_stats *stats = brick_volume_stats(inventory->volume);
    char value[256], more[256];
    fputs("<dl>\n", out);
    place_facts(out, inventory);
    brick_facts(out, inventory);
    if (stats->count) {
        snprintf(value, sizeof value, "%s \u2026 %s", page_value(inventory->range[0]).text,
                 page_value(inventory->range[1]).text);
        fact(out, "Range", value, "physical value");
        snprintf(value, sizeof value, "%s \u00b1 %s", page_value(inventory->mean).text,
                 page_value(inventory->deviation).text);
        fact(out, "Mean", value, "and standard deviation");
        snprintf(value, sizeof value, "%s \u2026 %s \u2026 %s", page_value(inventory->percentile[1]).text,
                 page_value(inventory->percentile[3]).text, page_value(inventory->percentile[5]).text);
        fact(out, "Percentiles", value, "5%, median, 95%");
    }
    snprintf(more, sizeof more, "of %s voxels", page_count(stats->count + stats->nonfinite).text);
    fact(out, "Not finite", page_count(stats->nonfinite).text, more);
    if (inventory->tf) {
        snprintf(more, sizeof more, "%s bricks of level 0, with %s",
                 page_count(inventory->tf_active.bricks_active).text, inventory->tf);
        fact(out, "Visible",
             page_percent((double)inventory->tf_active.bricks_active / (double)inventory->level[0].bricks)
                 .text,
             more);
    }
    fputs("</dl>\n", out);
}

void report_levels(FILE *out, const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    uint64_t total = 0;
    for (uint32_t l = 0; l < grid->levels; l++)
        total += inventory->level[l].payload_bytes;
    fputs(
        "<section>\n<h2>Levels</h2>\n<p>Level 0 is full resolution; each coarser one averages voxels of the "
        "one before. The ratio is the bytes of a level&#39;s voxels, without borders, by the bytes of its "
        "bricks as stored.</p>\n<div class=\"wide\"><table id=\"levels\">\n<tr><th>level</th><th>voxels</th>"
        "<th>bricks</th><th>constant</th><th>voxel bytes</th><th>stored bytes</th><th>ratio</th>"
        "<th>share of payloads</th><th></th></tr>\n",
        out);
    for (uint32_t l = 0; l < grid->levels; l++) {
        const uint64_t *dims = grid->level[l].dims;
        uint64_t bytes = inventory->level[l].payload_bytes;
        double share = total ? (double)bytes / (double)total : 0;
        char ratio[32] = "\u2013";
        if (bytes)
            snprintf(ratio, sizeof ratio, "%.2f", (double)inventory->level[l].voxel_bytes / (double)bytes);
        fprintf(out, "<tr><td>%u</td><td>%s &times; %s &times; %s</td><td>%s</td><td>%s</td><td>%s</td>", l,
                page_count(dims[0]).text, page_count(dims[1]).text, page_count(dims[2]).text,
                page_count(inventory->level[l].bricks).text,
                page_percent((double)inventory->level[l].constant / (double)inventory->level[l].bricks).text,
                page_count(inventory->level[l].voxel_bytes).text);
        fprintf(
            out,
            "<td>%s</td><td>%s</td><td>%s</td><td class=\"bar\"><i style=\"width:%.2f%%\"></i></td></tr>\n",
            page_count(bytes).text, ratio, page_percent(share).text, 100 * share);
    }
    fputs("</table></div>\n</section>\n", out);
}

/* The heaviest bricks, heaviest first, the lower number first among equals. Returns how many. */
static int find_heaviest(const struct inventory *inventory, uint64_t id[HEAVIEST])
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    uint32_t bytes[HEAVIEST];
    int n = 0;
    for (uint64_t i = 0; i < grid->bricks; i++) {
        uint32_t size = brick_volume_entry(inventory->volume, i)->bytes;
        if (!size || (n == HEAVIEST && size <= bytes[n - 1]))
            continue;
        int at = n < HEAVIEST ? n++ : n - 1;
        for (; at > 0 && bytes[at - 1] < size; at--) {
            bytes[at] = bytes[at - 1];
            id[at] = id[at - 1];
        }
        bytes[at] = size;
        id[at] = i;
    }
    return n;
}

static void heavy_row(FILE *out, const struct inventory *inventory, uint64_t id)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    const struct brick_entry *entry = brick_volume_entry(inventory->volume, id);
    struct brick_place place;
    double lo, hi;
    brick_grid_place(grid, id, &place);
    uint64_t decoded = brick_place_payload_bytes(grid, &place);
    fprintf(out, "<tr><td>%s</td><td>%u</td><td>%s, %s, %s</td><td>", page_count(id).text, place.level,
            page_count(place.at[0]).text, page_count(place.at[1]).text, page_count(place.at[2]).text);
    for (int a = 0; a < 3; a++) {
        uint64_t first = place.at[a] * grid->edge;
        fprintf(out, "%s%" PRIu64 "&ndash;%" PRIu64, a ? ", " : "", first, first + place.core[a] - 1);
    }
    fprintf(out, "</td><td>%s</td><td>%.1f%%</td><td>", page_count(entry->bytes).text,
            100 * (double)entry->bytes / (double)decoded);
    if (brick_volume_physical_range(inventory->volume, id, &lo, &hi))
        fprintf(out, "%s &hellip; %s", page_value(lo).text, page_value(hi).text);
    fprintf(out, "</td><td>%s</td><td>%s</td></tr>\n", page_count(entry->nonfinite).text,
            brick_codec_name((enum brick_codec)entry->codec));
}

void report_heaviest(FILE *out, const struct inventory *inventory)
{
    uint64_t id[HEAVIEST];
    int n = find_heaviest(inventory, id);
    if (!n)
        return;
    fprintf(out,
            "<section>\n<h2>Heaviest bricks</h2>\n<p>The %d bricks with the most stored bytes. Decoded, a "
            "brick holds its core, its border and the ranges of its macrocells.</p>\n"
            "<div class=\"wide\"><table id=\"heaviest\">\n<tr><th>brick</th><th>level</th><th>at x, y, z</th>"
            "<th>voxels of the level</th><th>stored bytes</th><th>of decoded</th><th>range</th>"
            "<th>not finite</th><th>codec</th></tr>\n",
            n);
    for (int i = 0; i < n; i++)
        heavy_row(out, inventory, id[i]);
    fputs("</table></div>\n</section>\n", out);
}
