/* Scharsach 2005: isosurfaces with bounding geometry and with refinement at a step of 5 (table 1), the cost
 * of shading (table 2), and what blocking leaves of a volume (section 8, figure 12). His basic algorithm
 * samples all of the ray in the box. */
#include <math.h>
#include <stdio.h>

#include <brick/active.h>

#include "papers.h"
#include "table.h"

/* Frames a second, his. */
static const struct {
    int kind;
    double basic, geometry, refined, dvr, shaded;
} rows[] = {
    {PAPER_BODY_SMALL, 14.6, 41.7, 350.0, 40.5, 26.7},
    {PAPER_BODY_MEDIUM, 4.4, 24.3, 66.4, 23.9, 11.3},
    {PAPER_BODY_LARGE, 1.5, 5.1, 15.1, 4.4, 1.5},
    {PAPER_CT, NAN, NAN, NAN, NAN, NAN},
    {PAPER_MRI, NAN, NAN, NAN, NAN, NAN},
};

enum { BASIC, GEOMETRY, REFINED, LEAPS, DVR, SHADED, WAYS };

static void set_ways(const struct paper_volume *volume, struct vr_scene scenes[WAYS],
                     struct vr_quality qualities[WAYS])
{
    for (int w = 0; w < WAYS; w++) {
        paper_scene(volume,
                    w < DVR    ? BRICK_MODE_ISO
                    : w == DVR ? BRICK_MODE_DVR
                               : BRICK_MODE_SHADED,
                    0.0, false, &scenes[w]);
        qualities[w] = vr_quality_defaults;
        qualities[w].step_vox = w == REFINED ? 5.0 : 1.0;
        qualities[w].refinements = 6;
        qualities[w].skip = w == LEAPS;
        qualities[w].setup = w == BASIC || w == LEAPS ? VR_SETUP_BOX : VR_SETUP_GEOMETRY;
    }
}

static int add_blocking(const struct paper_volume *volume, struct paper_table *table, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume->volume);
    const struct brick_active_query query = {BRICK_MODE_ISO, NULL, volume->iso[1], 0};
    const double stored = grid->edge + 2.0 * grid->border;
    struct brick_active_summary summary;
    int code = brick_active_summarise(volume->volume, &query, true, 0, &summary, err);
    if (code)
        return code;
    struct paper_row *row = paper_row_add(table, volume->name);
    row->value[0] = 100.0 * (double)summary.bricks_active / (double)summary.bricks;
    row->value[1] = 100.0 * (double)summary.macrocells_active / (double)summary.macrocells;
    row->value[2] = 100.0 * (double)summary.bricks_active * stored * stored * stored /
                    ((double)grid->dims[0] * (double)grid->dims[1] * (double)grid->dims[2]);
    return BRICK_OK;
}

int paper_scharsach(struct papers *papers, struct brick_error *err)
{
    struct paper_table iso = {
        .name = "scharsach-1",
        .title = "Scharsach 2005, table 1: isosurfaces, frames a second (512x512, step 1)",
        .note = "basic: the box, every sample; geometry: rays begin and end at its faces; refined: that at a "
                "step of 5 with 6\n"
                "bisections; leaps: the box, and leaps over inactive macrocells, this program's default. "
                "Ratios to basic.",
        .column = {"basic", "geometry", "refined", "leaps", "geom/basic", "paper", "refined/basic", "paper",
                   "leaps/basic"},
        .columns = 9,
        .ours = 4,
        .paper = 5,
    };
    struct paper_table dvr = {
        .name = "scharsach-2",
        .title =
            "Scharsach 2005, table 2: shading, frames a second, with bounding geometry (512x512, step 1)",
        .column = {"dvr", "shaded", "dvr/shaded", "paper"},
        .columns = 4,
        .ours = 2,
        .paper = 3,
    };
    struct paper_table blocks = {
        .name = "scharsach-3",
        .title = "Scharsach 2005, section 8: blocking, percent (the paper's example: 30.5, 7.2 and 36.6)",
        .note = "memory: active bricks with their borders, of the volume's voxels.",
        .column = {"bricks", "macrocells", "memory"},
        .columns = 3,
    };
    int code = BRICK_OK;
    for (size_t r = 0; r < sizeof rows / sizeof *rows && !code; r++) {
        const struct paper_volume *volume = &papers->volume[rows[r].kind];
        struct vr_scene scenes[WAYS];
        struct vr_quality qualities[WAYS];
        struct vr_report reports[WAYS];
        double seconds[WAYS];
        if ((code = paper_volume_open(papers, rows[r].kind, err)) || !volume->volume)
            continue;
        set_ways(volume, scenes, qualities);
        if ((code = paper_measure(papers, volume, scenes, qualities, WAYS, seconds, reports, err)) ||
            (code = add_blocking(volume, &blocks, err)))
            break;
        struct paper_row *row = paper_row_add(&iso, volume->name);
        for (int w = 0; w < DVR; w++)
            row->value[w] = 1.0 / seconds[w];
        row->value[4] = seconds[BASIC] / seconds[GEOMETRY];
        row->value[5] = rows[r].geometry / rows[r].basic;
        row->value[6] = seconds[BASIC] / seconds[REFINED];
        row->value[7] = rows[r].refined / rows[r].basic;
        row->value[8] = seconds[BASIC] / seconds[LEAPS];
        row = paper_row_add(&dvr, volume->name);
        row->value[0] = 1.0 / seconds[DVR];
        row->value[1] = 1.0 / seconds[SHADED];
        row->value[2] = seconds[SHADED] / seconds[DVR];
        row->value[3] = rows[r].dvr / rows[r].shaded;
        if (rows[r].kind != PAPER_BODY_SMALL)
            paper_volume_close(papers, rows[r].kind);
    }
    if (code)
        return code;
    const struct paper_table *tables[] = {&iso, &dvr, &blocks};
    return paper_tables_show(papers, tables, 3, err);
}
