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

static void set_way(const struct paper_volume *volume, size_t way, struct vr_scene *scene,
                    struct vr_quality *quality)
{
    paper_scene(volume,
                way < DVR    ? BRICK_MODE_ISO
                : way == DVR ? BRICK_MODE_DVR
                             : BRICK_MODE_SHADED,
                0.0, false, scene);
    quality->step_vox = way == REFINED ? 5.0 : 1.0;
    quality->refinements = 6;
    quality->skip = way == LEAPS;
    quality->setup = way == BASIC || way == LEAPS ? VR_SETUP_BOX : VR_SETUP_GEOMETRY;
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
        struct paper_time times[WAYS];
        if ((code = paper_measure(papers, rows[r].kind, set_way, WAYS, times, err)) || !volume->volume ||
            (code = add_blocking(volume, &blocks, err)))
            continue;
        struct paper_row *row = paper_row_add(&iso, volume->name);
        for (int w = 0; w < DVR; w++)
            row->value[w] = 1.0 / times[w].seconds;
        row->value[4] = times[BASIC].seconds / times[GEOMETRY].seconds;
        row->value[5] = rows[r].geometry / rows[r].basic;
        row->value[6] = times[BASIC].seconds / times[REFINED].seconds;
        row->value[7] = rows[r].refined / rows[r].basic;
        row->value[8] = times[BASIC].seconds / times[LEAPS].seconds;
        row = paper_row_add(&dvr, volume->name);
        row->value[0] = 1.0 / times[DVR].seconds;
        row->value[1] = 1.0 / times[SHADED].seconds;
        row->value[2] = times[SHADED].seconds / times[DVR].seconds;
        row->value[3] = rows[r].dvr / rows[r].shaded;
        if (rows[r].kind != PAPER_BODY_SMALL)
            paper_volume_close(papers, rows[r].kind);
    }
    if (code)
        return code;
    const struct paper_table *tables[] = {&iso, &dvr, &blocks};
    return paper_tables_show(papers, tables, 3, err);
}
