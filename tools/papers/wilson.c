/* Wilson, Van Gelder and Wilhelms 1994, table 1 and the model below it: slices, bits and interpolation of
 * pre-classified textures, back to front, 600 x 600 pixels. Their volume is a protein of 64^3 voxels; here
 * Marschner and Lobb's signal of that size. Their 12 bits are 16 here. */
#include <math.h>
#include <stdio.h>

#include "../bench.h"
#include "papers.h"
#include "table.h"

enum { COUNTS = 3, BITS = 3, WAYS = 2 };
static const uint32_t counts[COUNTS] = {55, 110, 220}, bits[BITS] = {8, 16, 32};
static const char *const ways[WAYS] = {"point", "trilinear"};

/* The paper's seconds to draw a frame, by [count][bits][way]; NaN: not in it. */
static const double paper_seconds[COUNTS][BITS][WAYS] = {
    {{0.12, NAN}, {NAN, NAN}, {NAN, NAN}},
    {{0.20, NAN}, {NAN, NAN}, {NAN, NAN}},
    {{0.38, NAN}, {0.71, 1.11}, {NAN, NAN}},
};

struct bench {
    struct vr_renderer *renderer;
    struct vr_scene scene;
    struct brick_image image;
    double first[COUNTS][BITS][WAYS], seconds[COUNTS][BITS][WAYS]; /* with the textures to be made; after */
};

static int measure(struct bench *b, int n, int depth, int way, uint32_t frames, struct brick_error *err)
{
    struct vr_quality quality = vr_quality_defaults;
    struct vr_report report;
    double seconds[BENCH_REPEAT_MAX];
    int code = 0;
    quality.method = VR_METHOD_SLICES;
    quality.classification = VR_CLASSIFY_PRE;
    quality.slices = (struct vr_slices){
        .planes = counts[n],
        .interpolation = way ? VR_INTERPOLATION_TRILINEAR : VR_INTERPOLATION_POINT,
        .framebuffer = bits[depth] == 8 ? VR_FRAMEBUFFER_8 : VR_FRAMEBUFFER_32F,
        .classified_bits = bits[depth],
        .back_to_front = true,
    };
    for (uint32_t i = 0; i <= frames && !code; i++) {
        code = vr_render(b->renderer, &b->scene, &quality, &b->image, &report, err);
        if (i)
            seconds[i - 1] = report.seconds_frame;
        else
            b->first[n][depth][way] = report.seconds_frame;
    }
    if (!code)
        b->seconds[n][depth][way] = bench_spread(seconds, frames).median;
    return code;
}

/* Seconds a plane of a kind: the slope between the smallest and the largest number of planes. */
static double slope(const struct bench *b, int depth, int way)
{
    return (b->seconds[COUNTS - 1][depth][way] - b->seconds[0][depth][way]) /
           (counts[COUNTS - 1] - counts[0]);
}

static void fill(const struct bench *b, struct paper_table *times, struct paper_table *model)
{
    for (int n = COUNTS - 1; n >= 0; n--)
        for (int d = BITS - 1; d >= 0; d--)
            for (int w = WAYS - 1; w >= 0; w--) {
                char label[64];
                snprintf(label, sizeof label, "%u slices, %u bits, %s", counts[n], bits[d], ways[w]);
                struct paper_row *row = paper_row_add(times, label);
                row->value[0] = b->first[n][d][w];
                row->value[1] = b->seconds[n][d][w];
                row->value[2] = b->seconds[n][d][w] / b->seconds[0][0][0];
                row->value[3] = paper_seconds[n][d][w] / paper_seconds[0][0][0];
            }
    static const char *const labels[] = {"seconds a plane, 8 bits, point", "times, 16 bits", "times, 32 bits",
                                         "times, trilinear (16 bits)"};
    const double ours[] = {slope(b, 0, 0), slope(b, 1, 0) / slope(b, 0, 0), slope(b, 2, 0) / slope(b, 0, 0),
                           slope(b, 1, 1) / slope(b, 1, 0)};
    const double paper[] = {0.001455, 2.06, NAN, 1.63};
    for (int i = 0; i < 4; i++) {
        struct paper_row *row = paper_row_add(model, labels[i]);
        row->value[0] = ours[i];
        row->value[1] = paper[i];
    }
}

int paper_wilson(struct papers *papers, struct brick_error *err)
{
    const struct paper_volume *volume = &papers->volume[PAPER_LOBB];
    struct paper_table times = {
        .name = "wilson-1",
        .title = "Wilson et al. 1994, table 1: slices, bits, interpolation (64^3, 600x600)",
        .note = "first: the frame that makes the textures. Ratios: to 55 slices of 8 bits, point. The "
                "paper's 12 bits are "
                "16 here.",
        .column = {"first s", "seconds", "ratio", "paper"},
        .columns = 4,
        .ours = 2,
        .paper = 3,
    };
    struct paper_table model = {
        .name = "wilson-2",
        .title = "Wilson et al. 1994, section 3: the linear model of a frame's seconds",
        .note = "seconds = planes * a * (1 + b * more bits) * (1 + c * trilinear)",
        .column = {"here", "paper"},
        .columns = 2,
    };
    struct bench b = {0};
    int code = paper_volume_open(papers, PAPER_LOBB, err);
    if (code)
        return code;
    paper_scene(volume, BRICK_MODE_DVR, 30.0, false, &b.scene);
    b.scene.width = b.scene.height = 600;
    if (!(code = brick_image_init(&b.image, b.scene.width, b.scene.height, err)))
        code = vr_renderer_create(&b.renderer, volume->volume, &papers->renderer, err);
    for (int n = 0; n < COUNTS && !code; n++)
        for (int d = 0; d < BITS && !code; d++)
            for (int w = 0; w < WAYS && !code; w++)
                code = measure(&b, n, d, w, papers->frames, err);
    vr_renderer_destroy(&b.renderer);
    brick_image_finish(&b.image);
    if (code)
        return code;
    fill(&b, &times, &model);
    const struct paper_table *tables[] = {&times, &model};
    return paper_tables_show(papers, tables, 2, err);
}
