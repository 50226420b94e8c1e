/* Why: how far isosurface hits are from where the surface is. Rays of the raycaster, at several steps and
 * with each refinement, are held against the exact first crossing of the same ray. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <cjson/cJSON.h>

#include "bench_view.h"
#include "message.h"

#define COMMAND "bench hits"

struct request {
    struct bench_view view;
    struct tool_reals steps;
    struct vr_renderer_params renderer;
    bool json;
};

static const struct {
    const char *name;
    uint32_t bisections;
    bool cubic;
} ways[] = {{"none", 0, false}, {"6 bisections", 6, false}, {"8 bisections", 8, false}, {"cubic", 0, true}};
#define WAYS (sizeof ways / sizeof *ways)

struct row {
    double step;
    size_t way;
    uint64_t hits, missed, invented;
    double rms, most; /* voxels, of hits of the same crossing */
};

/* Of the crossing between two samples a hit is at most this far, in voxels; one that is farther is of another
 * crossing, and the first was missed. A cubic is right to far less. */
static double farthest_vox(const struct row *row)
{
    return ways[row->way].cubic ? 1e-3 : row->step * exp2(-(double)ways[row->way].bisections) + 1e-5;
}

static void hold_against(const double *exact, const struct brick_image *image, double voxel_mm,
                         struct row *row)
{
    double sum = 0.0;
    uint64_t same = 0;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++) {
        const float *p = image->rgba + 4 * i;
        bool here = p[3] > 0.0f, there = isfinite(exact[i]);
        double error = here && there ? fabs((double)p[0] + (double)p[1] - exact[i]) / voxel_mm : 0.0;
        row->hits += there;
        row->invented += here && !there;
        if (there && (!here || error > farthest_vox(row))) {
            row->missed++;
        } else if (there) {
            sum += error * error;
            row->most = fmax(row->most, error);
            same++;
        }
    }
    row->rms = same ? sqrt(sum / (double)same) : 0.0;
}

static int measure(const struct request *request, const struct brick_volume *volume, struct row *rows,
                   struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    struct vr_scene scene;
    struct vr_exact_params exact = vr_exact_defaults;
    struct vr_quality quality = vr_quality_defaults;
    struct vr_renderer *renderer = NULL;
    struct brick_image image = {0};
    size_t n = 0;
    bench_view_scene(&request->view, volume, &scene);
    scene.mode = BRICK_MODE_ISO;
    quality.distances = true;
    exact.threads = request->renderer.threads;
    exact.host_cache_bytes = request->renderer.host_cache_bytes;
    exact.hit_mm = malloc((size_t)scene.width * scene.height * sizeof *exact.hit_mm);
    int code = exact.hit_mm ? brick_image_init(&image, scene.width, scene.height, err)
                            : brick_fail(err, BRICK_ERR_MEMORY, "no memory for %u x %u hits", scene.width,
                                         scene.height);
    if (!code)
        code = vr_render_exact(volume, &scene, &exact, &image, NULL, err);
    if (!code)
        code = vr_renderer_create(&renderer, volume, &request->renderer, err);
    for (size_t s = 0; s < request->steps.count && !code; s++)
        for (size_t w = 0; w < WAYS && !code; w++) {
            struct row *row = &rows[n++];
            *row = (struct row){.step = request->steps.value[s], .way = w};
            quality.step_vox = row->step;
            quality.refinements = ways[w].bisections;
            quality.cubic = ways[w].cubic;
            if (!(code = vr_render(renderer, &scene, &quality, &image, NULL, err)))
                hold_against(exact.hit_mm, &image, brick_grid_min_spacing_mm(grid), row);
        }
    vr_renderer_destroy(&renderer);
    brick_image_finish(&image);
    free(exact.hit_mm);
    return code;
}

static int print(const struct row *rows, size_t count, bool as_json)
{
    cJSON *json = as_json ? cJSON_CreateObject() : NULL, *list = cJSON_AddArrayToObject(json, "rows");
    if (!as_json)
        printf("%-6s %-14s %9s %8s %9s %12s %12s\n", "step", "refinement", "hits", "missed", "invented",
               "rms vox", "most vox");
    for (size_t i = 0; i < count; i++) {
        const struct row *r = &rows[i];
        if (!as_json) {
            printf("%-6g %-14s %9llu %8llu %9llu %12.3g %12.3g\n", r->step, ways[r->way].name,
                   (unsigned long long)r->hits, (unsigned long long)r->missed,
                   (unsigned long long)r->invented, r->rms, r->most);
            continue;
        }
        cJSON *object = cJSON_CreateObject();
        cJSON_AddNumberToObject(object, "step", r->step);
        cJSON_AddStringToObject(object, "refinement", ways[r->way].name);
        cJSON_AddNumberToObject(object, "hits", (double)r->hits);
        cJSON_AddNumberToObject(object, "missed", (double)r->missed);
        cJSON_AddNumberToObject(object, "invented", (double)r->invented);
        cJSON_AddNumberToObject(object, "rms_vox", r->rms);
        cJSON_AddNumberToObject(object, "most_vox", r->most);
        cJSON_AddItemToArray(list, object);
    }
    return as_json ? tool_json_print(COMMAND, json) : 0;
}

int bench_hits(int argc, char **argv)
{
    struct request r = {
        .view = {.size = {256, 256}},
        .steps = {.value = {0.5, 1.0, 2.0, 5.0}, .count = 4},
        .renderer = vr_renderer_defaults,
    };
    int first = 0;
    const struct tool_option options[] = {
        {BENCH_ISO(r.view)},
        {"steps", .value = "S[,S...]", .parse = tool_parse_reals, .target = &r.steps,
         .limits = {.min = 0.001, .max = 1000},
         .help = "sampling distances in smallest voxel edges (default\n0.5,1,2,5)"},
        {BENCH_SIZE(r.view, "256x256")},
        {BENCH_CAMERA(r.view, "0,0")},
        TOOL_OPTION_THREADS(&r.renderer.threads),
        TOOL_OPTION_JSON(&r.json),
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "FILE [OPTIONS]",
        .summary = "Isosurface hits of the raycaster against exact ones, by step and refinement.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;

    struct row rows[TOOL_REALS_MAX * WAYS];
    struct brick_volume *volume = NULL;
    struct brick_error err = {0};
    code = brick_volume_open(&volume, argv[first], &err);
    if (!code)
        code = measure(&r, volume, rows, &err);
    brick_volume_close(&volume);
    return code ? tool_fail(COMMAND, &err) : print(rows, r.steps.count * WAYS, r.json);
}
