/* Why: what each feature costs when it is on. Variants of one picture take turns, so that a slow minute of
 * the machine falls on all of them, and each is a ratio to the plain picture of its own turn; of processor
 * time, which other work on the machine disturbs less. Features that keep the bytes are checked to. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cjson/cJSON.h>

#include "bench_view.h"
#include "message.h"
#include "transfer.h"

#define COMMAND "bench features"

struct request {
    const char *tf;
    uint32_t frames;
    double step;
    struct bench_view view;
    struct vr_renderer_params renderer;
    bool json;
};

/* Sixteen variants of a mode at most. */
#define ROWS_MAX 16
struct row {
    const char *name;
    struct vr_quality quality;
    bool same; /* the plain picture's bytes */
    struct vr_report report;
    double last, ratio[BENCH_REPEAT_MAX], processor[BENCH_REPEAT_MAX]; /* seconds of processors */
};

static struct vr_quality *add(struct row *rows, size_t *n, const struct request *request, const char *name,
                              bool same)
{
    struct row *row = &rows[(*n)++];
    *row = (struct row){.name = name, .quality = vr_quality_defaults, .same = same};
    row->quality.step_vox = request->step;
    return &row->quality;
}

static size_t list_rows(const struct request *request, enum brick_mode mode, struct row rows[ROWS_MAX])
{
    static const uint32_t pass_steps[] = {8, 16, 32, 64, 128, 256};
    static const char *const names[] = {"multipass, 8 steps a pass",
                                        "multipass, 16",
                                        "multipass, 32",
                                        "multipass, 64",
                                        "multipass, 128",
                                        "multipass, 256"};
    size_t n = 0;
    struct vr_quality *q;
    add(rows, &n, request, "raycast", true);
    add(rows, &n, request, "raycast once more", true);
    add(rows, &n, request, "no skipping", true)->skip = false;
    add(rows, &n, request, "bounding geometry", true)->setup = VR_SETUP_GEOMETRY;
    q = add(rows, &n, request, "bounding geometry, no skipping", true);
    q->setup = VR_SETUP_GEOMETRY;
    q->skip = false;
    add(rows, &n, request, "interleaved offsets", false)->interleaved = true;
    if (mode == BRICK_MODE_ISO) {
        add(rows, &n, request, "6 bisections", false)->refinements = 6;
        add(rows, &n, request, "cubic refinement", false)->cubic = true;
    }
    for (size_t i = 0; i < TOOL_COUNT(pass_steps); i++) {
        q = add(rows, &n, request, names[i], true);
        q->method = VR_METHOD_MULTIPASS;
        q->pass_steps = pass_steps[i];
    }
    return n;
}

static int measure(struct vr_renderer *renderer, const struct vr_scene *scene, uint32_t frames,
                   struct row *rows, size_t count, struct brick_error *err)
{
    const size_t bytes = (size_t)scene->width * scene->height * 4 * sizeof(float);
    struct brick_image plain = {0}, image = {0};
    int code = brick_image_init(&plain, scene->width, scene->height, err);
    if (!code)
        code = brick_image_init(&image, scene->width, scene->height, err);
    for (uint32_t turn = 0; turn <= frames && !code; turn++) /* the first loads bricks and compiles */
        for (size_t i = 0; i < count && !code; i++) {
            struct row *row = &rows[i];
            const clock_t start = clock();
            code = vr_render(renderer, scene, &row->quality, i ? &image : &plain, &row->report, err);
            row->last = (double)(clock() - start) / CLOCKS_PER_SEC;
            if (!code && i && row->same && memcmp(plain.rgba, image.rgba, bytes))
                code = brick_fail(err, BRICK_ERR_INEXACT, "%s: not the plain picture's bytes", row->name);
            if (turn) {
                row->processor[turn - 1] = row->last;
                row->ratio[turn - 1] = row->last / rows[0].last;
            }
        }
    brick_image_finish(&plain);
    brick_image_finish(&image);
    return code;
}

static void print(const struct request *request, const char *mode, struct row *rows, size_t count,
                  cJSON *json)
{
    cJSON *list = json ? cJSON_AddArrayToObject(json, mode) : NULL;
    for (size_t i = 0; i < count; i++) {
        struct row *r = &rows[i];
        double ratio = bench_spread(r->ratio, request->frames).median;
        double seconds = bench_spread(r->processor, request->frames).median;
        if (!json) {
            printf("%-7s %-31s %8.4f %7.2f %7llu %12llu\n", i ? "" : mode, r->name, seconds, ratio,
                   (unsigned long long)r->report.passes, (unsigned long long)r->report.samples);
            continue;
        }
        cJSON *object = cJSON_CreateObject();
        cJSON_AddStringToObject(object, "name", r->name);
        cJSON_AddNumberToObject(object, "processor_seconds", seconds);
        cJSON_AddNumberToObject(object, "ratio", ratio);
        cJSON_AddNumberToObject(object, "passes", (double)r->report.passes);
        cJSON_AddNumberToObject(object, "samples", (double)r->report.samples);
        cJSON_AddItemToArray(list, object);
    }
}

static int run(const struct request *request, const struct brick_volume *volume, cJSON *json,
               struct brick_error *err)
{
    static const char *const modes[] = {"dvr", "shaded", "iso"};
    struct vr_scene scene;
    struct brick_transfer *transfer = NULL;
    struct vr_renderer *renderer = NULL;
    struct row *rows = calloc(ROWS_MAX, sizeof *rows);
    bench_view_scene(&request->view, volume, &scene);
    int code = rows ? tool_transfer_load(&transfer, request->tf, volume, err)
                    : brick_fail(err, BRICK_ERR_MEMORY, "no memory for the table");
    if (!code)
        code = vr_renderer_create(&renderer, volume, &request->renderer, err);
    if (!code && !json)
        printf("%-7s %-31s %8s %7s %7s %12s\n", "mode", "", "proc. s", "ratio", "passes", "samples");
    for (size_t m = 0; m < TOOL_COUNT(modes) && !code; m++) {
        scene.mode = (enum brick_mode)m;
        scene.transfer = scene.mode == BRICK_MODE_ISO ? NULL : transfer;
        size_t count = list_rows(request, scene.mode, rows);
        if (!(code = measure(renderer, &scene, request->frames, rows, count, err)))
            print(request, modes[m], rows, count, json);
    }
    vr_renderer_destroy(&renderer);
    brick_transfer_destroy(&transfer);
    free(rows);
    return code;
}

int bench_features(int argc, char **argv)
{
    struct request r = {
        .view = {.size = {512, 512}}, .frames = 7, .step = 0.5, .renderer = vr_renderer_defaults};
    int first = 0;
    const struct tool_option options[] = {
        {"frames", .value = "N", .parse = tool_parse_u32, .target = &r.frames,
         .limits = {.min = 1, .max = BENCH_REPEAT_MAX}, .help = "turns to take the median of (default 7)"},
        {BENCH_TF, .target = &r.tf},
        {BENCH_ISO(r.view)},
        {BENCH_SIZE(r.view, "512x512")},
        {BENCH_STEP("0.5"), .target = &r.step},
        {BENCH_CAMERA(r.view, "0,0")},
        {BENCH_GPU_CACHE, .target = &r.renderer.gpu_cache_bytes},
        TOOL_OPTION_THREADS(&r.renderer.threads),
        TOOL_OPTION_JSON(&r.json),
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "FILE [OPTIONS]",
        .summary = "What features of the raycaster cost, and multipass: processor seconds a frame, and\n"
                   "ratios to the plain picture, in turns.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    struct brick_volume *volume = NULL;
    struct brick_error err = {0};
    cJSON *json = r.json ? cJSON_CreateObject() : NULL;
    code = brick_volume_open(&volume, argv[first], &err);
    if (!code)
        code = run(&r, volume, json, &err);
    brick_volume_close(&volume);
    if (code) {
        cJSON_Delete(json);
        return tool_fail(COMMAND, &err);
    }
    return json ? tool_json_print(COMMAND, json) : 0;
}
