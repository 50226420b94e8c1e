/* Why: the ways in which VTK draws a volume are what people use today. Here they draw the same frames as this
 * program does, in turns, in one run, read back; and each picture is held against the exact one. Colour only,
 * over black: VTK's pictures have 8 bits. Frame 0 loads, compiles and is compared; the others, each from
 * another side, are timed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cjson/cJSON.h>
#include <formats/formats.h>

#include "bench_view.h"
#include "figure.h"
#include "message.h"
#include "peers/peer.h"
#include "peers/peer_scene.h"
#include "scripts.h"
#include "transfer.h"

#define COMMAND "bench peers"

enum { FRAMES_MAX = 100 };

static const struct way {
    const char *name;
    enum brick_mode mode;
    const char *peer; /* VTK's way; NULL: this program's */
    bool traced;      /* isotrace */
    bool cpu;         /* without OpenGL */
    bool ends;        /* rays where VTK's GPU mapper ends them: less than 1/255 is left */
} ways[] = {
    {.name = "raycast", .mode = BRICK_MODE_DVR},
    {.name = "raycast, ends as VTK's", .mode = BRICK_MODE_DVR, .ends = true},
    {.name = "raycast, no OpenGL", .mode = BRICK_MODE_DVR, .cpu = true},
    {.name = "no OpenGL, ends as VTK's", .mode = BRICK_MODE_DVR, .cpu = true, .ends = true},
    {.name = "VTK GPU mapper", .mode = BRICK_MODE_DVR, .peer = "gpu"},
    {.name = "VTK fixed-point mapper", .mode = BRICK_MODE_DVR, .peer = "fixed-point"},
    {.name = "raycast", .mode = BRICK_MODE_SHADED},
    {.name = "raycast, ends as VTK's", .mode = BRICK_MODE_SHADED, .ends = true},
    {.name = "raycast, no OpenGL", .mode = BRICK_MODE_SHADED, .cpu = true},
    {.name = "no OpenGL, ends as VTK's", .mode = BRICK_MODE_SHADED, .cpu = true, .ends = true},
    {.name = "VTK GPU mapper", .mode = BRICK_MODE_SHADED, .peer = "gpu"},
    {.name = "VTK fixed-point mapper", .mode = BRICK_MODE_SHADED, .peer = "fixed-point"},
    {.name = "raycast", .mode = BRICK_MODE_ISO},
    {.name = "isotrace", .mode = BRICK_MODE_ISO, .traced = true},
    {.name = "VTK GPU mapper", .mode = BRICK_MODE_ISO, .peer = "gpu"},
    {.name = "VTK fixed-point mapper", .mode = BRICK_MODE_ISO, .peer = "fixed-point"},
    {.name = "VTK flying edges, mesh", .mode = BRICK_MODE_ISO, .peer = "flying-edges"},
    {.name = "VTK marching cubes, mesh", .mode = BRICK_MODE_ISO, .peer = "marching-cubes"},
};
enum { WAYS = TOOL_COUNT(ways), MODES = BRICK_MODE_ISO + 1 };
static const char *const mode_names[MODES] = {"dvr", "shaded", "iso"};

struct request {
    const char *tf, *folder, *python;
    uint32_t frames;
    struct bench_view view;
    struct vr_quality quality;
    struct vr_renderer_params renderer;
};

struct result {
    double seconds[FRAMES_MAX], extraction[FRAMES_MAX], first;
    struct bench_spread frame, extract;
    double rmse, max_abs;
};

struct bench {
    const struct request *request;
    const struct brick_volume *volume;
    struct vr_scene scene;
    struct brick_camera cameras[FRAMES_MAX + 1];
    struct vr_renderer *renderer, *processor;
    struct vr_isotracer *tracer;
    struct peer peer;
    struct brick_image exact[MODES], image;
    char picture[4096], raw[4096]; /* files of VTK's, absolute */
    struct result results[WAYS];
};

static int ask_peer(struct bench *b, const struct way *way, uint32_t frame, struct result *r, double *seconds,
                    struct brick_error *err)
{
    cJSON *answer, *question = cJSON_CreateObject();
    cJSON_AddStringToObject(question, "way", way->peer);
    cJSON_AddStringToObject(question, "mode", mode_names[way->mode]);
    cJSON_AddNumberToObject(question, "frame", frame);
    if (frame)
        cJSON_AddNullToObject(question, "picture");
    else
        cJSON_AddStringToObject(question, "picture", b->picture);
    int code = peer_ask(&b->peer, question, &answer, err);
    if (code)
        return code;
    const cJSON *drawing = cJSON_GetObjectItem(answer, "seconds"),
                *extraction = cJSON_GetObjectItem(answer, "extraction");
    if (cJSON_IsNumber(drawing) && cJSON_IsNumber(extraction)) {
        *seconds = drawing->valuedouble + extraction->valuedouble;
        if (frame)
            r->extraction[frame - 1] = extraction->valuedouble;
    } else {
        code = brick_fail(err, BRICK_ERR_FORMAT, "VTK's answer has no times");
    }
    cJSON_Delete(answer);
    return code;
}

static int read_picture(struct bench *b, struct brick_error *err)
{
    const size_t pixels = (size_t)b->image.width * b->image.height;
    FILE *file = fopen(b->picture, "rb");
    bool good = file;
    for (size_t i = 0; i < pixels && good; i++) {
        good = fread(b->image.rgba + 4 * i, sizeof(float), 3, file) == 3;
        b->image.rgba[4 * i + 3] = 1.0f;
    }
    if (file)
        fclose(file);
    remove(b->picture);
    return good ? BRICK_OK
                : brick_fail(err, BRICK_ERR_IO, "%s: not the picture that VTK should have left", b->picture);
}

static void hold_against(const struct brick_image *image, const struct brick_image *exact, struct result *r)
{
    const size_t n = (size_t)image->width * image->height;
    double sum = 0.0;
    for (size_t i = 0; i < 4 * n; i++)
        if (i % 4 < 3) {
            double d = fabs((double)image->rgba[i] - (double)exact->rgba[i]);
            sum += d * d;
            r->max_abs = fmax(r->max_abs, d);
        }
    r->rmse = sqrt(sum / (3.0 * (double)n));
}

static int keep_picture(struct bench *b, const struct way *way, const char *name, struct brick_error *err)
{
    char path[4096];
    struct fmt_image_params params = fmt_image_defaults;
    int n = snprintf(path, sizeof path, "%s/%s, %s.png", b->request->folder, mode_names[way->mode], name);
    return n < (int)sizeof path ? fmt_image_write(path, &b->image, &params, err)
                                : brick_fail(err, BRICK_ERR_ARGUMENT, "the folder's name is too long");
}

static int one_frame(struct bench *b, int w, uint32_t frame, struct brick_error *err)
{
    const struct way *way = &ways[w];
    struct result *r = &b->results[w];
    struct vr_scene scene = b->scene;
    struct vr_quality quality = b->request->quality;
    struct vr_report report;
    double seconds = 0.0;
    int code;
    if (way->ends)
        quality.termination = 1.0 / 255.0;
    scene.mode = way->mode;
    scene.camera = b->cameras[frame];
    if (scene.mode == BRICK_MODE_ISO)
        scene.transfer = NULL;
    if (way->peer)
        code = ask_peer(b, way, frame, r, &seconds, err);
    else if (way->traced)
        code = vr_render_isotrace(b->tracer, &scene, &vr_isotrace_defaults, &b->image, &report, err);
    else
        code = vr_render(way->cpu ? b->processor : b->renderer, &scene, &quality, &b->image, &report, err);
    if (code)
        return code;
    if (!way->peer)
        seconds = report.seconds_frame;
    if (frame) {
        r->seconds[frame - 1] = seconds;
        return 0;
    }
    r->first = seconds;
    if (way->peer && (code = read_picture(b, err)))
        return code;
    hold_against(&b->image, &b->exact[way->mode], r);
    return keep_picture(b, way, way->name, err);
}

static int draw_exact(struct bench *b, struct brick_error *err)
{
    int code = 0;
    for (int mode = 0; mode < MODES && !code; mode++) {
        struct vr_scene scene = b->scene;
        struct vr_exact_params params = vr_exact_defaults;
        scene.mode = (enum brick_mode)mode;
        scene.camera = b->cameras[0];
        if (scene.mode == BRICK_MODE_ISO)
            scene.transfer = NULL;
        params.host_cache_bytes = b->request->renderer.host_cache_bytes;
        params.threads = b->request->renderer.threads;
        if (!(code = brick_image_init(&b->exact[mode], scene.width, scene.height, err)))
            code = vr_render_exact(b->volume, &scene, &params, &b->exact[mode], NULL, err);
    }
    return code;
}

static int start_peer(struct bench *b, struct brick_error *err)
{
    double spacing[3], origin[3];
    const double step_mm =
        b->request->quality.step_vox * brick_grid_min_spacing_mm(brick_volume_grid(b->volume));
    char *folder = realpath(b->request->folder, NULL);
    cJSON *answer = NULL;
    int n = folder ? snprintf(b->raw, sizeof b->raw, "%s/volume.raw", folder) : -1;
    n = n < 0 ? n : snprintf(b->picture, sizeof b->picture, "%s/picture.raw", folder);
    free(folder);
    if (n < 0 || n >= (int)sizeof b->raw)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: cannot find this folder again", b->request->folder);
    int code = peer_scene_write_volume(b->volume, b->raw, spacing, origin, err);
    if (!code)
        code = peer_start(&b->peer, b->request->python, tool_script_vtk_peer, err);
    if (!code)
        code = peer_ask(&b->peer,
                        peer_scene_json(b->volume, &b->scene, step_mm, b->raw, spacing, origin, b->cameras,
                                        b->request->frames + 1),
                        &answer, err);
    const cJSON *version = cJSON_GetObjectItem(answer, "version");
    if (!code)
        printf("VTK %s\n", cJSON_IsString(version) ? version->valuestring : "?");
    cJSON_Delete(answer);
    return code;
}

static int measure(struct bench *b, struct brick_error *err)
{
    const struct vr_isotracer_params cpu = {.host_cache_bytes = b->request->renderer.host_cache_bytes,
                                            .threads = b->request->renderer.threads};
    struct vr_renderer_params without = b->request->renderer;
    without.context = VR_CONTEXT_CPU;
    int code = draw_exact(b, err);
    if (!code)
        code = brick_image_init(&b->image, b->scene.width, b->scene.height, err);
    if (!code)
        code = vr_renderer_create(&b->renderer, b->volume, &b->request->renderer, err);
    if (!code)
        code = vr_renderer_create(&b->processor, b->volume, &without, err);
    if (!code)
        code = vr_isotracer_create(&b->tracer, b->volume, &cpu, err);
    if (!code)
        code = start_peer(b, err);
    for (uint32_t frame = 0; frame <= b->request->frames && !code; frame++)
        for (int w = 0; w < WAYS && !code; w++)
            code = one_frame(b, w, frame, err);
    for (int w = 0; w < WAYS && !code; w++) {
        b->results[w].frame = bench_spread(b->results[w].seconds, b->request->frames);
        b->results[w].extract = bench_spread(b->results[w].extraction, b->request->frames);
    }
    return code;
}

static void print_rows(const struct bench *b, FILE *file, bool csv)
{
    double ours = 0.0;
    if (csv)
        fputs("mode,way,seconds,seconds_min,seconds_max,first,extraction,ratio_to_raycast,max_abs,rmse\n",
              file);
    else
        fprintf(file, "%-8s%-26s%9s%9s%9s%9s%11s%8s%10s%10s\n", "mode", "", "seconds", "min", "max", "first",
                "extraction", "ratio", "max_abs", "rmse");
    for (int w = 0; w < WAYS; w++) {
        const struct result *r = &b->results[w];
        if (!w || ways[w].mode != ways[w - 1].mode)
            ours = r->frame.median;
        fprintf(file,
                csv ? "%s,\"%s\",%.6g,%.6g,%.6g,%.6g,%.6g,%.4g,%.6g,%.6g\n"
                    : "%-8s%-26s%9.4f%9.4f%9.4f%9.4f%11.4f%8.2f%10.3g%10.3g\n",
                mode_names[ways[w].mode], ways[w].name, r->frame.median, r->frame.min, r->frame.max, r->first,
                r->extract.median, r->frame.median / ours, r->max_abs, r->rmse);
    }
}

static int write_csv(const struct bench *b, struct brick_error *err)
{
    FILE *file;
    int code = tool_file_begin(&file, b->request->folder, "peers.csv", err);
    if (code)
        return code;
    print_rows(b, file, true);
    return tool_file_finish(&file, b->request->folder, "peers.csv", err);
}

static int run(const struct request *request, const char *path, struct brick_error *err)
{
    struct brick_volume *volume = NULL;
    struct brick_transfer *transfer = NULL;
    struct bench *b = calloc(1, sizeof *b);
    if (!b)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the results");
    *b = (struct bench){.request = request, .peer = {.to = -1, .from = -1}};
    int code = tool_folder_make(request->folder, err);
    if (!code)
        code = brick_volume_open(&volume, path, err);
    if (!code)
        code = tool_transfer_load(&transfer, request->tf, volume, err);
    if (code)
        goto done;
    b->volume = volume;
    bench_view_scene(&request->view, volume, &b->scene);
    b->scene.transfer = transfer;
    for (uint32_t i = 0; i <= request->frames; i++)
        brick_camera_orbit(&b->cameras[i], brick_volume_grid(volume), request->view.orbit[0] + 7.0 * i,
                           request->view.orbit[1], 0, 0, (double)b->scene.width / b->scene.height);
    if ((code = measure(b, err)))
        goto done;
    printf("%ux%u, step %g, %u frames\n", b->scene.width, b->scene.height, request->quality.step_vox,
           request->frames);
    print_rows(b, stdout, false);
    printf("extraction is part of seconds; ratio: to raycast; max_abs and rmse: colour over black, to the "
           "exact picture.\n");
    code = write_csv(b, err);
done:
    peer_stop(&b->peer);
    if (*b->raw)
        remove(b->raw);
    vr_renderer_destroy(&b->renderer);
    vr_renderer_destroy(&b->processor);
    vr_isotracer_destroy(&b->tracer);
    for (int mode = 0; mode < MODES; mode++)
        brick_image_finish(&b->exact[mode]);
    brick_image_finish(&b->image);
    free(b);
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
    return code;
}

int bench_peers(int argc, char **argv)
{
    struct request r = {
        .python = "/usr/bin/python3",
        .view = {.size = {512, 512}},
        .frames = 5,
        .quality = vr_quality_defaults,
        .renderer = vr_renderer_defaults,
    };
    int first = 0;
    r.quality.step_vox = 1.0;
    const struct tool_option options[] = {
        {"output", .letter = 'o', .value = "DIR", .parse = tool_parse_text, .target = &r.folder,
         .required = true,
         .help =
             "folder for peers.csv and a picture of each way; the volume is there as a raw file meanwhile"},
        {BENCH_TF, .target = &r.tf},
        {BENCH_ISO(r.view)},
        {"frames", .value = "N", .parse = tool_parse_u32, .target = &r.frames,
         .limits = {.min = 1, .max = FRAMES_MAX}, .help = "frames to take the median of (default 5)"},
        {BENCH_SIZE(r.view, "512x512")},
        {BENCH_STEP("1"), .target = &r.quality.step_vox},
        {"camera", .value = "AZ,EL", .parse = tool_parse_pair, .target = r.view.orbit,
         .help = "azimuth and elevation of the first frame in degrees (default 0,0)"},
        {BENCH_GPU_CACHE, .target = &r.renderer.gpu_cache_bytes},
        {"python", .value = "PROGRAM", .parse = tool_parse_text, .target = &r.python,
         .help = "a Python that has VTK (default /usr/bin/python3)"},
        TOOL_OPTION_THREADS(&r.renderer.threads),
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "FILE -o DIR [OPTIONS]",
        .summary =
            "The same frames by this program and by VTK, in turns, each held against the exact picture.\n"
            "Needs Debian's python3-vtk9, and xvfb where there is no display.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    struct brick_error err = {0};
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    code = run(&r, argv[first], &err);
    return code ? tool_fail(COMMAND, &err) : 0;
}
