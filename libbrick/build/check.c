/* A file held against itself. Every brick is read once; what neighbours must share is compared through hashes
 * of the overlapping slabs (48 bytes a brick), so the order of reading does not matter. */
#include <brick/build.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/threads.h>

#include "agree.h"
#include "lossy.h"

enum { BATCH_A_THREAD = 256 };

struct slabs {
    uint64_t low[3], high[3]; /* hash of the first and last 2 * border voxels along each axis */
};

struct checker {
    const struct brick_volume *volume;
    const struct brick_grid *grid;
    struct encoder *scratch; /* one a thread; payload holds the decoded brick */
    struct brick_scratch *read;
    struct tally *tallies;
    unsigned char **slab; /* one a thread: a slab's voxels */
    unsigned char **macrocells;
    struct tally_moments *batch_moments;
    uint64_t first_id;
    struct slabs *slabs; /* of one level's bricks */
    uint64_t slabs_first;
    double tolerance;          /* in stored values; 0: lossless */
    unsigned char **neighbour; /* lossy: one a thread, a decoded brick */
};

static int contradiction(const struct checker *c, uint64_t id, const struct brick_place *p, const char *what,
                         struct brick_error *err)
{
    return brick_fail_at(err, BRICK_ERR_FORMAT, brick_volume_entry(c->volume, id)->offset, id,
                         "%s: brick %llu (level %u, %llu,%llu,%llu): %s", brick_volume_path(c->volume),
                         (unsigned long long)id, p->level, (unsigned long long)p->at[0],
                         (unsigned long long)p->at[1], (unsigned long long)p->at[2], what);
}

/* A lossy file's neighbours hold slightly different voxels, so hashes will not do: compare with each of the
 * next bricks. */
static int check_overlaps(const struct checker *c, uint64_t id, const struct brick_place *p, unsigned worker,
                          struct brick_error *err)
{
    const struct brick_level *level = &c->grid->level[p->level];
    const uint64_t stride[3] = {1, level->bricks[0], level->bricks[0] * level->bricks[1]};
    size_t width = brick_type_bytes(c->grid->type);
    uint32_t thick = 2 * c->grid->border;
    for (int a = 0; a < 3; a++) {
        if (p->at[a] + 1 == level->bricks[a])
            continue;
        struct brick_place next;
        brick_grid_place(c->grid, id + stride[a], &next);
        int code = brick_volume_read(c->volume, id + stride[a], c->neighbour[worker], &c->read[worker], err);
        if (code)
            return code;
        uint32_t n[3] = {p->stored[0], p->stored[1], p->stored[2]}, skip[3] = {0, 0, 0};
        skip[a] = p->stored[a] - thick;
        n[a] = thick;
        for (uint32_t z = 0; z < n[2]; z++)
            for (uint32_t y = 0; y < n[1]; y++) {
                size_t mine = ((size_t)(z + skip[2]) * p->stored[1] + y + skip[1]) * p->stored[0] + skip[0],
                       its = ((size_t)z * next.stored[1] + y) * next.stored[0];
                if (!lossy_agree(c->grid->type, c->scratch[worker].payload + mine * width,
                                 c->neighbour[worker] + its * width, n[0], c->tolerance))
                    return contradiction(
                        c, id, p, "it disagrees with its neighbour by more than the file's tolerance", err);
            }
    }
    return BRICK_OK;
}

static int check_item(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct checker *c = context;
    uint64_t id = c->first_id + item;
    struct brick_place p;
    brick_grid_place(c->grid, id, &p);
    unsigned char *voxels = c->scratch[worker].payload;
    int code = brick_volume_read(c->volume, id, voxels, &c->read[worker], err);
    if (code)
        return code;
    struct brick_entry own;
    const char *wrong = agree_ranges(c->grid, &p, brick_volume_entry(c->volume, id), &c->scratch[worker],
                                     c->macrocells[worker], &own);
    if (wrong)
        return contradiction(c, id, &p, wrong, err);
    if (!agree_edge_repeats(c->grid, &p, voxels, c->tolerance))
        return contradiction(c, id, &p, "its border does not repeat the volume's edge", err);
    struct slabs *slabs = &c->slabs[id - c->slabs_first];
    if (c->tolerance > 0.0 && (code = check_overlaps(c, id, &p, worker, err)))
        return code;
    for (int a = 0; c->tolerance == 0.0 && a < 3; a++) {
        slabs->low[a] = agree_face(c->grid, &p, voxels, a, false, false, c->slab[worker]).hash;
        slabs->high[a] = agree_face(c->grid, &p, voxels, a, true, false, c->slab[worker]).hash;
    }
    if (p.level == 0) {
        uint32_t nonfinite = tally_brick(&c->tallies[worker], c->scratch[worker].kernels, c->grid, &p, voxels,
                                         c->macrocells[worker], &c->batch_moments[item]);
        if (nonfinite != brick_volume_entry(c->volume, id)->nonfinite)
            return contradiction(c, id, &p, "its count of NaN and Inf is not that of its voxels", err);
    }
    return BRICK_OK;
}

/* What a level's bricks must share with their neighbours and with the finer bricks below them. */
static int check_neighbours(const struct checker *c, uint32_t l, struct brick_error *err)
{
    const struct brick_level *level = &c->grid->level[l], *finer = l ? &c->grid->level[l - 1] : NULL;
    uint64_t end = level->first_brick + level->bricks[0] * level->bricks[1] * level->bricks[2];
    const uint64_t stride[3] = {1, level->bricks[0], level->bricks[0] * level->bricks[1]};
    for (uint64_t id = level->first_brick; id < end; id++) {
        struct brick_place p;
        brick_grid_place(c->grid, id, &p);
        for (int a = 0; a < 3; a++)
            if (c->tolerance == 0.0 && p.at[a] + 1 < level->bricks[a] &&
                c->slabs[id - c->slabs_first].high[a] != c->slabs[id + stride[a] - c->slabs_first].low[a])
                return contradiction(c, id, &p,
                                     "it disagrees with its neighbour about the voxels that both hold", err);
        if (!finer)
            continue;
        uint64_t from[3], to[3];
        for (int a = 0; a < 3; a++) {
            uint64_t step = level->scale[a] > finer->scale[a] ? 2 : 1;
            from[a] = p.at[a] * step;
            to[a] = from[a] + step < finer->bricks[a] ? from[a] + step : finer->bricks[a];
        }
        const struct brick_entry *mine = brick_volume_entry(c->volume, id);
        for (uint64_t z = from[2]; z < to[2]; z++)
            for (uint64_t y = from[1]; y < to[1]; y++)
                for (uint64_t x = from[0]; x < to[0]; x++) {
                    const struct brick_entry *e =
                        brick_volume_entry(c->volume, brick_grid_id(c->grid, l - 1, x, y, z));
                    if (e->min < mine->min || e->max > mine->max)
                        return contradiction(c, id, &p, "its range does not cover the finer bricks below it",
                                             err);
                }
    }
    return BRICK_OK;
}

static int check_stats(const struct checker *c, unsigned threads, const struct tally_moments *moments,
                       struct brick_error *err)
{
    const struct brick_stats *s = brick_volume_stats(c->volume);
    const struct brick_level *level = &c->grid->level[0];
    double min = INFINITY, max = -INFINITY;
    for (uint64_t id = 0; id < level->bricks[0] * level->bricks[1] * level->bricks[2]; id++) {
        min = fmin(min, (double)brick_volume_entry(c->volume, id)->min);
        max = fmax(max, (double)brick_volume_entry(c->volume, id)->max);
    }
    struct brick_stats own;
    tally_result(c->tallies, threads, c->grid->type, level->dims[0] * level->dims[1] * level->dims[2], min,
                 max, moments, &own);
    if (own.count != s->count || own.nonfinite != s->nonfinite || own.min != s->min || own.max != s->max ||
        own.mean != s->mean || own.variance != s->variance || own.first_bin != s->first_bin ||
        own.bins != s->bins || memcmp(own.histogram, s->histogram, s->bins * sizeof *s->histogram) != 0)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: the statistics are not those of its voxels",
                          brick_volume_path(c->volume));
    return BRICK_OK;
}

static int checker_init(struct checker *c, const struct brick_volume *volume, unsigned threads,
                        struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const uint64_t *n = grid->level[0].bricks;
    *c = (struct checker){.volume = volume, .grid = grid};
    if (brick_volume_tolerance(volume) > 0.0)
        c->tolerance = brick_codec_tolerance(grid->type, grid->slope, brick_volume_tolerance(volume));
    size_t payload = brick_grid_max_payload_bytes(grid);
    c->scratch = calloc(threads, sizeof *c->scratch);
    c->read = calloc(threads, sizeof *c->read);
    c->tallies = calloc(threads, sizeof *c->tallies);
    c->slab = calloc(threads, sizeof *c->slab);
    c->macrocells = calloc(threads, sizeof *c->macrocells);
    c->neighbour = calloc(threads, sizeof *c->neighbour);
    c->batch_moments = calloc((size_t)BATCH_A_THREAD * threads, sizeof *c->batch_moments);
    c->slabs = calloc(n[0] * n[1] * n[2], sizeof *c->slabs);
    bool ok = c->scratch && c->read && c->tallies && c->slab && c->macrocells && c->neighbour &&
              c->batch_moments && c->slabs;
    for (unsigned t = 0; ok && t < threads; t++) {
        int code = encoder_init(&c->scratch[t], kernels_best(), grid, err);
        if (code || (code = tally_init(&c->tallies[t], err)))
            return code;
        c->slab[t] = malloc(agree_face_bytes(grid));
        c->macrocells[t] = malloc(payload);
        c->neighbour[t] = c->tolerance > 0.0 ? malloc(payload) : NULL;
        ok = c->slab[t] && c->macrocells[t] && (c->neighbour[t] || c->tolerance == 0.0);
    }
    return ok ? BRICK_OK : brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", brick_volume_path(volume));
}

static void checker_finish(struct checker *c, unsigned threads)
{
    for (unsigned t = 0; t < threads; t++) {
        if (c->scratch)
            encoder_finish(&c->scratch[t]);
        if (c->read)
            brick_scratch_finish(&c->read[t]);
        if (c->tallies)
            tally_finish(&c->tallies[t]);
        if (c->slab)
            free(c->slab[t]);
        if (c->macrocells)
            free(c->macrocells[t]);
        if (c->neighbour)
            free(c->neighbour[t]);
    }
    free(c->scratch);
    free(c->read);
    free(c->tallies);
    free(c->slab);
    free(c->macrocells);
    free(c->neighbour);
    free(c->batch_moments);
    free(c->slabs);
}

int brick_check(const struct brick_volume *volume, unsigned threads,
                void (*progress)(void *context, uint64_t done, uint64_t bricks), void *progress_context,
                struct brick_error *err)
{
    struct brick_pool *pool;
    int code = brick_pool_create(&pool, threads, err);
    if (code)
        return code;
    threads = brick_pool_threads(pool);
    struct checker c;
    struct tally_moments moments = {0};
    code = checker_init(&c, volume, threads, err);
    for (uint32_t l = 0; !code && l < c.grid->levels; l++) {
        const struct brick_level *level = &c.grid->level[l];
        uint64_t id = level->first_brick, end = id + level->bricks[0] * level->bricks[1] * level->bricks[2];
        c.slabs_first = id;
        while (!code && id < end) {
            uint64_t n =
                end - id < (uint64_t)BATCH_A_THREAD * threads ? end - id : (uint64_t)BATCH_A_THREAD * threads;
            c.first_id = id;
            code = brick_pool_run(pool, n, check_item, &c, err);
            for (uint64_t i = 0; !code && l == 0 && i < n; i++)
                tally_merge_moments(&moments, &c.batch_moments[i]);
            id += n;
            if (progress)
                progress(progress_context, id, c.grid->bricks);
        }
        if (!code)
            code = check_neighbours(&c, l, err);
    }
    if (!code)
        code = check_stats(&c, threads, &moments, err);
    checker_finish(&c, threads);
    brick_pool_destroy(&pool);
    return code;
}
