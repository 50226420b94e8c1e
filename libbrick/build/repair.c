/* Repair is a conversion whose source is what is left of level 0 (patch.c), and which takes over every
 * payload that is whole and describes what the new file holds. Over lost bricks no coarser brick is taken
 * over: it is made from level 0 as it is now, so that all levels agree. */
#include <brick/repair.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lossy.h"
#include "patch.h"

enum {
    SAMPLES = 8,   /* payloads that must come out the same for a codec's level to be believed */
    TRIES = 65536, /* bricks looked at for one thing */
};

struct repair {
    const struct brick_repair_params *params;
    struct brick_repair_report report;
    struct brick_volume *volume;
    const struct brick_grid *grid;
    struct salvage salvage;
    struct patch patch;
    struct brick_build_params build;
    unsigned char *keep; /* of each brick: the build takes it over */
};

static uint64_t level0_end(const struct brick_grid *grid)
{
    return grid->levels > 1 ? grid->level[1].first_brick : grid->bricks;
}

/* Coarser bricks whose voxels or ranges a lost brick's voxels are part of are not kept. */
static void touch(struct repair *r, const struct brick_loss *loss)
{
    const struct brick_grid *g = r->grid;
    int halvings[3] = {0, 0, 0};
    for (uint32_t l = 1; l < g->levels; l++) {
        const struct brick_level *level = &g->level[l];
        uint64_t from[3], to[3]; /* bricks whose stored voxels the lost core's are among */
        for (int a = 0; a < 3; a++) {
            halvings[a] += level->scale[a] > g->level[l - 1].scale[a];
            uint64_t first = loss->at[a] * g->edge, last = first + g->edge - 1;
            first >>= halvings[a];
            last >>= halvings[a];
            from[a] = first > g->border ? (first - g->border) / g->edge : 0;
            to[a] = (last + g->border) / g->edge + 1;
            to[a] = to[a] < level->bricks[a] ? to[a] : level->bricks[a];
        }
        for (uint64_t z = from[2]; z < to[2]; z++)
            for (uint64_t y = from[1]; y < to[1]; y++)
                for (uint64_t x = from[0]; x < to[0]; x++)
                    r->keep[brick_grid_id(g, l, x, y, z)] = 0;
    }
}

static int list_losses(struct repair *r, struct brick_error *err)
{
    int code = BRICK_OK;
    for (uint64_t id = 0; !code && id < r->grid->bricks; id++)
        r->keep[id] = r->salvage.state[id] == (SALVAGE_VOXELS | SALVAGE_ENTRY);
    for (uint64_t id = 0; !code && id < level0_end(r->grid); id++) {
        if (r->salvage.state[id] & SALVAGE_VOXELS)
            continue;
        struct brick_loss loss;
        if ((code = patch_lost(&r->patch, id, &loss, err)))
            break;
        touch(r, &loss);
        r->report.lost++;
        if (r->params->lost)
            r->params->lost(r->params->lost_context, &loss);
    }
    /* What a lossy file's coarser bricks are made of again is off, so their ranges are wider, and no brick
     * above them covers these but one that is made again as well. */
    for (uint64_t id = level0_end(r->grid); id < r->grid->bricks; id++) {
        struct brick_place place;
        brick_grid_place(r->grid, id, &place);
        r->report.rebuilt += !r->keep[id];
        if (!r->keep[id] && place.level + 1 < r->grid->levels && brick_volume_tolerance(r->volume) > 0.0)
            r->keep[agree_part(r->grid, &place).parent] = 0;
    }
    return code;
}

/* Read a brick that is whole and not constant, among `TRIES` from *id on: to worker 0. False: none. */
static bool next_payload(struct repair *r, uint64_t *id, struct brick_place *place)
{
    struct salvage_worker *w = &r->salvage.workers[0];
    for (uint64_t end = *id + TRIES; *id < r->grid->bricks && *id < end; (*id)++) {
        const struct brick_entry *e = brick_volume_entry(r->volume, *id);
        if (!(r->salvage.state[*id] & SALVAGE_VOXELS) || e->flags & BRICK_FLAG_CONSTANT ||
            brick_codec_is_lossy((enum brick_codec)e->codec))
            continue;
        brick_grid_place(r->grid, *id, place);
        if (!brick_volume_read(r->volume, *id, w->encoder.payload, &w->scratch, NULL))
            return true;
    }
    return false;
}

/* The codec is that of the bricks that are there, its level one that makes the same bytes of some of them. */
static int choose_codec(struct repair *r, struct brick_error *err)
{
    struct salvage_worker *w = &r->salvage.workers[0];
    size_t room = brick_codec_bound(BRICK_CODEC_ZSTD, brick_grid_max_payload_bytes(r->grid));
    unsigned char *again = malloc(room);
    if (!again)
        return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a payload");
    unsigned possible = 0x3fe; /* bit l: level l */
    struct brick_place place;
    uint64_t id = 0, stride = 1 + level0_end(r->grid) / (4 * SAMPLES);
    for (int found = 0; found < SAMPLES && possible & (possible - 1) && next_payload(r, &id, &place);
         found++, id += stride) {
        const struct brick_entry *e = brick_volume_entry(r->volume, id);
        struct brick_codec_shape shape = brick_codec_shape(r->grid, &place);
        if (r->build.tolerance == 0.0)
            r->build.codec = (enum brick_codec)e->codec;
        for (int level = 1; level <= 9; level++) {
            size_t bytes;
            if ((possible >> level & 1) &&
                (brick_codec_encode((enum brick_codec)e->codec, level, &shape, w->encoder.payload, again,
                                    room, &bytes, NULL) ||
                 bytes != e->bytes || memcmp(again, w->scratch.data, bytes) != 0))
                possible &= ~(1u << level);
        }
    }
    if (possible)
        r->build.codec_level = __builtin_ctz(possible);
    free(again);
    return BRICK_OK;
}

/* Was a coarser level made of means or of voxels 2i? The first brick whose parent could only be one of them
 * tells. */
static void choose_downsample(struct repair *r)
{
    struct salvage *s = &r->salvage;
    struct salvage_worker *w = &s->workers[0];
    const struct kernels *k = w->encoder.kernels;
    struct brick_place place, parent;
    r->build.nearest = r->params->downsample == BRICK_DOWNSAMPLE_NEAREST;
    if (r->params->downsample != BRICK_DOWNSAMPLE_AS_FOUND || r->grid->levels < 2)
        return;
    for (uint64_t id = 0; next_payload(r, &id, &place) && place.level + 1 < r->grid->levels; id++) {
        struct agree_part part = agree_part(r->grid, &place);
        size_t n = (size_t)part.size[0] * part.size[1] * part.size[2];
        if (!(s->state[part.parent] & SALVAGE_VOXELS))
            continue;
        agree_make_part(k, r->grid, &place, w->encoder.payload, false, w->part[0], w->coarse);
        agree_make_part(k, r->grid, &place, w->encoder.payload, true, w->part[1], w->coarse);
        brick_grid_place(r->grid, part.parent, &parent);
        if (brick_volume_read(r->volume, part.parent, w->encoder.payload, &w->scratch, NULL))
            continue;
        agree_take_part(r->grid, &parent, w->encoder.payload, &part, w->coarse);
        bool mean = lossy_agree(r->grid->type, w->part[0], w->coarse, n, s->tolerance),
             nearest = lossy_agree(r->grid->type, w->part[1], w->coarse, n, s->tolerance);
        if (mean == nearest)
            continue;
        r->build.nearest = nearest;
        return;
    }
    r->report.guessed_downsample = r->report.rebuilt > 0;
}

static void show_building(void *context, uint64_t done, uint64_t all, enum brick_build_stage limit)
{
    const struct brick_repair_params *params = ((const struct repair *)context)->params;
    (void)limit;
    if (params->progress)
        params->progress(params->progress_context, done, all);
}

static int choose(struct repair *r, struct brick_error *err)
{
    const struct brick_grid *g = r->grid;
    r->build = brick_build_defaults;
    r->build.edge = g->edge;
    r->build.border = g->border;
    r->build.macrocell = g->macrocell;
    r->build.threads = r->salvage.threads;
    r->build.keep_from = r->volume;
    r->build.keep = r->keep;
    r->build.progress = show_building;
    r->build.progress_context = r;
    r->build.tolerance = r->report.tolerance_was = brick_volume_tolerance(r->volume);
    if (r->build.tolerance > 0.0) {
        /* Coarser bricks are made of voxels that are off already. */
        if (r->report.rebuilt)
            r->build.tolerance = fmin(2.0 * r->build.tolerance, DBL_MAX);
        r->build.codec = LOSSY_FALLBACK;
    }
    r->report.tolerance = r->build.tolerance;
    choose_downsample(r);
    return choose_codec(r, err);
}

static int salvage_all(struct repair *r, struct brick_error *err)
{
    struct salvage *s = &r->salvage;
    s->progress = r->params->progress;
    s->progress_context = r->params->progress_context;
    int code = salvage_read(s, err);
    if (!code && s->damage.index && s->tolerance == 0.0 && brick_volume_tolerance(r->volume) == 0.0)
        code = salvage_find(s, err);
    r->report.unconfirmed = s->unconfirmed;
    return code;
}

int brick_repair(const char *path, const char *to, const struct brick_repair_params *params,
                 struct brick_repair_report *report, struct brick_error *err)
{
    struct repair r = {.params = params};
    struct brick_build_report built;
    uint64_t used = 0;
    unsigned threads = params->threads ? params->threads : brick_cores();
    int code = brick_volume_open_damaged(&r.volume, path, params->memory_bytes / 2, &r.report.damage, err);
    if (code)
        goto done;
    r.grid = brick_volume_grid(r.volume);
    r.report.bricks = r.grid->bricks;
    used = r.grid->bricks * (sizeof(struct brick_entry) + 1) + salvage_bytes(r.grid, threads) +
           patch_bytes(r.grid);
    if (r.report.damage.index)
        used += salvage_find_bytes(r.grid);
    if (used >= params->memory_bytes) {
        code = brick_fail(
            err, BRICK_ERR_MEMORY, "%s: %llu MiB are needed to read it, more than --memory %llu MiB", path,
            (unsigned long long)(used / 1048576 + 1), (unsigned long long)(params->memory_bytes / 1048576));
        goto done;
    }
    if (!(r.keep = calloc(r.grid->bricks, 1))) {
        code = brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
        goto done;
    }
    if ((code = salvage_init(&r.salvage, r.volume, &r.report.damage, threads, err)) ||
        (code = salvage_all(&r, err)) || (code = patch_init(&r.patch, &r.salvage, err)) ||
        (code = list_losses(&r, err)) || (code = choose(&r, err)))
        goto done;
    r.build.memory_bytes = params->memory_bytes - used;
    code = brick_build(&r.patch.base, to, &r.build, &built, err);
    r.report.output_bytes = code ? 0 : built.output_bytes;
    if (!code)
        *report = r.report;
done:
    patch_finish(&r.patch);
    salvage_finish(&r.salvage);
    free(r.keep);
    brick_volume_close(&r.volume);
    return code;
}
