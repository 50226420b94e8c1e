/* The conversion: one thread reads ahead (feed.c), the pool encodes (pyramid.c, encode.c), one thread writes
 * in order (drain.c). What each may hold is planned beforehand (plan.c). The file does not depend on any of
 * it. */
#include <brick/build.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <brick/threads.h>
#include <brick/writer.h>

#include "checkpoint.h"
#include "convert.h"
#include "drain.h"
#include "feed.h"
#include "identity.h"
#include "kept.h"
#include "pyramid.h"

const struct brick_build_params brick_build_defaults = {
    .edge = 32,
    .border = 2,
    .macrocell = 8,
    .codec = BRICK_CODEC_LZ4,
    .codec_level = 1,
    .memory_bytes = (uint64_t)512 << 20,
};

struct builder {
    struct brick_grid grid;
    struct brick_build_params params;
    struct plan plan;
    struct brick_pool *pool;
    struct brick_writer *writer;
    struct feed feed;
    struct drain drain;
    struct pyramid pyramid;
    struct kept kept;
    struct checkpoint checkpoint;
    unsigned threads;
    struct encoder *encoders;      /* one a thread */
    struct tally *tallies;         /* one a thread */
    struct costs *costs;           /* one a thread */
    struct brick_scratch *scratch; /* one a thread: stored bytes of bricks that are kept */
};

/* A brick as another file has it. Level 0's count for the statistics all the same. */
static int keep_brick(struct builder *b, uint64_t id, struct encoded *out, unsigned worker,
                      struct brick_error *err)
{
    struct encoder *e = &b->encoders[worker];
    struct brick_place place;
    brick_grid_place(&b->grid, id, &place);
    *out = (struct encoded){.id = id,
                            .ready = out->ready,
                            .level0 = place.level == 0,
                            .entry = *brick_volume_entry(b->params.keep_from, id),
                            .payload = out->payload};
    out->bytes = out->entry.bytes;
    int code = brick_volume_read(b->params.keep_from, id, e->payload, &b->scratch[worker], err);
    if (!code && out->bytes > brick_codec_bound(b->params.codec, brick_grid_max_payload_bytes(&b->grid)))
        code = brick_fail_at(err, BRICK_ERR_FORMAT, BRICK_NO_OFFSET, id,
                             "brick %llu: %zu bytes are too many for a payload", (unsigned long long)id,
                             out->bytes);
    if (code)
        return code;
    if (out->bytes)
        memcpy(out->payload, b->scratch[worker].data, out->bytes);
    if (out->level0)
        out->entry.nonfinite =
            tally_brick(&b->tallies[worker], e->kernels, &b->grid, &place, e->payload,
                        e->payload + brick_place_voxel_bytes(&b->grid, &place), &out->moments);
    return BRICK_OK;
}

static int encode_one(void *context, const struct window *window, uint64_t id, uint64_t ticket,
                      unsigned worker, struct brick_error *err)
{
    struct builder *b = context;
    uint64_t start = brick_now_ns();
    struct encoded *out = drain_slot(&b->drain, ticket);
    b->costs[worker].wait_write_ns += brick_now_ns() - start;
    if (!out)
        return drain_flush(&b->drain, ticket, err);
    int code = b->params.keep && b->params.keep[id]
                   ? keep_brick(b, id, out, worker, err)
                   : encode_brick(&b->encoders[worker], &b->grid, window, id, b->params.codec,
                                  b->params.codec_level, &b->tallies[worker], out, &b->costs[worker], err);
    if (!code)
        drain_ready(&b->drain, ticket);
    return code;
}

static int create_writer(struct builder *b, const struct brick_source *source, const char *path,
                         struct brick_error *err)
{
    if (!source->state)
        return b->params.resume
                   ? brick_fail(err, BRICK_ERR_ARGUMENT,
                                "%s: cannot be resumed: this source does not say whether it has changed",
                                path)
                   : brick_writer_create(&b->writer, path, &b->grid, err);
    char *identity = identity_text(&b->grid, source, &b->params);
    int code =
        identity ? brick_writer_create_journaled(&b->writer, path, &b->grid, identity, b->params.resume, err)
                 : brick_fail(err, BRICK_ERR_MEMORY, "out of memory");
    free(identity);
    return code;
}

/* Memory first, threads last: a planned conversion that cannot have its memory fails before it has begun. */
static int builder_init(struct builder *b, struct brick_source *source, const char *path,
                        const struct brick_build_params *params, struct brick_error *err)
{
    memset(b, 0, sizeof *b);
    b->params = *params;
    bool lossy = params->tolerance > 0.0;
    if ((brick_codec_is_lossy(params->codec) != lossy && !(params->keep && lossy)) ||
        isinf(params->tolerance))
        return brick_fail(err, BRICK_ERR_ARGUMENT,
                          "codec %s with a tolerance of %g: only zfp takes one, and needs it",
                          brick_codec_name(params->codec), params->tolerance);
    b->threads = params->threads ? params->threads : brick_cores();
    if (b->threads > 256) { /* the pool's limit, before anything is reckoned with it */
        b->threads = 0;
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%u threads are more than 256", params->threads);
    }
    int code = brick_grid_init(&b->grid, convert_stored_type(source->type), &source->geometry, params->edge,
                               params->border, params->macrocell, err);
    if (code || (code = plan_make(&b->plan, &b->grid, source, params, b->threads, err)))
        return code;
    const struct kernels *kernels = params->plain ? kernels_plain() : kernels_best();
    size_t payload = brick_codec_bound(params->codec, brick_grid_max_payload_bytes(&b->grid));
    b->encoders = calloc(b->threads, sizeof *b->encoders);
    b->tallies = calloc(b->threads, sizeof *b->tallies);
    b->costs = aligned_alloc(_Alignof(struct costs), b->threads * sizeof *b->costs);
    b->scratch = calloc(b->threads, sizeof *b->scratch);
    if (!b->encoders || !b->tallies || !b->costs || !b->scratch)
        return brick_fail(err, BRICK_ERR_MEMORY, "out of memory");
    memset(b->costs, 0, b->threads * sizeof *b->costs);
    for (unsigned t = 0; t < b->threads; t++)
        if ((code = encoder_init(&b->encoders[t], kernels, &b->grid, err)) ||
            (code = tally_init(&b->tallies[t], err)))
            return code;
        else if (params->tolerance > 0.0)
            b->encoders[t].tolerance = brick_codec_tolerance(b->grid.type, b->grid.slope, params->tolerance);
    b->pyramid = (struct pyramid){.grid = &b->grid,
                                  .plan = &b->plan,
                                  .kernels = kernels,
                                  .nearest = params->nearest,
                                  .brick = encode_one,
                                  .context = b,
                                  .costs = b->costs};
    if ((code = drain_init(&b->drain, b->plan.slots, payload, err)) ||
        (code = feed_init(&b->feed, source, &b->grid, &b->plan, params->round_to_f32, err)) ||
        (code = pyramid_init(&b->pyramid, path, err)) || (code = create_writer(b, source, path, err)) ||
        (code = brick_pool_create(&b->pool, b->threads, err)) ||
        (code = drain_start(&b->drain, b->writer, err)))
        return code;
    b->pyramid.pool = b->pool;
    b->kept = (struct kept){.grid = &b->grid,
                            .writer = b->writer,
                            .pool = b->pool,
                            .drain = &b->drain,
                            .encoders = b->encoders,
                            .tallies = b->tallies,
                            .costs = b->costs};
    b->checkpoint = (struct checkpoint){.writer = b->writer,
                                        .pyramid = &b->pyramid,
                                        .drain = &b->drain,
                                        .tallies = b->tallies,
                                        .threads = b->threads};
    return BRICK_OK;
}

/* leave: what was done, for resuming; how many bricks that are. */
static uint64_t builder_finish(struct builder *b, bool leave)
{
    uint64_t left = 0;
    feed_finish(&b->feed);
    drain_finish(&b->drain);
    pyramid_finish(&b->pyramid);
    for (unsigned t = 0; t < b->threads; t++) {
        if (b->encoders)
            encoder_finish(&b->encoders[t]);
        if (b->tallies)
            tally_finish(&b->tallies[t]);
        if (b->scratch)
            brick_scratch_finish(&b->scratch[t]);
    }
    free(b->encoders);
    free(b->tallies);
    free(b->costs);
    free(b->scratch);
    if (b->writer && leave)
        left = brick_writer_leave(b->writer);
    brick_writer_destroy(&b->writer);
    brick_pool_destroy(&b->pool);
    return left;
}

/* What the encoding threads did, and waited for: known whenever they rest. */
static void report_work(const struct builder *b, struct brick_build_report *r)
{
    r->threads = b->threads;
    r->wait_read_ns = b->feed.wait_ns * b->threads;
    for (unsigned t = 0; t < b->threads; t++) {
        r->wait_write_ns += b->costs[t].wait_write_ns;
        for (int s = 0; s < BRICK_STAGES; s++) {
            r->stage[s].ns += b->costs[t].stage[s].ns;
            r->stage[s].bytes += b->costs[t].stage[s].bytes;
        }
    }
    r->stage[BRICK_STAGE_SPOOL] = b->pyramid.spool_cost;
}

static void report_costs(const struct builder *b, struct brick_build_report *r)
{
    report_work(b, r);
    r->memory_bytes = b->plan.memory_bytes;
    r->tiled = b->plan.boxes;
    r->stage[BRICK_STAGE_READ] = b->feed.cost;
    r->stage[BRICK_STAGE_WRITE] = b->drain.cost;
    r->spooled_bytes = b->pyramid.spool_cost.bytes / 2; /* written, then read with borders: about twice */
}

static void show_progress(const struct builder *b, uint64_t row)
{
    struct brick_build_report so_far = {0};
    uint64_t slices = b->grid.dims[2], z = (row + 1) * b->grid.edge;
    if (!b->params.progress)
        return;
    report_work(b, &so_far);
    b->params.progress(b->params.progress_context, z < slices ? z : slices, slices,
                       brick_build_limit(&so_far));
}

/* One tile of level 0. What is kept of it is taken first, unless a checkpoint has counted it. The source is
 * read from the first tile on whose voxels cannot be had from kept bricks: because some are missing, or
 * because the codec is lossy, and coarser levels are made from converted voxels; or because a checkpoint
 * covers it, when reading is quicker than decoding, and few rows are gone through again.
 */
static int run_tile(struct builder *b, const struct tile *tile, bool last_of_row, struct brick_error *err)
{
    const struct window *window;
    bool reading = b->feed.running, counted = tile->row < b->checkpoint.rows;
    uint64_t kept = counted ? 0 : kept_in_tile(&b->kept, tile);
    int code = BRICK_OK;
    if (!reading && (kept < tile_bricks(tile) || brick_codec_is_lossy(b->params.codec))) {
        if ((code = feed_start(&b->feed, tile, err)))
            return code;
        reading = true;
    }
    if (!reading)
        window = feed_lend(&b->feed, tile);
    else if ((code = feed_take(&b->feed, tile, &window, err)))
        return code;
    code = kept_take(&b->kept, tile, kept, reading ? NULL : window, b->pyramid.tickets, err);
    b->pyramid.tickets += kept;
    if (!code)
        code = pyramid_tile(&b->pyramid, tile, window, err);
    if (reading)
        feed_release(&b->feed, tile, last_of_row);
    return code;
}

static int run_row(struct builder *b, uint64_t row, struct brick_error *err)
{
    struct tile next = tile_first(&b->grid, b->plan.shape, 0, row);
    bool more = true;
    while (more) {
        struct tile tile = next;
        more = tile_next(&b->grid, b->plan.shape, &next);
        int code = run_tile(b, &tile, !more, err);
        if (code)
            return code;
    }
    return pyramid_row_done(&b->pyramid, 0, row, err);
}

/* What an interrupted conversion has left, and the last checkpoint that it holds. */
static int take_up(struct builder *b, struct brick_error *err)
{
    if (b->params.progress)
        b->params.progress(b->params.progress_context, 0, b->grid.dims[2], BRICK_STAGE_RESUME);
    int code = kept_check(&b->kept, err);
    if (code)
        return code;
    for (uint32_t l = 0; l < b->grid.levels; l++)
        b->pyramid.first_new[l] = b->grid.level[l].first_brick + brick_writer_kept(b->writer, l);
    return checkpoint_open(&b->checkpoint, err);
}

/* All of level 0, and with it all levels. */
static int run(struct builder *b, struct brick_error *err)
{
    struct checkpoint *c = &b->checkpoint;
    uint64_t rows = b->grid.level[0].bricks[2];
    int code = b->params.resume ? take_up(b, err) : BRICK_OK;
    for (uint64_t row = c->first; !code && row < rows; row++) {
        if ((code = run_row(b, row, err)))
            return code;
        if (row + 1 == c->rows)
            code = checkpoint_load_slices(c, err);
        else if (checkpoint_due(c, row + 1))
            code = checkpoint_save(c, row + 1, err);
        show_progress(b, row);
    }
    return code ? code : drain_flush(&b->drain, b->pyramid.tickets, err);
}

/* Of the file as it is now: constant bricks, and those that were there before. */
static void count_bricks(const struct builder *b, struct brick_build_report *r)
{
    r->bricks = b->grid.bricks;
    for (uint64_t id = 0; id < b->grid.bricks; id++)
        r->bricks_constant += brick_writer_entry(b->writer, id)->flags & BRICK_FLAG_CONSTANT ? 1 : 0;
    for (uint32_t l = 0; l < b->grid.levels; l++)
        r->bricks_kept += brick_writer_kept(b->writer, l);
    r->bricks_decoded = b->kept.decoded;
}

int brick_build(struct brick_source *source, const char *path, const struct brick_build_params *params,
                struct brick_build_report *report, struct brick_error *err)
{
    uint64_t start = brick_now_ns();
    struct builder b;
    struct brick_build_report r = {0};
    int code = builder_init(&b, source, path, params, err);
    if (code || (code = run(&b, err)))
        goto done;
    uint64_t clock = brick_now_ns(), voxels = b.grid.dims[0] * b.grid.dims[1] * b.grid.dims[2];
    struct brick_stats stats;
    tally_result(b.tallies, b.threads, b.grid.type, voxels, b.drain.min, b.drain.max, &b.drain.moments,
                 &stats);
    char codec[96] = "", *provenance = NULL;
    if (params->tolerance > 0.0 && !params->keep)
        snprintf(codec, sizeof codec, "codec: %s, no value off by more than %.17g\n",
                 brick_codec_name(params->codec), params->tolerance);
    if (asprintf(&provenance, "%s%s", source->provenance ? source->provenance : "", codec) < 0) {
        code = brick_fail(err, BRICK_ERR_MEMORY, "out of memory");
        goto done;
    }
    if (params->progress)
        params->progress(params->progress_context, b.grid.dims[2], b.grid.dims[2], BRICK_STAGE_FINISH);
    brick_writer_set_tolerance(b.writer, params->tolerance);
    code = brick_writer_finish(b.writer, &stats, provenance, &r.output_bytes, err);
    free(provenance);
    report_costs(&b, &r);
    uint64_t now = brick_now_ns();
    r.stage[BRICK_STAGE_FINISH] = (struct brick_build_cost){now - clock, r.output_bytes};
    r.source_bytes = b.feed.cost.bytes / brick_type_bytes(b.grid.type) * brick_type_bytes(source->type);
    r.input_bytes = voxels * brick_type_bytes(source->type);
    count_bricks(&b, &r);
    r.converted = source->type != b.grid.type;
    r.seconds = (double)(now - start) * 1e-9;
    if (report)
        *report = r;
done:;
    uint64_t left = builder_finish(&b, code == BRICK_ERR_IO || (code && params->resume));
    if (left && err) {
        struct brick_error why = *err;
        brick_fail_at(err, code, why.offset, why.brick,
                      "%.400s; %llu bricks wait in %.150s.part for --resume", why.message,
                      (unsigned long long)left, path);
    }
    return code;
}

const char *brick_build_stage_name(enum brick_build_stage stage)
{
    static const char *const names[BRICK_STAGES] = {"read",   "gather",     "ranges", "count", "compress",
                                                    "resume", "downsample", "spool",  "write", "finish"};
    return (unsigned)stage < BRICK_STAGES ? names[stage] : NULL;
}

enum brick_build_stage brick_build_limit(const struct brick_build_report *r)
{
    enum brick_build_stage busiest = BRICK_STAGE_GATHER;
    uint64_t worked = 0;
    for (int s = BRICK_STAGE_GATHER; s <= BRICK_STAGE_SPOOL; s++) {
        worked += r->stage[s].ns;
        if (r->stage[s].ns > r->stage[busiest].ns)
            busiest = (enum brick_build_stage)s;
    }
    uint64_t finish = r->stage[BRICK_STAGE_FINISH].ns * r->threads;
    if (r->wait_read_ns > worked && r->wait_read_ns >= r->wait_write_ns && r->wait_read_ns >= finish)
        return BRICK_STAGE_READ;
    if (r->wait_write_ns > worked && r->wait_write_ns >= finish)
        return BRICK_STAGE_WRITE;
    return finish > worked ? BRICK_STAGE_FINISH : busiest;
}
