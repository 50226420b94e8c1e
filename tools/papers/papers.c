/* Why: what the papers claim is measured again, on like data. Their scans are not free to hand on, so bodies
 * of the same sizes are made, used and removed, one at a time; real scans are the user's. */
#include "papers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <brick/build.h>
#include <formats/formats.h>

#include "../bench_view.h"
#include "../figure.h"
#include "../message.h"
#include "../transfer.h"
#include "table.h"

#define COMMAND "bench papers"

static const struct {
    const char *name, *synth, *tf;
    uint64_t dims[3];
    enum brick_type type;
    double iso[2]; /* NaN: shares of the range, 0.3 and 0.6 */
} kinds[PAPER_VOLUMES] = {
    [PAPER_BODY_SMALL] = {"body 256x256x128", "ct", "ct-bone", {256, 256, 128}, BRICK_I16, {-300, 300}},
    [PAPER_BODY_MEDIUM] = {"body 512x512x333", "ct", "ct-bone", {512, 512, 333}, BRICK_I16, {-300, 300}},
    [PAPER_BODY_LARGE] = {"body 512x512x1112", "ct", "ct-bone", {512, 512, 1112}, BRICK_I16, {-300, 300}},
    [PAPER_BODY_HUGE] = {"body 512x512x1734", "ct", "ct-bone", {512, 512, 1734}, BRICK_I16, {-300, 300}},
    [PAPER_CT] = {"CT", NULL, "ct-bone", {0}, BRICK_I16, {-300, 300}},
    [PAPER_MRI] = {"MRI", NULL, "mri", {0}, BRICK_U8, {NAN, NAN}},
    [PAPER_LOBB] = {"Marschner-Lobb 64^3", "marschner-lobb", "gray", {64, 64, 64}, BRICK_F32, {NAN, NAN}},
};

struct request {
    struct papers papers;
    const char *scan[PAPER_VOLUMES]; /* files given */
    int only;
};

static const struct {
    const char *name;
    int (*run)(struct papers *papers, struct brick_error *err);
} chapters[] = {
    {"scharsach", paper_scharsach}, {"krueger", paper_krueger}, {"maximo", paper_maximo},
    {"parker", paper_parker},       {"wilson", paper_wilson},
};

void paper_scene(const struct paper_volume *v, enum brick_mode mode, double azimuth, bool parallel,
                 struct vr_scene *scene)
{
    const struct bench_view view = {.size = {512, 512},
                                    .orbit = {azimuth, 10.0},
                                    .ortho_mm = parallel ? bench_view_diagonal_mm(v->volume) : 0.0,
                                    .iso = v->iso[1],
                                    .has_iso = true};
    bench_view_scene(&view, v->volume, scene);
    scene->mode = mode;
    scene->transfer = mode == BRICK_MODE_ISO ? NULL : v->transfer;
}

int paper_tables_show(const struct papers *papers, const struct paper_table *const tables[], size_t count,
                      struct brick_error *err)
{
    char path[4096];
    int n = snprintf(path, sizeof path, "%s/papers.txt", papers->folder), code = 0;
    FILE *file = n > 0 && (size_t)n < sizeof path ? fopen(path, "a") : NULL;
    if (!file)
        return brick_fail(err, BRICK_ERR_IO, "%s/papers.txt: cannot write", papers->folder);
    for (size_t i = 0; i < count && !code; i++) {
        paper_table_print(tables[i], stdout);
        paper_table_print(tables[i], file);
        code = paper_table_write(tables[i], papers->folder, err);
    }
    fflush(stdout);
    return fclose(file) && !code ? brick_fail(err, BRICK_ERR_IO, "%s: cannot write", path) : code;
}

static int make(const struct papers *papers, int kind, struct paper_volume *v, struct brick_error *err)
{
    const struct fmt_synth_params params = {.type = kinds[kind].type,
                                            .seed = 1,
                                            .dims = {v->dims[0], v->dims[1], v->dims[2]},
                                            .threads = papers->renderer.threads};
    struct brick_source *source = NULL;
    struct brick_build_report report;
    int n = snprintf(v->path, sizeof v->path, "%s/volume-%d.brick", papers->folder, kind);
    if (n < 0 || (size_t)n >= sizeof v->path)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the folder's name is too long");
    fprintf(stderr, "making %s\n", v->name);
    int code = fmt_synth_open(&source, kinds[kind].synth, &params, err);
    if (!code)
        code = brick_build(source, v->path, &brick_build_defaults, &report, err);
    brick_source_destroy(&source);
    return code;
}

int paper_volume_open(struct papers *papers, int kind, struct brick_error *err)
{
    struct paper_volume *v = &papers->volume[kind];
    double range[2];
    int code = 0;
    if (v->volume || (!kinds[kind].synth && !*v->path))
        return BRICK_OK;
    v->name = kinds[kind].name;
    memcpy(v->dims, kinds[kind].dims, sizeof v->dims);
    if (kinds[kind].synth)
        code = make(papers, kind, v, err);
    if (!code)
        code = brick_volume_open(&v->volume, v->path, err);
    if (!code)
        code = tool_transfer_load(&v->transfer, kinds[kind].tf, v->volume, err);
    if (code)
        return code;
    brick_volume_value_range(v->volume, range);
    for (int i = 0; i < 2; i++)
        v->iso[i] = isnan(kinds[kind].iso[i]) ? range[0] + (range[1] - range[0]) * (i ? 0.6 : 0.3)
                                              : kinds[kind].iso[i];
    return BRICK_OK;
}

void paper_volume_close(struct papers *papers, int kind)
{
    struct paper_volume *v = &papers->volume[kind];
    brick_transfer_destroy(&v->transfer);
    brick_volume_close(&v->volume);
    if (kinds[kind].synth && *v->path) {
        unlink(v->path);
        *v->path = '\0';
    }
}

static void turn(struct vr_scene *scene, const struct paper_volume *volume, uint32_t frame)
{
    const double height = scene->camera.ortho_height_mm;
    brick_camera_orbit(&scene->camera, brick_volume_grid(volume->volume), 20.0 + 11.0 * frame, 10.0, 0.0,
                       height, 1.0);
}

int paper_measure(struct papers *papers, int kind, paper_way *way, size_t ways, struct paper_time *times,
                  struct brick_error *err)
{
    static double seconds[PAPER_WAYS][BENCH_REPEAT_MAX];
    const struct paper_volume *volume = &papers->volume[kind];
    struct vr_renderer *renderer = NULL;
    struct brick_image image = {0};
    int code = paper_volume_open(papers, kind, err);
    if (code || !volume->volume)
        return code;
    code = brick_image_init(&image, vr_scene_defaults.width, vr_scene_defaults.height, err);
    if (!code)
        code = vr_renderer_create(&renderer, volume->volume, &papers->renderer, err);
    for (uint32_t frame = 0; frame <= papers->frames && !code; frame++)
        for (size_t w = 0; w < ways && !code; w++) {
            struct vr_scene scene;
            struct vr_quality quality = vr_quality_defaults;
            way(volume, w, &scene, &quality);
            turn(&scene, volume, frame);
            code = vr_render(renderer, &scene, &quality, &image, &times[w].report, err);
            if (frame)
                seconds[w][frame - 1] = times[w].report.seconds_frame;
        }
    for (size_t w = 0; w < ways && !code; w++)
        times[w].seconds = bench_spread(seconds[w], papers->frames).median;
    vr_renderer_destroy(&renderer);
    brick_image_finish(&image);
    return code;
}

int bench_papers(int argc, char **argv)
{
    static const char *names[TOOL_COUNT(chapters) + 2] = {"all"};
    struct request r = {.papers = {.frames = 3, .renderer = vr_renderer_defaults}};
    int first = 0;
    for (size_t c = 0; c < TOOL_COUNT(chapters); c++)
        names[c + 1] = chapters[c].name;
    const struct tool_option options[] = {
        {"output", .letter = 'o', .value = "DIR", .parse = tool_parse_text, .target = &r.papers.folder,
         .required = true,
         .help = "folder for the tables as text and CSV, and plots; volumes are there meanwhile"},
        {"ct", .value = "FILE.brick", .parse = tool_parse_text, .target = &r.scan[PAPER_CT],
         .help = "a CT in Hounsfield units, for the rows on real data"},
        {"mri", .value = "FILE.brick", .parse = tool_parse_text, .target = &r.scan[PAPER_MRI],
         .help = "an MRI, for the rows on real data"},
        {"only", .value = "PAPER", .parse = tool_parse_choice, .target = &r.only,
         .limits = {.choices = names},
         .help = "all (default), or the tables of one paper, by its first author"},
        {BENCH_FRAMES("3"), .target = &r.papers.frames},
        TOOL_OPTION_THREADS(&r.papers.renderer.threads),
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "-o DIR [OPTIONS]",
        .summary =
            "The tables of the five papers again, as ratios measured in one run beside the papers' own.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {0, 0, "no arguments"},
    };
    struct brick_error err = {0};
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    for (int kind = 0; kind < PAPER_VOLUMES; kind++)
        if (r.scan[kind])
            snprintf(r.papers.volume[kind].path, sizeof r.papers.volume[kind].path, "%s", r.scan[kind]);
    code = tool_folder_make(r.papers.folder, &err);
    FILE *file = NULL; /* emptied; the chapters append */
    if (!code && !(code = tool_file_begin(&file, r.papers.folder, "papers.txt", &err)))
        code = tool_file_finish(&file, r.papers.folder, "papers.txt", &err);
    for (size_t c = 0; c < TOOL_COUNT(chapters) && !code; c++)
        if (!r.only || r.only == (int)c + 1)
            code = chapters[c].run(&r.papers, &err);
    for (int kind = 0; kind < PAPER_VOLUMES; kind++)
        paper_volume_close(&r.papers, kind);
    return code ? tool_fail(COMMAND, &err) : 0;
}
