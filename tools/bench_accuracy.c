/* Why: what a second of computing buys. Every way to draw the same picture, at several steps, is timed and
 * held against the exact picture, of the field that it converges to and of the trilinear one. Variants take
 * turns, so that a slow minute of the machine falls on all of them. */
#include "bench_accuracy.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_view.h"
#include "figure.h"
#include "message.h"
#include "transfer.h"

#define COMMAND "bench accuracy"

enum { FIELDS = VR_FIELD_PRECLASSIFIED + 1, VARIANTS_MAX = 64, STUDIOS_MAX = 8 };

static const char *const modes[] = {"dvr", "shaded", NULL};

struct request {
    const char *tf, *folder;
    uint32_t frames;
    struct bench_view view;
    struct tool_reals steps;
    struct vr_renderer_params renderer;
    int mode;
};

/* A renderer whose GPU cache holds bricks in one way, so that no row finds it filled in another's. */
struct studio {
    enum vr_filter filter;
    bool cpu;
    uint32_t classified_bits; /* 0: voxels */
    struct vr_renderer *renderer;
};

struct bench {
    const struct request *request;
    const struct brick_volume *volume;
    struct vr_scene scene;
    struct studio studios[STUDIOS_MAX];
    size_t studio_count;
    struct brick_image exact[FIELDS], image;
    struct bench_variant variants[VARIANTS_MAX];
    size_t variant_count;
    struct bench_accuracy_row *rows;
    double (*seconds)[BENCH_REPEAT_MAX];
    size_t row_count;
};

static struct vr_quality *add(struct bench *b, const char *name, enum vr_method method, enum vr_field field,
                              double order, bool steps)
{
    struct bench_variant *v = &b->variants[b->variant_count++];
    *v = (struct bench_variant){
        .name = name, .quality = vr_quality_defaults, .field = field, .order = order, .steps = steps};
    v->quality.method = method;
    v->quality.termination = 0.0;
    return &v->quality;
}

static struct vr_quality *add_slices(struct bench *b, const char *name, enum vr_field field, double order)
{
    struct vr_quality *quality = add(b, name, VR_METHOD_SLICES, field, order, true);
    quality->slices.planes = 0; /* as the step says */
    return quality;
}

/* Pre-classified voxels: opacities of slices are interpolated and not extinction, order 1. Rounding has none.
 */
static void list_slices(struct bench *b, double order)
{
    add_slices(b, "slices", VR_FIELD_TRILINEAR, order);
    add_slices(b, "slices, termination 1e-2", VR_FIELD_TRILINEAR, 0)->termination = 1e-2;
    add_slices(b, "slices, point", VR_FIELD_TRILINEAR, 0)->slices.interpolation = VR_INTERPOLATION_POINT;
    add_slices(b, "slices, framebuffer 8", VR_FIELD_TRILINEAR, 0)->slices.framebuffer = VR_FRAMEBUFFER_8;
    add_slices(b, "slices, framebuffer 16f", VR_FIELD_TRILINEAR, 0)->slices.framebuffer = VR_FRAMEBUFFER_16F;
    for (uint32_t bits = 8; bits <= 32 && b->scene.mode == BRICK_MODE_DVR; bits *= 2) {
        static const char *const names[] = {"slices, pre 8", "slices, pre 16", "slices, pre 32"};
        struct vr_quality *quality =
            add_slices(b, names[bits / 16], VR_FIELD_PRECLASSIFIED, bits == 32 ? 1.0 : 0.0);
        quality->classification = VR_CLASSIFY_PRE;
        quality->slices.classified_bits = bits;
    }
}

/* No step: each tetrahedron is integrated from front to back. */
static void list_cells(struct bench *b)
{
    static const struct {
        const char *name;
        enum vr_cells_integration integration;
    } ways[] = {{"cells, prefix", VR_CELLS_PREFIX},
                {"cells, psi", VR_CELLS_PSI},
                {"cells, average", VR_CELLS_AVERAGE}};
    for (size_t i = 0; i < TOOL_COUNT(ways) && b->scene.mode == BRICK_MODE_DVR; i++)
        add(b, ways[i].name, VR_METHOD_CELLS, VR_FIELD_TETRAHEDRA, 0, false)->cells_integration =
            ways[i].integration;
}

/* What is compared. Orders: midpoint samples have order 2 where the integrand is smooth; shading has
 * directions that jump where the gradient vanishes, and order 1.5 (docs/accuracy.md). */
static void list_variants(struct bench *b)
{
    const double order = b->scene.mode == BRICK_MODE_SHADED ? 1.5 : 2.0;
    add(b, "raycast", VR_METHOD_RAYCAST, VR_FIELD_TRILINEAR, order, true);
    add(b, "raycast, termination 1e-2", VR_METHOD_RAYCAST, VR_FIELD_TRILINEAR, 0, true)->termination = 1e-2;
    add(b, "raycast, termination 1e-4", VR_METHOD_RAYCAST, VR_FIELD_TRILINEAR, 0, true)->termination = 1e-4;
    add(b, "raycast, no OpenGL", VR_METHOD_RAYCAST, VR_FIELD_TRILINEAR, order, true);
    b->variants[b->variant_count - 1].cpu = true;
    add(b, "raycast, no OpenGL, 1e-4", VR_METHOD_RAYCAST, VR_FIELD_TRILINEAR, 0, true)->termination = 1e-4;
    b->variants[b->variant_count - 1].cpu = true;
    add(b, "raycast, fast filter", VR_METHOD_RAYCAST, VR_FIELD_TRILINEAR, order, true);
    b->variants[b->variant_count - 1].filter = VR_FILTER_FAST;
    add(b, "multipass", VR_METHOD_MULTIPASS, VR_FIELD_TRILINEAR, order, true);
    list_slices(b, order);
    list_cells(b);
    add(b, "raycast, pre-integrated", VR_METHOD_RAYCAST, VR_FIELD_TRILINEAR, order, true)->classification =
        VR_CLASSIFY_PREINTEGRATED;
    add_slices(b, "slices, pre-integrated", VR_FIELD_TRILINEAR, order)->classification =
        VR_CLASSIFY_PREINTEGRATED;
}

static int draw_exact(struct bench *b, struct brick_error *err)
{
    int code = 0;
    for (int f = 0; f < FIELDS && !code; f++) {
        bool wanted = f == VR_FIELD_TRILINEAR;
        for (size_t v = 0; v < b->variant_count; v++)
            wanted = wanted || b->variants[v].field == (enum vr_field)f;
        struct vr_exact_params params = vr_exact_defaults;
        params.host_cache_bytes = b->request->renderer.host_cache_bytes;
        params.threads = b->request->renderer.threads;
        params.field = (enum vr_field)f;
        if (wanted && !(code = brick_image_init(&b->exact[f], b->scene.width, b->scene.height, err)))
            code = vr_render_exact(b->volume, &b->scene, &params, &b->exact[f], NULL, err);
    }
    return code;
}

static int studio_for(struct bench *b, const struct bench_variant *v, struct vr_renderer **renderer,
                      struct brick_error *err)
{
    const uint32_t bits =
        v->quality.classification == VR_CLASSIFY_PRE ? v->quality.slices.classified_bits : 0;
    struct vr_renderer_params params = b->request->renderer;
    size_t i = 0;
    while (i < b->studio_count && (b->studios[i].filter != v->filter || b->studios[i].cpu != v->cpu ||
                                   b->studios[i].classified_bits != bits))
        i++;
    if (i == STUDIOS_MAX)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "more than %d ways to hold bricks", STUDIOS_MAX);
    if (i == b->studio_count) {
        b->studios[b->studio_count++] = (struct studio){v->filter, v->cpu, bits, NULL};
        params.filter = v->filter;
        if (v->cpu)
            params.context = VR_CONTEXT_CPU;
        int code = vr_renderer_create(&b->studios[i].renderer, b->volume, &params, err);
        if (code)
            return code;
    }
    *renderer = b->studios[i].renderer;
    return 0;
}

/* Frame 0 loads bricks and compiles shaders, and is held against the exact ones; the others are timed. */
static int draw_row(struct bench *b, size_t row, uint32_t frame, struct brick_error *err)
{
    struct bench_accuracy_row *r = &b->rows[row];
    struct vr_quality quality = r->variant->quality;
    quality.step_vox = r->step;
    struct vr_renderer *renderer = NULL;
    int code = studio_for(b, r->variant, &renderer, err);
    if (!code)
        code = vr_render(renderer, &b->scene, &quality, &b->image, &r->report, err);
    if (code)
        return code;
    if (frame) {
        b->seconds[row][frame - 1] = r->report.seconds_frame;
        return 0;
    }
    code = brick_image_compare(&b->image, &b->exact[r->variant->field], &r->own, err);
    return code ? code : brick_image_compare(&b->image, &b->exact[VR_FIELD_TRILINEAR], &r->trilinear, err);
}

static int measure(struct bench *b, struct brick_error *err)
{
    const uint32_t frames = b->request->frames;
    int code = draw_exact(b, err);
    if (!code)
        code = brick_image_init(&b->image, b->scene.width, b->scene.height, err);
    for (uint32_t frame = 0; frame <= frames && !code; frame++)
        for (size_t row = 0; row < b->row_count && !code; row++)
            code = draw_row(b, row, frame, err);
    for (size_t row = 0; row < b->row_count && !code; row++)
        b->rows[row].seconds = bench_spread(b->seconds[row], frames);
    return code;
}

static int list_rows(struct bench *b, struct brick_error *err)
{
    const struct tool_reals *steps = &b->request->steps;
    b->rows = calloc(b->variant_count * steps->count, sizeof *b->rows);
    b->seconds = calloc(b->variant_count * steps->count, sizeof *b->seconds);
    if (!b->rows || !b->seconds)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the results");
    for (size_t v = 0; v < b->variant_count; v++) {
        const struct bench_variant *variant = &b->variants[v];
        const double longest = variant->quality.classification == VR_CLASSIFY_PREINTEGRATED ? 1.0 : INFINITY;
        for (uint32_t s = 0; s < (variant->steps ? steps->count : 1); s++)
            if (steps->value[s] <= longest)
                b->rows[b->row_count++] =
                    (struct bench_accuracy_row){.variant = variant, .step = steps->value[s]};
    }
    return 0;
}

static int run(const struct request *request, const char *path, struct brick_error *err)
{
    struct bench b = {.request = request};
    struct bench_view view = request->view;
    struct brick_volume *volume = NULL;
    struct brick_transfer *transfer = NULL;
    bool drawn = false;
    char title[256];

    int code = tool_folder_make(request->folder, err);
    if (!code)
        code = brick_volume_open(&volume, path, err);
    if (!code)
        code = tool_transfer_load(&transfer, request->tf, volume, err);
    if (code)
        goto done;
    b.volume = volume;
    if (!(view.ortho_mm > 0.0))
        view.ortho_mm = bench_view_diagonal_mm(volume);
    bench_view_scene(&view, volume, &b.scene);
    b.scene.mode = (enum brick_mode)request->mode;
    b.scene.transfer = transfer;
    list_variants(&b);
    if ((code = list_rows(&b, err)) || (code = measure(&b, err)))
        goto done;
    bench_accuracy_mark(b.rows, b.row_count);
    bench_accuracy_print(b.rows, b.row_count);
    snprintf(title, sizeof title, "%.100s, %s, %ux%u", request->tf ? request->tf : TOOL_TRANSFER_DEFAULT,
             modes[request->mode], b.scene.width, b.scene.height);
    code = bench_accuracy_write(b.rows, b.row_count, title, request->folder, &drawn, err);
    if (!code && !drawn)
        tool_note(COMMAND, "no plots: gnuplot is not installed (Debian: gnuplot-nox)");
done:
    for (size_t i = 0; i < b.studio_count; i++)
        vr_renderer_destroy(&b.studios[i].renderer);
    for (int f = 0; f < FIELDS; f++)
        brick_image_finish(&b.exact[f]);
    brick_image_finish(&b.image);
    free(b.rows);
    free(b.seconds);
    brick_transfer_destroy(&transfer);
    brick_volume_close(&volume);
    return code;
}

int bench_accuracy(int argc, char **argv)
{
    struct request r = {
        .view = {.size = {256, 256}, .orbit = {20, 10}},
        .frames = 3,
        .steps = {.count = 4, .value = {2, 1, 0.5, 0.25}},
        .renderer = vr_renderer_defaults,
    };
    int first = 0;
    const struct tool_option options[] = {
        {"output", .letter = 'o', .value = "DIR", .parse = tool_parse_text, .target = &r.folder,
         .required = true, .help = "folder for accuracy.csv, accuracy.svg and accuracy.png"},
        {BENCH_TF, .target = &r.tf},
        {"mode", .value = "MODE", .parse = tool_parse_choice, .target = &r.mode, .limits = {.choices = modes},
         .help = "dvr (default) or shaded"},
        {"steps", .value = "S,S,..", .parse = tool_parse_reals, .target = &r.steps,
         .help = "sampling distances in smallest voxel edges (default 2,1,0.5,0.25)"},
        {BENCH_FRAMES("3"), .target = &r.frames},
        {BENCH_SIZE(r.view, "256x256")},
        {BENCH_CAMERA(r.view, "20,10")},
        {"ortho", .value = "H", .parse = tool_parse_positive, .target = &r.view.ortho_mm,
         .help = "parallel projection, the picture's height in mm (default: fits the volume)"},
        TOOL_OPTION_THREADS(&r.renderer.threads),
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "FILE -o DIR [OPTIONS]",
        .summary = "Speed against error of every method, at several steps, against the exact picture.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    struct brick_error err = {0};
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    for (uint32_t i = 0; i < r.steps.count; i++)
        if (!(r.steps.value[i] > 0.0) || !isfinite(r.steps.value[i]))
            return tool_misuse(COMMAND, "--steps: %g is not above 0", r.steps.value[i]);
    code = run(&r, argv[first], &err);
    return code ? tool_fail(COMMAND, &err) : 0;
}
