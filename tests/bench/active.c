/* How long the active set of 10^6 bricks takes: the price of a new transfer function. The index is that of a
 * made-up CT scan: half the bricks air of one value, the others with ranges of every width. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <brick/active.h>
#include <brick/threads.h>
#include <brick/writer.h>

#include "../support/memory_source.h"

enum { BRICKS_AN_AXIS = 100, EDGE = 8, REPEATS = 15 };

static void fail(const struct brick_error *err)
{
    fprintf(stderr, "%s\n", err->message);
    exit(1);
}

static double uniform(uint64_t seed, uint64_t i)
{
    return (double)(noise64(seed, i) >> 11) * 0x1p-53;
}

static struct brick_volume *make_index(void)
{
    const uint64_t n = BRICKS_AN_AXIS * EDGE;
    struct brick_geometry geometry = {
        .dims = {n, n, n}, .affine = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .slope = 1.0};
    struct brick_grid grid;
    struct brick_error err = {0};
    struct brick_writer *writer = NULL;
    struct brick_volume *volume = NULL;
    const char *path = test_path("index.brick");
    if (brick_grid_init(&grid, BRICK_I16, &geometry, EDGE, 2, 4, &err) ||
        brick_writer_create(&writer, path, &grid, &err))
        fail(&err);
    for (uint64_t id = 0; id < grid.bricks; id++) {
        struct brick_entry entry = {.flags = BRICK_FLAG_CONSTANT, .mask = 1, .min = -1000, .max = -1000};
        if (uniform(1, id) < 0.5) {
            entry.min = (float)floor(-1000 + 2500 * uniform(2, id));
            entry.max = (float)floor(entry.min + exp2(11 * uniform(3, id)));
            entry.mask = entry.min < entry.max ? ~UINT64_C(0) : 1;
        }
        if (brick_writer_put(writer, id, &entry, NULL, 0, &err))
            fail(&err);
    }
    const uint64_t count = n * n * n;
    struct brick_stats stats = {.count = count,
                                .min = -1000,
                                .max = 3000,
                                .first_bin = 31768, /* -1000 */
                                .bins = 1,
                                .histogram = &count};
    uint64_t bytes;
    if (brick_writer_finish(writer, &stats, "", &bytes, &err) || brick_volume_open(&volume, path, &err))
        fail(&err);
    brick_writer_destroy(&writer);
    return volume;
}

static int ascending(const void *a, const void *b)
{
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

static void measure(const struct brick_volume *volume, const char *name,
                    const struct brick_active_query *query, uint8_t *states)
{
    double ms[REPEATS];
    uint64_t active = 0;
    for (int i = 0; i < REPEATS; i++) {
        uint64_t started = brick_now_ns();
        active = brick_active_set(volume, query, states);
        ms[i] = (double)(brick_now_ns() - started) * 1e-6;
    }
    qsort(ms, REPEATS, sizeof *ms, ascending);
    printf("%-12s %8llu active   best %6.2f ms   median %6.2f ms\n", name, (unsigned long long)active, ms[0],
           ms[REPEATS / 2]);
}

/* Sixteen narrow peaks: many intervals of support. */
static void add_peaks(struct brick_transfer_spec *spec, struct brick_transfer_point points[48])
{
    for (int i = 0; i < 48; i++)
        points[i] = (struct brick_transfer_point){-1000 + 60 * (i / 3) + 10 * (i % 3), 1, 1, 1,
                                                  i % 3 == 1 ? 0.5 : 0.0};
    *spec = (struct brick_transfer_spec){.points = points, .count = 48, .unit = 1.0};
}

int main(void)
{
    struct brick_volume *volume = make_index();
    const struct brick_grid *grid = brick_volume_grid(volume);
    struct brick_error err = {0};
    uint64_t bricks = grid->level[0].bricks[0] * grid->level[0].bricks[1] * grid->level[0].bricks[2];
    uint8_t *states = malloc(bricks);
    printf("%llu bricks, index of %.1f MB\n", (unsigned long long)bricks,
           (double)(bricks * sizeof(struct brick_entry)) * 1e-6);
    static const char *const names[] = {"ct-bone", "ct-skin", "mri", "16 peaks"};
    for (int i = 0; i < 4; i++) {
        struct brick_transfer_spec spec;
        struct brick_transfer_point points[48];
        struct brick_transfer *transfer = NULL;
        if (i == 3)
            add_peaks(&spec, points);
        else if (brick_transfer_builtin(names[i], &spec, &err))
            fail(&err);
        if (brick_transfer_create(&transfer, &spec, 1.0, (double[]){-1000, 3000}, &err))
            fail(&err);
        struct brick_active_query query = {.mode = BRICK_MODE_DVR, .transfer = transfer};
        measure(volume, names[i], &query, states);
        if (i == 0) {
            query.mode = BRICK_MODE_MIP;
            measure(volume, "ct-bone mip", &query, states);
        }
        brick_transfer_destroy(&transfer);
        if (i < 3)
            brick_transfer_spec_finish(&spec);
    }
    struct brick_active_query query = {.mode = BRICK_MODE_ISO, .isovalue = 300.0};
    measure(volume, "iso 300", &query, states);
    free(states);
    brick_volume_close(&volume);
    return 0;
}
