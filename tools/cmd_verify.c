/* Why: `brick verify`: trust in a file, from its own redundancy alone. */
#include <stdio.h>

#include <brick/build.h>
#include <cjson/cJSON.h>

#include "command.h"
#include "message.h"
#include "options.h"
#include "progress.h"

static int check(const char *path, unsigned threads, bool json, bool quiet)
{
    struct brick_volume *volume = NULL;
    struct brick_error err = {0};
    struct tool_progress progress;

    int code = brick_volume_open(&volume, path, &err);
    if (!code) {
        tool_progress_init(&progress, "verify", brick_volume_file_bytes(volume), quiet);
        code = brick_check(volume, threads, tool_progress_update, &progress, &err);
        tool_progress_finish(&progress);
    }
    if (code) {
        code = tool_fail("verify", &err);
    } else if (json) {
        cJSON *object = cJSON_CreateObject();
        cJSON_AddBoolToObject(object, "ok", 1);
        cJSON_AddNumberToObject(object, "bricks", (double)brick_volume_grid(volume)->bricks);
        cJSON_AddNumberToObject(object, "file_bytes", (double)brick_volume_file_bytes(volume));
        code = tool_json_print("verify", object);
    } else if (!quiet) {
        printf("%s: ok, %llu bricks\n", path, (unsigned long long)brick_volume_grid(volume)->bricks);
    }
    brick_volume_close(&volume);
    return code;
}

int cmd_verify(int argc, char **argv)
{
    uint32_t threads = 0;
    bool json = false, quiet = false;
    int first = 0;
    const struct tool_option options[] = {TOOL_OPTION_THREADS(&threads), TOOL_OPTION_JSON(&json),
                                          TOOL_OPTION_QUIET(&quiet)};
    const struct tool_usage usage = {
        .command = "verify",
        .arguments = "FILE [OPTIONS]",
        .summary = "Check every checksum, range, mask, macrocell, border and statistic of a .brick file.\n"
                   "The first contradiction is reported.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    return code >= 0 ? code : check(argv[first], threads, json, quiet);
}
