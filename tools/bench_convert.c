/* Why: conversion speed says little without the disk's: a plain copy of the same file, synced, is measured in
 * turns with the conversion, from a warm page cache and to the same folder. */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include <brick/io.h>
#include <brick/threads.h>
#include <cjson/cJSON.h>
#include <formats/formats.h>

#include "bench.h"
#include "building.h"
#include "message.h"

#define COMMAND    "bench convert"
#define COPY_BYTES (UINT64_C(1) << 20)

struct request {
    struct fmt_source_params in;
    struct tool_building building;
    const char *source, *folder;
    uint32_t repeat;
};

struct result {
    uint64_t source_bytes;
    struct bench_spread copy, convert;
    struct brick_build_report report;
};

static double seconds_since(uint64_t start_ns)
{
    return 1e-9 * (double)(brick_now_ns() - start_ns);
}

/* Copy and sync; output NULL: only read, to warm the page cache. */
static int copy_file(const char *input, const char *output, uint64_t *bytes, struct brick_error *err)
{
    struct brick_io in = BRICK_IO_CLOSED, out = BRICK_IO_CLOSED;
    void *buffer = malloc(COPY_BYTES);
    int code =
        buffer ? brick_io_open(&in, input, err) : brick_fail(err, BRICK_ERR_MEMORY, "no memory to copy");
    if (!code)
        code = brick_io_size(&in, bytes, err);
    if (!code && output)
        code = brick_io_create(&out, output, err);
    for (uint64_t at = 0; !code && at < *bytes; at += COPY_BYTES) {
        size_t n = (size_t)(*bytes - at < COPY_BYTES ? *bytes - at : COPY_BYTES);
        code = brick_io_read_at(&in, at, buffer, n, err);
        if (!code && output)
            code = brick_io_write_at(&out, at, buffer, n, err);
    }
    if (!code && output)
        code = brick_io_sync(&out, err);
    brick_io_close(&out);
    brick_io_close(&in);
    free(buffer);
    return code;
}

static int convert_file(const struct request *request, const char *output, struct brick_build_report *report,
                        struct brick_error *err)
{
    struct brick_source *source = NULL;
    int code = fmt_source_open(&source, request->source, &request->in, err);
    if (!code)
        code = brick_build(source, output, &request->building.params, report, err);
    brick_source_destroy(&source);
    return code;
}

static int measure(const struct request *request, struct result *result, struct brick_error *err)
{
    double copy[BENCH_REPEAT_MAX], convert[BENCH_REPEAT_MAX];
    char output[4096];
    int n = snprintf(output, sizeof output, "%s/bench-%ld.brick", request->folder, (long)getpid());
    if (n < 0 || (size_t)n >= sizeof output)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the name of the folder is too long");

    int code = copy_file(request->source, NULL, &result->source_bytes, err);
    for (uint32_t i = 0; i < request->repeat && !code; i++) {
        uint64_t start_ns = brick_now_ns();
        code = copy_file(request->source, output, &result->source_bytes, err);
        copy[i] = seconds_since(start_ns);
        unlink(output);
        if (code)
            break;
        start_ns = brick_now_ns();
        code = convert_file(request, output, &result->report, err);
        convert[i] = seconds_since(start_ns);
        unlink(output);
    }
    if (!code) {
        result->copy = bench_spread(copy, request->repeat);
        result->convert = bench_spread(convert, request->repeat);
    }
    return code;
}

/* One line a stage: what it cost all threads together, and what one core would put through. */
static void print_stages(const struct brick_build_report *report)
{
    printf("\n%-10s %10s %10s %14s\n", "stage", "core s", "MB", "MB/s a core");
    for (int s = 0; s < BRICK_STAGES; s++) {
        double seconds = 1e-9 * (double)report->stage[s].ns, mb = 1e-6 * (double)report->stage[s].bytes;
        if (report->stage[s].ns)
            printf("%-10s %10.4f %10.1f %14.1f\n", brick_build_stage_name((enum brick_build_stage)s), seconds,
                   mb, mb / seconds);
    }
    printf("%u encoding threads waited %.4f s for reading, %.4f s for writing; %s limits\n", report->threads,
           1e-9 * (double)report->wait_read_ns, 1e-9 * (double)report->wait_write_ns,
           brick_build_stage_name(brick_build_limit(report)));
}

static void print_text(const struct request *request, const struct result *result)
{
    double mb = 1e-6 * (double)result->source_bytes;
    printf("%s, codec %s, brick %u, %u repeats\n", tool_size_text(result->source_bytes).text,
           brick_codec_name(request->building.params.codec), request->building.params.edge, request->repeat);
    printf("%-8s %10s %10s %10s %10s\n", "", "median s", "min s", "max s", "MB/s");
    printf("%-8s %10.4f %10.4f %10.4f %10.1f\n", "copy", result->copy.median, result->copy.min,
           result->copy.max, mb / result->copy.median);
    printf("%-8s %10.4f %10.4f %10.4f %10.1f\n", "convert", result->convert.median, result->convert.min,
           result->convert.max, mb / result->convert.median);
    printf("convert runs at %.2f of the copy's speed; file %s\n",
           result->copy.median / result->convert.median, tool_size_text(result->report.output_bytes).text);
    print_stages(&result->report);
}

static int print_json(const struct result *result)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "source_bytes", (double)result->source_bytes);
    cJSON_AddNumberToObject(json, "output_bytes", (double)result->report.output_bytes);
    cJSON_AddNumberToObject(json, "copy_seconds", result->copy.median);
    cJSON_AddNumberToObject(json, "convert_seconds", result->convert.median);
    cJSON_AddNumberToObject(json, "convert_bytes_per_second",
                            (double)result->source_bytes / result->convert.median);
    cJSON_AddNumberToObject(json, "speed_of_copy", result->copy.median / result->convert.median);
    cJSON *stages = cJSON_AddObjectToObject(json, "stages");
    for (int s = 0; s < BRICK_STAGES; s++) {
        cJSON *stage = cJSON_AddObjectToObject(stages, brick_build_stage_name((enum brick_build_stage)s));
        cJSON_AddNumberToObject(stage, "core_seconds", 1e-9 * (double)result->report.stage[s].ns);
        cJSON_AddNumberToObject(stage, "bytes", (double)result->report.stage[s].bytes);
    }
    cJSON_AddStringToObject(json, "limit", brick_build_stage_name(brick_build_limit(&result->report)));
    cJSON_AddNumberToObject(json, "peak_rss_bytes", (double)brick_peak_rss_bytes());
    return tool_json_print(COMMAND, json);
}

int bench_convert(int argc, char **argv)
{
    struct request r = {.in = fmt_source_defaults, .repeat = 3, .folder = "."};
    bool has_size = false, has_type = false;
    int first = 0;
    tool_building_init(&r.building);
    const struct tool_option options[] = {
        {"size", .value = "NXxNYxNZ", .parse = tool_parse_dims, .target = r.in.dims, .given = &has_size,
         .help = "raw: voxels on each axis"},
        {"type", .value = "TYPE", .parse = tool_parse_type, .target = &r.in.type, .given = &has_type,
         .help = "raw: u8 i8 u16 i16 u32 i32 f32 f64"},
        {"repeat", .value = "N", .parse = tool_parse_u32, .target = &r.repeat,
         .limits = {.min = 1, .max = BENCH_REPEAT_MAX}, .help = "turns to take the median of (default 3)"},
        {"folder", .value = "DIR", .parse = tool_parse_text, .target = &r.folder,
         .help = "where the copies go, removed again (default .)"},
        TOOL_BUILDING_ROWS(r.building),
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "SRC [OPTIONS]",
        .summary = "Conversion of a file against a plain copy of it, both synced.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one SRC"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    if (has_size != has_type)
        return tool_misuse(COMMAND, "--size and --type go together");
    if ((code = tool_building_check(COMMAND, &r.building)) >= 0)
        return code;
    r.source = argv[first];
    r.building.params.nearest = r.building.downsample == 1;
    r.building.params.codec_level = (int)r.building.codec_level;

    struct result result = {0};
    struct brick_error err = {0};
    if (measure(&r, &result, &err))
        return tool_fail(COMMAND, &err);
    if (r.building.json)
        return print_json(&result);
    print_text(&r, &result);
    return 0;
}
