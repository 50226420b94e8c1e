/* Why: every command speaks in the same form, one line a message, so that scripts can rely on it. */
#include "message.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cjson/cJSON.h>

#include "command.h"

int tool_fail(const char *command, const struct brick_error *err)
{
    fprintf(stderr, "brick %s: %s\n", command, err->message);
    return TOOL_FAILED;
}

int tool_misuse(const char *command, const char *format, ...)
{
    va_list args;
    fprintf(stderr, "brick %s: ", command);
    va_start(args, format);
    vfprintf(stderr, format, args);
    va_end(args);
    fprintf(stderr, "; see 'brick %s --help'\n", command);
    return TOOL_USAGE;
}

void tool_note(const char *command, const char *format, ...)
{
    va_list args;
    fprintf(stderr, "brick %s: note: ", command);
    va_start(args, format);
    vfprintf(stderr, format, args);
    va_end(args);
    fputc('\n', stderr);
}

struct tool_size tool_size_text(uint64_t bytes)
{
    static const char *const units[] = {"B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
    struct tool_size size;
    double value = (double)bytes;
    size_t unit = 0;
    while (value >= 1024 && unit + 1 < sizeof units / sizeof *units) {
        value /= 1024;
        unit++;
    }
    snprintf(size.text, sizeof size.text, unit ? "%.1f %s" : "%.0f %s", value, units[unit]);
    return size;
}

int tool_json_print(const char *command, struct cJSON *object)
{
    char *text = object ? cJSON_Print(object) : NULL;
    cJSON_Delete(object);
    if (!text) {
        struct brick_error err;
        brick_fail(&err, BRICK_ERR_MEMORY, "out of memory for the JSON output");
        return tool_fail(command, &err);
    }
    puts(text);
    cJSON_free(text);
    return TOOL_DONE;
}
