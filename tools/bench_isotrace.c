/* Why: the tables of Parker et al. 1998 again, on any volume: where a ray's time goes (table 1), what more
 * cores give (table 2), and what bricks, tiles and the hierarchy give (table 3). All variants make the same
 * picture, which is checked; they are measured in turns. */
#include <stdio.h>
#include <string.h>

#include <brick/threads.h>
#include <cjson/cJSON.h>

#include "bench_isotrace.h"
#include "bench_view.h"
#include "message.h"

#define COMMAND     "bench isotrace"
#define SAMPLES_MIN 1000

struct request {
    struct bench_view view;
    struct bench_isotrace bench;
    bool json;
};

static const struct {
    const char *name, *key;
    enum vr_iso_layout layout;
    bool skip;
} variants[BENCH_VARIANTS] = {
    {"initial: one array, cell by cell", "initial", VR_ISO_FLAT, false},
    {"bricks, cell by cell", "bricks", VR_ISO_BRICKS, false},
    {"tiled bricks, cell by cell", "tiled", VR_ISO_TILED, false},
    {"hierarchy and bricks", "hierarchy_bricks", VR_ISO_BRICKS, true},
    {"hierarchy and tiled bricks", "hierarchy_tiled", VR_ISO_TILED, true},
};

static int one_frame(struct vr_isotracer *tracer, const struct vr_scene *scene, bool skip,
                     struct vr_iso_profile *profile, struct brick_image *image, double *seconds,
                     struct brick_error *err)
{
    struct vr_isotrace_params params = vr_isotrace_defaults;
    struct vr_report report;
    params.skip = skip;
    params.profile = profile;
    int code = vr_render_isotrace(tracer, scene, &params, image, &report, err);
    *seconds = report.seconds_frame;
    return code;
}

/* On one thread, so that the one that looks on has a core of its own where there are two. */
static int measure_shares(struct bench_isotrace *r, const struct brick_volume *volume,
                          const struct vr_scene *scene, struct brick_image *image, struct brick_error *err)
{
    const struct vr_isotracer_params params = {.host_cache_bytes = r->host_cache_bytes, .threads = 1};
    struct vr_isotracer *tracer = NULL;
    const struct vr_iso_profile *p = &r->profile;
    double seconds;
    int code = vr_isotracer_create(&tracer, volume, &params, err);
    /* Short frames: more of them, for enough samples. */
    for (uint32_t i = 0;
         !code && (i <= r->frames ||
                   (i <= BENCH_REPEAT_MAX && p->traversal + p->intersection + p->shading < SAMPLES_MIN));
         i++)
        code = one_frame(tracer, scene, true, i ? &r->profile : NULL, image, &seconds, err);
    vr_isotracer_destroy(&tracer);
    return code;
}

static int measure_cores(struct bench_isotrace *r, const struct brick_volume *volume,
                         const struct vr_scene *scene, struct brick_image *image, struct brick_error *err)
{
    static double seconds[BENCH_CORES_MAX][BENCH_REPEAT_MAX];
    struct vr_isotracer *tracer[BENCH_CORES_MAX] = {NULL};
    double warm;
    int code = 0;
    r->cores = r->threads ? r->threads : brick_cores();
    if (r->cores > BENCH_CORES_MAX)
        r->cores = BENCH_CORES_MAX;
    for (unsigned n = 0; n < r->cores && !code; n++) {
        const struct vr_isotracer_params params = {.host_cache_bytes = r->host_cache_bytes, .threads = n + 1};
        code = vr_isotracer_create(&tracer[n], volume, &params, err);
        if (!code)
            code = one_frame(tracer[n], scene, true, NULL, image, &warm, err);
    }
    for (uint32_t i = 0; i < r->frames; i++)
        for (unsigned n = 0; n < r->cores && !code; n++)
            code = one_frame(tracer[n], scene, true, NULL, image, &seconds[n][i], err);
    for (unsigned n = 0; n < r->cores; n++) {
        if (!code)
            r->core_seconds[n] = bench_spread(seconds[n], r->frames).median;
        vr_isotracer_destroy(&tracer[n]);
    }
    return code;
}

static int measure_variants(struct bench_isotrace *r, const struct brick_volume *volume,
                            const struct vr_scene *scene, struct brick_image *image, struct brick_error *err)
{
    static double seconds[BENCH_VARIANTS][BENCH_REPEAT_MAX];
    struct vr_isotracer *tracer[BENCH_VARIANTS] = {NULL};
    struct brick_image other = {0};
    double warm;
    int code = brick_image_init(&other, scene->width, scene->height, err);
    for (int v = 0; v < BENCH_VARIANTS && !code; v++) {
        const struct vr_isotracer_params params = {
            .host_cache_bytes = r->host_cache_bytes, .threads = r->threads, .layout = variants[v].layout};
        code = vr_isotracer_create(&tracer[v], volume, &params, err);
        if (!code)
            code = one_frame(tracer[v], scene, variants[v].skip, NULL, v ? &other : image, &warm, err);
        if (!code && v &&
            memcmp(image->rgba, other.rgba, (size_t)image->width * image->height * 4 * sizeof(float)))
            code = brick_fail(err, BRICK_ERR_FORMAT, "%s: not the picture of %s", variants[v].name,
                              variants[0].name);
    }
    for (uint32_t i = 0; i < r->frames; i++)
        for (int v = 0; v < BENCH_VARIANTS && !code; v++)
            code = one_frame(tracer[v], scene, variants[v].skip, NULL, &other, &seconds[v][i], err);
    for (int v = 0; v < BENCH_VARIANTS; v++) {
        if (!code)
            r->seconds[v] = bench_spread(seconds[v], r->frames).median;
        vr_isotracer_destroy(&tracer[v]);
    }
    brick_image_finish(&other);
    return code;
}

double bench_isotrace_share(const struct vr_iso_profile *p, uint64_t part)
{
    uint64_t all = p->traversal + p->intersection + p->shading;
    return all ? 100.0 * (double)part / (double)all : 0.0;
}

int bench_isotrace_measure(struct bench_isotrace *r, const struct brick_volume *volume,
                           const struct vr_scene *scene, struct brick_error *err)
{
    struct brick_image image = {0};
    int code = brick_image_init(&image, scene->width, scene->height, err);
    if (!code)
        code = measure_variants(r, volume, scene, &image, err);
    if (!code)
        code = measure_cores(r, volume, scene, &image, err);
    if (!code)
        code = measure_shares(r, volume, scene, &image, err);
    brick_image_finish(&image);
    return code;
}

static void print_text(const struct request *r)
{
    const struct bench_isotrace *s = &r->bench;
    const struct vr_iso_profile *p = &s->profile;
    printf("%ux%u, iso %g, %u frames\n", r->view.size[0], r->view.size[1], r->view.iso, s->frames);
    printf("\n%-34s %9s\n", "share of a ray's time (table 1)", "%");
    printf("%-34s %9.1f\n", "traversal", bench_isotrace_share(p, p->traversal));
    printf("%-34s %9.1f\n", "intersection", bench_isotrace_share(p, p->intersection));
    printf("%-34s %9.1f\n", "shading", bench_isotrace_share(p, p->shading));
    printf("\n%-34s %9s %9s %9s\n", "cores (table 2)", "seconds", "frames/s", "speed-up");
    for (unsigned n = 0; n < s->cores; n++)
        printf("%-34u %9.4f %9.1f %9.2f\n", n + 1, s->core_seconds[n], 1.0 / s->core_seconds[n],
               s->core_seconds[0] / s->core_seconds[n]);
    printf("\n%-34s %9s %9s\n", "order of voxels (table 3)", "seconds", "initial/it");
    for (int v = 0; v < BENCH_VARIANTS; v++)
        printf("%-34s %9.4f %9.2f\n", variants[v].name, s->seconds[v],
               s->seconds[BENCH_FLAT] / s->seconds[v]);
}

static int print_json(const struct request *r)
{
    const struct bench_isotrace *s = &r->bench;
    const struct vr_iso_profile *p = &s->profile;
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "width", r->view.size[0]);
    cJSON_AddNumberToObject(json, "height", r->view.size[1]);
    cJSON_AddNumberToObject(json, "iso", r->view.iso);
    cJSON_AddNumberToObject(json, "frames", s->frames);
    cJSON *shares = cJSON_AddObjectToObject(json, "share_percent");
    cJSON_AddNumberToObject(shares, "traversal", bench_isotrace_share(p, p->traversal));
    cJSON_AddNumberToObject(shares, "intersection", bench_isotrace_share(p, p->intersection));
    cJSON_AddNumberToObject(shares, "shading", bench_isotrace_share(p, p->shading));
    cJSON_AddItemToObject(json, "seconds_cores", cJSON_CreateDoubleArray(s->core_seconds, (int)s->cores));
    cJSON *seconds = cJSON_AddObjectToObject(json, "seconds");
    for (int v = 0; v < BENCH_VARIANTS; v++)
        cJSON_AddNumberToObject(seconds, variants[v].key, s->seconds[v]);
    return tool_json_print(COMMAND, json);
}

int bench_isotrace(int argc, char **argv)
{
    struct request r = {.view = {.size = {512, 512}},
                        .bench = {.frames = 5, .host_cache_bytes = vr_isotracer_defaults.host_cache_bytes}};
    int first = 0;
    const struct tool_option options[] = {
        {BENCH_ISO(r.view)},
        {BENCH_FRAMES("5"), .target = &r.bench.frames},
        {BENCH_SIZE(r.view, "512x512")},
        {BENCH_CAMERA(r.view, "0,0")},
        {"host-cache", .value = "SIZE", .parse = tool_parse_bytes, .target = &r.bench.host_cache_bytes,
         .help =
             "bytes of decoded bricks in memory; the orders other\nthan the file's need room for the volume"},
        TOOL_OPTION_THREADS(&r.bench.threads),
        TOOL_OPTION_JSON(&r.json),
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "FILE [OPTIONS]",
        .summary = "Isosurfaces by ray tracing on the CPU: the tables of Parker et al. 1998 again.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;

    struct vr_scene scene;
    struct brick_volume *volume = NULL;
    struct brick_error err = {0};
    code = brick_volume_open(&volume, argv[first], &err);
    if (!code) {
        bench_view_scene(&r.view, volume, &scene);
        scene.mode = BRICK_MODE_ISO;
        r.view.iso = scene.isovalue;
        code = bench_isotrace_measure(&r.bench, volume, &scene, &err);
    }
    brick_volume_close(&volume);
    if (code)
        return tool_fail(COMMAND, &err);
    if (r.json)
        return print_json(&r);
    print_text(&r);
    return 0;
}
