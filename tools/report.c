/* Why: statistics are looked at, not read; one page that can be mailed or kept beside the data shows what a
 * volume holds and what its bricks cost. Invariants: the page refers to nothing outside itself and runs no
 * script; it depends on the file alone, not on time, place or threads. */
#include "report.h"

#include <stdlib.h>
#include <string.h>

#include <brick/io.h>

#include "message.h"
#include "page.h"
#include "progress.h"

static const char *file_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void print_head(FILE *out, const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    uint64_t file_bytes = brick_volume_file_bytes(inventory->volume);
    const char *name = file_name(brick_volume_path(inventory->volume));
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>",
          out);
    page_text(out, name);
    fputs("</title>\n<style>\n", out);
    report_style(out);
    fputs("</style>\n</head>\n<body>\n<header>\n<h1>", out);
    page_text(out, name);
    fprintf(out, "</h1>\n<p>%s &times; %s &times; %s voxels of %s: %s in a file of %s</p>\n</header>\n",
            page_count(grid->dims[0]).text, page_count(grid->dims[1]).text, page_count(grid->dims[2]).text,
            brick_type_name(grid->type), tool_size_text(inventory->level[0].voxel_bytes).text,
            tool_size_text(file_bytes).text);
}

static int print_page(FILE *out, const struct inventory *inventory, const struct survey *survey,
                      struct brick_error *err)
{
    const char *provenance = brick_volume_provenance(inventory->volume);
    print_head(out, inventory);
    report_facts(out, inventory);
    int code = report_planes(out, inventory, survey, err);
    if (!code)
        code = report_charts(out, inventory, survey, err);
    if (code)
        return code;
    report_levels(out, inventory);
    report_heaviest(out, inventory);
    if (provenance && *provenance) {
        fputs("<section>\n<h2>Provenance</h2>\n<pre>", out);
        page_text(out, provenance);
        fputs("</pre>\n</section>\n", out);
    }
    fprintf(out, "<footer>brick %s</footer>\n</body>\n</html>\n", BRICK_VERSION);
    return 0;
}

/* The page is made in memory, so that a failure on the way leaves no half of it. */
static int make_page(char **text, size_t *bytes, const struct inventory *inventory,
                     const struct survey *survey, struct brick_error *err)
{
    *text = NULL;
    FILE *out = open_memstream(text, bytes);
    int code = out ? print_page(out, inventory, survey, err) : BRICK_OK;
    bool failed = !out || ferror(out);
    failed = (out && fclose(out)) || failed;
    return code || !failed ? code : brick_fail(err, BRICK_ERR_MEMORY, "out of memory for the report");
}

int report_write(const struct inventory *inventory, const char *path, unsigned threads, bool quiet,
                 struct brick_error *err)
{
    struct brick_part part = {BRICK_IO_CLOSED, NULL};
    struct survey survey = {0};
    struct tool_progress progress;
    char *text = NULL;
    size_t bytes = 0;
    int code = brick_part_create(&part, path, err); /* before the work: a bad path is known at once */
    if (!code) {
        tool_progress_init(&progress, "report", 0, quiet);
        code = survey_init(&survey, inventory->volume, threads, tool_progress_update, &progress, err);
        tool_progress_finish(&progress);
    }
    if (!code && !(code = make_page(&text, &bytes, inventory, &survey, err)) &&
        !(code = brick_io_write_at(&part.io, 0, text, bytes, err)))
        code = brick_part_publish(&part, err);
    brick_part_discard(&part);
    survey_finish(&survey);
    free(text);
    return code;
}
