/* Krueger and Westermann 2003, table 1: slices against rays in passes, without acceleration, with early
 * termination, and with skipping of empty space too, at 512 x 512. Their scans: an MRI head, a foot (CT), and
 * an engine. */
#include <math.h>
#include <stdio.h>

#include "papers.h"
#include "table.h"

enum { SLICES, PLAIN, TERMINATED, SKIPPED, WAYS };

/* Frames a second, theirs. */
static const struct {
    int kind;
    const char *like;
    double paper[WAYS];
} rows[] = {
    {PAPER_MRI, "MRI (head)", {7.1, 4.8, 14.4, 23.4}},
    {PAPER_CT, "CT (foot)", {7.1, 4.8, 10.2, 17.7}},
    {PAPER_BODY_SMALL, "body 256x256x128", {NAN, NAN, NAN, NAN}},
    {PAPER_LOBB, "Marschner-Lobb 64^3", {NAN, NAN, NAN, NAN}},
};

static void set_way(const struct paper_volume *volume, size_t way, struct vr_scene *scene,
                    struct vr_quality *quality)
{
    paper_scene(volume, BRICK_MODE_DVR, 0.0, false, scene);
    quality->method = way == SLICES ? VR_METHOD_SLICES : VR_METHOD_MULTIPASS;
    quality->step_vox = 1.0;
    quality->termination = way >= TERMINATED ? 0.05 : 0.0;
    quality->skip = way == SKIPPED;
    quality->slices.planes = 0; /* one a step */
    quality->slices.back_to_front = true;
    quality->slices.framebuffer = VR_FRAMEBUFFER_8;
}

int paper_krueger(struct papers *papers, struct brick_error *err)
{
    struct paper_table table = {
        .name = "krueger-1",
        .title = "Krueger and Westermann 2003, table 1: frames a second (512x512, step 1)",
        .note = "slices: all of them, in 8 bits; rays: in passes, plain, ending below a transmittance of "
                "0.05, and skipping too.\n"
                "Ratios to plain rays.",
        .column = {"slices", "rays", "terminated", "and skipping", "slices/rays", "paper", "term./rays",
                   "paper", "skip/rays", "paper"},
        .columns = 10,
        .ours = 8,
        .paper = 9,
    };
    int code = BRICK_OK;
    for (size_t r = 0; r < sizeof rows / sizeof *rows && !code; r++) {
        struct paper_time times[WAYS];
        if ((code = paper_measure(papers, rows[r].kind, set_way, WAYS, times, err)) ||
            !papers->volume[rows[r].kind].volume)
            continue;
        struct paper_row *row = paper_row_add(&table, rows[r].like);
        for (int w = 0; w < WAYS; w++)
            row->value[w] = 1.0 / times[w].seconds;
        static const int compared[] = {SLICES, TERMINATED, SKIPPED};
        for (int i = 0; i < 3; i++) {
            row->value[4 + 2 * i] = times[PLAIN].seconds / times[compared[i]].seconds;
            row->value[5 + 2 * i] = rows[r].paper[compared[i]] / rows[r].paper[PLAIN];
        }
    }
    if (code)
        return code;
    const struct paper_table *tables[] = {&table};
    return paper_tables_show(papers, tables, 1, err);
}
