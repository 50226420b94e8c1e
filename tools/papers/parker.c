/* Parker, Shirley, Livnat, Hansen and Sloan 1998: where a ray's time goes (table 1), more cores (table 2),
 * bricks and the hierarchy against one array (table 3). Their machine had up to 128 processors and the
 * Visible Woman; here a body of its size. Against extraction (table 4) compares `brick bench peers`. */
#include <math.h>
#include <stdio.h>

#include "../bench_isotrace.h"
#include "papers.h"
#include "table.h"

enum { SKIN, BONE, BONE_ABOVE, VIEWS };
static const struct {
    const char *name;
    int iso;
    double azimuth, elevation;
    double shares[3];  /* table 1, percent; NaN: not in it */
    double seconds[3]; /* table 3 */
} views[VIEWS] = {
    {"skin: front", 0, 0, 0, {55, 22, 23}, {1.41, 1.27, 0.53}},
    {"bone: front", 1, 0, 0, {66, 21, 13}, {2.35, 2.07, 0.52}},
    {"bone: from feet", 1, 0, -80, {NAN, NAN, NAN}, {26.1, 5.8, 0.62}},
};

static int measure(struct papers *papers, const struct paper_volume *volume, int view,
                   struct bench_isotrace *bench, struct brick_error *err)
{
    struct vr_scene scene;
    paper_scene(volume, BRICK_MODE_ISO, 0.0, false, &scene);
    scene.isovalue = volume->iso[views[view].iso];
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume->volume), views[view].azimuth,
                       views[view].elevation, 0.0, 0.0, 1.0);
    /* The orders other than the file's hold the whole level. */
    *bench = (struct bench_isotrace){
        .host_cache_bytes = UINT64_C(4) << 30, .threads = papers->renderer.threads, .frames = papers->frames};
    return bench_isotrace_measure(bench, volume->volume, &scene, err);
}

int paper_parker(struct papers *papers, struct brick_error *err)
{
    const struct paper_volume *volume = &papers->volume[PAPER_BODY_HUGE];
    struct paper_table shares = {
        .name = "parker-1",
        .title = "Parker et al. 1998, table 1: shares of a ray's time, percent (512x512x1734)",
        .column = {"traversal", "paper", "intersection", "paper", "shading", "paper", "frames/s"},
        .columns = 7,
        .paper = 1,
    };
    struct paper_table cores = {
        .name = "parker-2",
        .title = "Parker et al. 1998, table 2: speed-up with cores (512x512x1734, bone: front)",
        .column = {"frames/s", "speed-up", "paper"},
        .columns = 3,
        .ours = 1,
        .paper = 2,
    };
    struct paper_table orders = {
        .name = "parker-3",
        .title = "Parker et al. 1998, table 3: bricks and hierarchy against one array (512x512x1734)",
        .note = "initial: one array, cell after cell; bricks: cell after cell too; ratios to initial.",
        .column = {"initial s", "bricks s", "hierarchy s", "init/bricks", "paper", "init/hierar.", "paper"},
        .columns = 7,
        .ours = 5,
        .paper = 6,
    };
    int code = paper_volume_open(papers, PAPER_BODY_HUGE, err);
    for (int v = 0; v < VIEWS && !code; v++) {
        struct bench_isotrace b;
        if ((code = measure(papers, volume, v, &b, err)))
            break;
        const struct vr_iso_profile *p = &b.profile;
        const double share[3] = {bench_isotrace_share(p, p->traversal),
                                 bench_isotrace_share(p, p->intersection),
                                 bench_isotrace_share(p, p->shading)};
        struct paper_row *row = paper_row_add(&shares, views[v].name);
        for (int i = 0; i < 3; i++) {
            row->value[2 * i] = share[i];
            row->value[2 * i + 1] = views[v].shares[i];
        }
        row->value[6] = 1.0 / b.seconds[BENCH_HIERARCHY];
        row = paper_row_add(&orders, views[v].name);
        const double ours[3] = {b.seconds[BENCH_FLAT], b.seconds[BENCH_BRICKS], b.seconds[BENCH_HIERARCHY]};
        for (int i = 0; i < 3; i++)
            row->value[i] = ours[i];
        for (int i = 1; i < 3; i++) {
            row->value[1 + 2 * i] = ours[0] / ours[i];
            row->value[2 + 2 * i] = views[v].seconds[0] / views[v].seconds[i];
        }
        for (unsigned n = 0; n < b.cores && v == BONE; n++) {
            char label[32];
            snprintf(label, sizeof label, "%u", n + 1);
            row = paper_row_add(&cores, label);
            row->value[0] = 1.0 / b.core_seconds[n];
            row->value[1] = b.core_seconds[0] / b.core_seconds[n];
            if (n < 2)
                row->value[2] = n + 1.0; /* the paper's are linear up to 24 */
        }
    }
    if (code)
        return code;
    const struct paper_table *tables[] = {&shares, &cores, &orders};
    return paper_tables_show(papers, tables, 3, err);
}
