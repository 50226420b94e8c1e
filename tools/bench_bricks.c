/* Why: the brick's edge trades borders, which cost bytes and time, against how closely bricks follow what is
 * visible. So one volume is converted at every edge, and pictures are made from each file: what a user pays
 * is conversion, bytes on disk, bytes read for a picture, and seconds until it is there. Edges take turns. */
#include <stdio.h>
#include <unistd.h>

#include <brick/threads.h>
#include <formats/formats.h>

#include "bench_view.h"
#include "building.h"
#include "message.h"
#include "transfer.h"

#define COMMAND "bench bricks"

static const uint32_t edges[] = {16, 32, 64, 128};
enum { EDGES = TOOL_COUNT(edges), LOOKS_MAX = 8, REPEAT_MAX = 50 };

struct request {
    struct fmt_source_params in;
    const char *source, *folder;
    struct tool_list tf;
    struct bench_view view;
    struct vr_quality quality;
    struct vr_renderer_params renderer;
    uint32_t repeat;
};

/* Of one edge and one transfer function. */
struct look {
    double first[REPEAT_MAX], again[REPEAT_MAX]; /* seconds: with loading and compiling; with all there */
    struct vr_report report;                     /* of the first */
};

struct result {
    double convert[REPEAT_MAX];
    struct brick_build_report report;
    struct look look[LOOKS_MAX];
};

static int convert(const struct request *r, uint32_t edge, const char *path, struct result *result,
                   uint32_t turn, struct brick_error *err)
{
    struct brick_source *source = NULL;
    struct brick_build_params params = brick_build_defaults;
    params.edge = edge;
    int code = fmt_source_open(&source, r->source, &r->in, err);
    if (!code)
        code = brick_build(source, path, &params, &result->report, err);
    brick_source_destroy(&source);
    result->convert[turn] = result->report.seconds;
    return code;
}

static int look_at(const struct request *r, const struct brick_volume *volume, const char *tf,
                   struct look *look, uint32_t turn, struct brick_error *err)
{
    struct vr_scene scene;
    struct vr_renderer *renderer = NULL;
    struct brick_transfer *transfer = NULL;
    struct brick_image image = {0};
    struct vr_report report;
    bench_view_scene(&r->view, volume, &scene);
    int code = tool_transfer_load(&transfer, tf, volume, err);
    scene.transfer = transfer;
    if (!code)
        code = brick_image_init(&image, scene.width, scene.height, err);
    if (!code)
        code = vr_renderer_create(&renderer, volume, &r->renderer, err);
    if (!code)
        code = vr_render(renderer, &scene, &r->quality, &image, &look->report, err);
    if (!code)
        code = vr_render(renderer, &scene, &r->quality, &image, &report, err);
    look->first[turn] = look->report.seconds_frame;
    look->again[turn] = report.seconds_frame;
    vr_renderer_destroy(&renderer);
    brick_image_finish(&image);
    brick_transfer_destroy(&transfer);
    return code;
}

static int measure(const struct request *r, struct result *results, struct brick_error *err)
{
    char path[4096];
    int n = snprintf(path, sizeof path, "%s/bench-%ld.brick", r->folder, (long)getpid()), code = 0;
    if (n < 0 || (size_t)n >= sizeof path)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the name of the folder is too long");
    for (uint32_t turn = 0; turn < r->repeat && !code; turn++)
        for (size_t e = 0; e < EDGES && !code; e++) {
            struct brick_volume *volume = NULL;
            code = convert(r, edges[e], path, &results[e], turn, err);
            if (!code)
                code = brick_volume_open(&volume, path, err);
            for (size_t t = 0; t < r->tf.count && !code; t++)
                code = look_at(r, volume, r->tf.item[t], &results[e].look[t], turn, err);
            brick_volume_close(&volume);
            unlink(path);
        }
    return code;
}

static void print_text(const struct request *r, struct result *results)
{
    printf("%ux%u, step %g, %u turns, border %u\n", r->view.size[0], r->view.size[1], r->quality.step_vox,
           r->repeat, brick_build_defaults.border);
    printf("%-6s%10s%12s", "edge", "convert s", "file MB");
    for (size_t t = 0; t < r->tf.count; t++)
        printf("   %-10.10s%8s%9s%9s", r->tf.item[t], "read MB", "first s", "frame s");
    printf("%10s\n", "sum s");
    for (size_t e = 0; e < EDGES; e++) {
        struct result *s = &results[e];
        double sum = bench_spread(s->convert, r->repeat).median;
        printf("%-6u%10.3f%12.1f", edges[e], sum, 1e-6 * (double)s->report.output_bytes);
        for (size_t t = 0; t < r->tf.count; t++) {
            struct look *l = &s->look[t];
            double first = bench_spread(l->first, r->repeat).median,
                   again = bench_spread(l->again, r->repeat).median;
            sum += first + again;
            printf("   %4llu bricks%7.1f%9.3f%9.3f", (unsigned long long)l->report.bricks_read,
                   1e-6 * (double)l->report.bytes_read, first, again);
        }
        printf("%10.3f\n", sum);
    }
    printf("first: with reading, uploading and compiling; frame: with all bricks there; sum: convert and all "
           "of both.\n");
}

int bench_bricks(int argc, char **argv)
{
    struct request r = {
        .in = fmt_source_defaults,
        .folder = ".",
        .quality = vr_quality_defaults,
        .renderer = vr_renderer_defaults,
        .view = {.size = {512, 512}, .orbit = {20, 10}},
        .repeat = 3,
    };
    static const char *const usual[] = {"ct-bone", "ct-skin", "gray"};
    bool has_size = false, has_type = false;
    int first = 0;
    r.quality.step_vox = 1.0;
    const struct tool_option options[] = {
        {"size", .value = "NXxNYxNZ", .parse = tool_parse_dims, .target = r.in.dims, .given = &has_size,
         .help = "raw: voxels on each axis"},
        {"type", .value = "TYPE", .parse = tool_parse_type, .target = &r.in.type, .given = &has_type,
         .help = "raw: u8 i8 u16 i16 u32 i32 f32 f64"},
        {"tf", .value = "NAME|FILE", .parse = tool_parse_list, .target = &r.tf,
         .help = "transfer functions, one each time (default ct-bone, ct-skin and gray)"},
        {"picture", .value = "WxH", .parse = tool_parse_picture, .target = r.view.size,
         .help = "pixels (default 512x512)"},
        {BENCH_STEP("1"), .target = &r.quality.step_vox},
        {"repeat", .value = "N", .parse = tool_parse_u32, .target = &r.repeat,
         .limits = {.min = 1, .max = REPEAT_MAX}, .help = "turns to take the median of (default 3)"},
        {"folder", .value = "DIR", .parse = tool_parse_text, .target = &r.folder,
         .help = "where the .brick files go, removed again (default .)"},
        {BENCH_GPU_CACHE, .target = &r.renderer.gpu_cache_bytes},
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "SRC [OPTIONS]",
        .summary =
            "What the brick's edge costs: conversion, bytes on disk, bytes read and seconds for pictures.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one SRC"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    if (has_size != has_type)
        return tool_misuse(COMMAND, "--size and --type go together");
    if (r.tf.count > LOOKS_MAX)
        return tool_misuse(COMMAND, "--tf may be given %d times", LOOKS_MAX);
    for (size_t t = 0; !r.tf.count && t < TOOL_COUNT(usual); t++)
        r.tf.item[t] = usual[t];
    if (!r.tf.count)
        r.tf.count = TOOL_COUNT(usual);
    r.source = argv[first];

    static struct result results[EDGES];
    struct brick_error err = {0};
    if (measure(&r, results, &err))
        return tool_fail(COMMAND, &err);
    print_text(&r, results);
    return 0;
}
