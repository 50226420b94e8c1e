/* Maximo, Marroquim, Farias and Esperanca 2008: tetrahedra a second, of the volume and drawn (table 1), and
 * finding them against drawing them (table 2), at 512 x 512, the model rotating. Their scans: a skull, a
 * foot, a fuel injection. */
#include <math.h>
#include <stdio.h>

#include "papers.h"
#include "table.h"

static const struct {
    int kind;
    const char *like;
    double nominal, effective, render_percent; /* theirs; M tetrahedra a second */
} rows[] = {
    {PAPER_CT, "CT (skull)", 51.7, 6.25, 65.10},
    {PAPER_BODY_SMALL, "body 256x256x128 (foot)", 67.7, 6.23, 66.57},
    {PAPER_LOBB, "Marschner-Lobb 64^3 (fuel)", 88.5, 5.99, 64.28},
};

static void set_way(const struct paper_volume *volume, size_t way, struct vr_scene *scene,
                    struct vr_quality *quality)
{
    (void)way; /* the only one */
    paper_scene(volume, BRICK_MODE_DVR, 0.0, true, scene);
    quality->method = VR_METHOD_CELLS;
    quality->cells_integration = VR_CELLS_PSI;
}

int paper_maximo(struct papers *papers, struct brick_error *err)
{
    struct paper_table rates = {
        .name = "maximo-1",
        .title = "Maximo et al. 2008, table 1: millions of tetrahedra a second (512x512, psi)",
        .note = "nominal: all of the volume; effective: those drawn, the others being transparent.",
        .column = {"tetrahedra", "frames/s", "nominal", "effective", "nom./eff.", "paper", "paper's eff."},
        .columns = 7,
        .ours = 4,
        .paper = 5,
    };
    struct paper_table shares = {
        .name = "maximo-2",
        .title = "Maximo et al. 2008, table 2: finding what is drawn, and drawing it",
        .column = {"set-up s", "draw s", "draw %", "paper"},
        .columns = 4,
        .ours = 2,
        .paper = 3,
    };
    int code = BRICK_OK;
    for (size_t r = 0; r < sizeof rows / sizeof *rows && !code; r++) {
        struct paper_time time;
        const struct vr_report *report = &time.report;
        if ((code = paper_measure(papers, rows[r].kind, set_way, 1, &time, err)) ||
            !papers->volume[rows[r].kind].volume)
            continue;
        struct paper_row *row = paper_row_add(&rates, rows[r].like);
        row->value[0] = 1e-6 * (double)report->tetrahedra;
        row->value[1] = 1.0 / time.seconds;
        row->value[2] = 1e-6 * (double)report->tetrahedra / time.seconds;
        row->value[3] = 1e-6 * (double)report->samples / time.seconds;
        row->value[4] = (double)report->tetrahedra / (double)report->samples;
        row->value[5] = rows[r].nominal / rows[r].effective;
        row->value[6] = rows[r].effective;
        row = paper_row_add(&shares, rows[r].like);
        row->value[0] = report->seconds_setup;
        row->value[1] = report->seconds_draw;
        row->value[2] = 100.0 * report->seconds_draw / (report->seconds_draw + report->seconds_setup);
        row->value[3] = rows[r].render_percent;
    }
    if (code)
        return code;
    const struct paper_table *tables[] = {&rates, &shares};
    return paper_tables_show(papers, tables, 2, err);
}
