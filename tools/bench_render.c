/* Why: seconds per frame of every mode, and of isosurfaces traced on the CPU, one after the other in one
 * process on one renderer. The first frame of a mode loads bricks and compiles shaders; it is shown apart
 * from the median of the frames after it. Processor seconds, of all threads, tell more than the clock where
 * other programs run. */
#include <float.h>
#include <math.h>
#include <stdio.h>

#include <brick/threads.h>
#include <cjson/cJSON.h>

#include "bench_view.h"
#include "message.h"
#include "transfer.h"

#define COMMAND "bench render"
#define MODES   4
#define ROWS    (MODES + 1) /* and isotrace, on the CPU */

struct request {
    const char *tf;
    uint32_t frames;
    struct bench_view view;
    struct vr_quality quality;
    struct vr_renderer_params renderer;
    int context, filter;
    bool json;
};

struct result {
    double first;
    struct bench_spread frame;
    double core; /* processor seconds of a frame, the least of all */
    struct vr_report report;
};

static const char *const row_names[ROWS] = {"dvr", "shaded", "iso", "mip", "isotrace"};
static const char *const contexts[] = {"auto", "egl", "osmesa", "cpu", NULL};
static const char *const filters[] = {"exact", "fast", NULL};

/* One frame, by whichever of the two is not NULL. */
static int frame_of(struct vr_renderer *renderer, struct vr_isotracer *tracer, const struct vr_scene *scene,
                    const struct vr_quality *quality, struct brick_image *image, struct vr_report *report,
                    struct brick_error *err)
{
    return renderer ? vr_render(renderer, scene, quality, image, report, err)
                    : vr_render_isotrace(tracer, scene, &vr_isotrace_defaults, image, report, err);
}

static int measure(struct vr_renderer *renderer, struct vr_isotracer *tracer, const struct vr_scene *scene,
                   const struct vr_quality *quality, uint32_t frames, struct result *result,
                   struct brick_error *err)
{
    struct brick_image image = {0};
    double seconds[BENCH_REPEAT_MAX];
    result->core = DBL_MAX;
    int code = brick_image_init(&image, scene->width, scene->height, err);
    for (uint32_t i = 0; i <= frames && !code; i++) {
        const uint64_t core = brick_process_ns();
        code = frame_of(renderer, tracer, scene, quality, &image, &result->report, err);
        if (i)
            result->core = fmin(result->core, (double)(brick_process_ns() - core) * 1e-9);
        if (i)
            seconds[i - 1] = result->report.seconds_frame;
        else
            result->first = result->report.seconds_frame;
    }
    brick_image_finish(&image);
    if (!code)
        result->frame = bench_spread(seconds, frames);
    return code;
}

static int measure_all(const struct request *request, const struct brick_volume *volume,
                       struct result results[ROWS], struct brick_error *err)
{
    struct vr_scene scene;
    struct brick_transfer *transfer = NULL;
    struct vr_renderer *renderer = NULL;
    struct vr_isotracer *tracer = NULL;
    const struct vr_isotracer_params cpu = {.host_cache_bytes = request->renderer.host_cache_bytes,
                                            .threads = request->renderer.threads};

    bench_view_scene(&request->view, volume, &scene);
    int code = tool_transfer_load(&transfer, request->tf, volume, err);
    if (!code)
        code = vr_renderer_create(&renderer, volume, &request->renderer, err);
    for (int mode = 0; mode < MODES && !code; mode++) {
        scene.mode = (enum brick_mode)mode;
        scene.transfer = mode == BRICK_MODE_ISO && !request->tf ? NULL : transfer;
        if (mode == BRICK_MODE_ISO && request->renderer.context == VR_CONTEXT_CPU)
            continue; /* there isotrace draws it */
        code = measure(renderer, NULL, &scene, &request->quality, request->frames, &results[mode], err);
    }
    vr_renderer_destroy(&renderer);
    scene.mode = BRICK_MODE_ISO;
    scene.transfer = request->tf ? transfer : NULL;
    if (!code)
        code = vr_isotracer_create(&tracer, volume, &cpu, err);
    if (!code)
        code = measure(NULL, tracer, &scene, &request->quality, request->frames, &results[MODES], err);
    vr_isotracer_destroy(&tracer);
    brick_transfer_destroy(&transfer);
    return code;
}

static void print_text(const struct request *request, const struct result results[ROWS])
{
    printf("%ux%u, step %g, %u frames, %s\n", request->view.size[0], request->view.size[1],
           request->quality.step_vox, request->frames,
           *results[0].report.gl_renderer ? results[0].report.gl_renderer : "no OpenGL");
    printf("%-8s %10s %10s %10s %10s %10s %14s %16s\n", "mode", "median s", "min s", "max s", "core s",
           "first s", "bricks", "samples");
    for (int row = 0; row < ROWS; row++) {
        const struct result *r = &results[row];
        if (!r->report.passes)
            continue;
        printf("%-8s %10.4f %10.4f %10.4f %10.4f %10.4f %6llu/%-7llu %16llu\n", row_names[row],
               r->frame.median, r->frame.min, r->frame.max, r->core, r->first,
               (unsigned long long)r->report.bricks_active, (unsigned long long)r->report.bricks_total,
               (unsigned long long)r->report.samples);
    }
}

static int print_json(const struct request *request, const struct result results[ROWS])
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "width", request->view.size[0]);
    cJSON_AddNumberToObject(json, "height", request->view.size[1]);
    cJSON_AddNumberToObject(json, "step", request->quality.step_vox);
    cJSON_AddNumberToObject(json, "frames", request->frames);
    cJSON_AddStringToObject(json, "gl_renderer", results[0].report.gl_renderer);
    for (int row = 0; row < ROWS; row++) {
        if (!results[row].report.passes)
            continue;
        cJSON *object = cJSON_AddObjectToObject(json, row_names[row]);
        cJSON_AddNumberToObject(object, "seconds_frame", results[row].frame.median);
        cJSON_AddNumberToObject(object, "seconds_min", results[row].frame.min);
        cJSON_AddNumberToObject(object, "seconds_max", results[row].frame.max);
        cJSON_AddNumberToObject(object, "core_seconds", results[row].core);
        cJSON_AddNumberToObject(object, "seconds_first", results[row].first);
        cJSON_AddNumberToObject(object, "bricks_active", (double)results[row].report.bricks_active);
        cJSON_AddNumberToObject(object, "samples", (double)results[row].report.samples);
    }
    return tool_json_print(COMMAND, json);
}

int bench_render(int argc, char **argv)
{
    struct request r = {
        .view = {.size = {512, 512}},
        .frames = 5,
        .quality = vr_quality_defaults,
        .renderer = vr_renderer_defaults,
    };
    int first = 0;
    const struct tool_option options[] = {
        {BENCH_FRAMES("5"), .target = &r.frames},
        {BENCH_TF, .target = &r.tf},
        {BENCH_ISO(r.view)},
        {BENCH_SIZE(r.view, "512x512")},
        {BENCH_STEP("0.5"), .target = &r.quality.step_vox},
        {BENCH_CAMERA(r.view, "0,0")},
        {BENCH_GPU_CACHE, .target = &r.renderer.gpu_cache_bytes},
        {"host-cache", .value = "SIZE", .parse = tool_parse_bytes, .target = &r.renderer.host_cache_bytes,
         .help = "bytes of decoded bricks in memory"},
        {"context", .value = "KIND", .parse = tool_parse_choice, .target = &r.context,
         .limits = {.choices = contexts},
         .help = "auto (default): OpenGL; egl, osmesa, or cpu: without OpenGL"},
        {"filter", .value = "FILTER", .parse = tool_parse_choice, .target = &r.filter,
         .limits = {.choices = filters}, .help = "exact (default) or fast"},
        TOOL_OPTION_THREADS(&r.renderer.threads),
        TOOL_OPTION_JSON(&r.json),
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "FILE [OPTIONS]",
        .summary = "Seconds per frame in the modes dvr, shaded, iso and mip, and of --method isotrace.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    r.renderer.context = (enum vr_context_kind)r.context;
    r.renderer.filter = (enum vr_filter)r.filter;

    struct result results[ROWS] = {0};
    struct brick_volume *volume = NULL;
    struct brick_error err = {0};
    code = brick_volume_open(&volume, argv[first], &err);
    if (!code)
        code = measure_all(&r, volume, results, &err);
    brick_volume_close(&volume);
    if (code)
        return tool_fail(COMMAND, &err);
    if (r.json)
        return print_json(&r, results);
    print_text(&r, results);
    return 0;
}
