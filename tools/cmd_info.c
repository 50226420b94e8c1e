/* Why: `brick info`: everything a .brick file knows about itself, gathered once (inventory.c) and printed as
 * text or JSON. Only tables are read, no bricks, unless a report is asked for. */
#include "building.h"
#include "command.h"
#include "inventory.h"
#include "message.h"
#include "options.h"
#include "report.h"

int cmd_info(int argc, char **argv)
{
    bool json = false, bricks = false, macrocells = false, log_scale = false, quiet = false;
    const char *tf = NULL, *report = NULL;
    uint32_t threads = 0;
    int first = 0;
    const struct tool_option options[] = {
        TOOL_OPTION_JSON(&json),
        {"bricks", .target = &bricks, .help = "list every brick as well"},
        {"log", .target = &log_scale, .help = "draw the histogram's bars on a logarithmic scale"},
        {"tf", .value = "NAME|FILE", .parse = tool_parse_text, .target = &tf,
         .help = "say what share of level 0 a transfer function\nmakes visible"},
        {"macrocells", .target = &macrocells,
         .help = "with --tf: read the visible bricks and say what\nshare of their macrocells is visible"},
        {"report", .value = "OUT.html", .parse = tool_parse_text, .target = &report,
         .help = "write a page with slices, charts and tables as well;\nreads the bricks of three slices"},
        TOOL_OPTION_THREADS(&threads),
        TOOL_OPTION_QUIET(&quiet),
    };
    const struct tool_usage usage = {
        .command = "info",
        .arguments = "FILE [OPTIONS]",
        .summary = "Say what is in a .brick file.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    if (report && !tool_ends_in(report, ".html"))
        return tool_misuse("info", "--report %s: the name must end in .html", report);

    if (macrocells && !tf)
        return tool_misuse("info", "--macrocells goes with --tf");

    struct brick_volume *volume = NULL;
    struct inventory inventory = {0};
    struct brick_error err = {0};
    code = brick_volume_open(&volume, argv[first], &err);
    if (!code)
        code = inventory_init(&inventory, volume, tf, macrocells, threads, &err);
    if (!code && report)
        code = report_write(&inventory, report, threads, quiet, &err);
    if (code)
        code = tool_fail("info", &err);
    else if (json)
        code = inventory_print_json(&inventory, bricks);
    else
        inventory_print_text(&inventory, bricks, log_scale);
    brick_volume_close(&volume);
    return code;
}
