/* The conversion: slices from the source into the pyramid, rows of bricks out of it into the writer. Bricks
 * of a row are encoded in parallel, a batch at a time, and written in order: the file does not depend on the
 * threads. */
#include <brick/build.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>
#include <brick/threads.h>
#include <brick/writer.h>

#include "convert.h"
#include "encode.h"
#include "pyramid.h"

const struct brick_build_params brick_build_defaults = {
    .edge = 32,
    .border = 2,
    .macrocell = 8,
    .codec = BRICK_CODEC_LZ4,
    .codec_level = 5,
    .memory_bytes = (uint64_t)512 << 20,
};

enum { BATCH_A_THREAD = 16, STAGING_BYTES = 1 << 20 };

struct builder {
    struct brick_grid grid;
    struct brick_build_params params;
    struct brick_pool *pool;
    struct brick_writer *writer;
    struct pyramid pyramid;
    unsigned threads;
    struct encoder *encoders; /* one a thread */
    struct tally *tallies;    /* one a thread */
    struct encoded *batch;
    uint64_t batch_size;
    void *staging; /* source voxels on their way to f32; NULL when they need no conversion */
    uint64_t staging_bytes;

    const struct window *window; /* of the row being emitted */
    uint32_t level;
    uint64_t first_id;

    struct tally_moments moments;
    double min, max;
    uint64_t constant;
};

static int encode_item(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct builder *b = context;
    return encode_brick(&b->encoders[worker], &b->grid, b->window, b->first_id + item, b->params.codec,
                        b->params.codec_level, b->level ? NULL : &b->tallies[worker], &b->batch[item], err);
}

static int emit_row(void *context, uint32_t level, uint64_t bz, const struct window *window,
                    struct brick_error *err)
{
    struct builder *b = context;
    b->level = level;
    b->window = window;
    uint64_t id = brick_grid_id(&b->grid, level, 0, 0, bz),
             end = id + window->level->bricks[0] * window->level->bricks[1];
    while (id < end) {
        uint64_t n = end - id < b->batch_size ? end - id : b->batch_size;
        b->first_id = id;
        int code = brick_pool_run(b->pool, n, encode_item, b, err);
        for (uint64_t i = 0; !code && i < n; i++, id++) {
            struct encoded *e = &b->batch[i];
            if (level == 0) {
                tally_merge_moments(&b->moments, &e->moments);
                b->min = fmin(b->min, (double)e->entry.min);
                b->max = fmax(b->max, (double)e->entry.max);
            }
            b->constant += e->bytes == 0;
            code = brick_writer_put(b->writer, id, &e->entry, e->bytes ? e->payload : NULL, e->bytes, err);
        }
        if (code)
            return code;
    }
    return BRICK_OK;
}

static int builder_init(struct builder *b, struct brick_source *source,
                        const struct brick_build_params *params, uint64_t *memory_bytes,
                        struct brick_error *err)
{
    memset(b, 0, sizeof *b);
    b->params = *params;
    b->min = INFINITY;
    b->max = -INFINITY;
    int code = brick_grid_init(&b->grid, convert_stored_type(source->type), &source->geometry, params->edge,
                               params->border, params->macrocell, err);
    if (code || (code = brick_pool_create(&b->pool, params->threads, err)))
        return code;
    b->threads = brick_pool_threads(b->pool);
    size_t payload = brick_codec_bound(params->codec, brick_grid_max_payload_bytes(&b->grid));
    b->batch_size = (uint64_t)BATCH_A_THREAD * b->threads;
    uint64_t row = b->grid.level[0].bricks[0] * b->grid.level[0].bricks[1];
    if (b->batch_size > row)
        b->batch_size = row;
    uint64_t need = pyramid_bytes(&b->grid);
    if (source->type != b->grid.type) {
        b->staging_bytes = b->grid.dims[0] * b->grid.dims[1] * brick_type_bytes(source->type);
        if (b->staging_bytes < STAGING_BYTES)
            b->staging_bytes = STAGING_BYTES;
    }
    uint64_t rest = b->batch_size * (payload + sizeof *b->batch) +
                    b->threads * (encoder_bytes(&b->grid) + 65536 * sizeof(uint64_t)) +
                    b->grid.bricks * sizeof(struct brick_entry) + b->staging_bytes;
    if (!brick_add_u64(need, rest, &need) || need > params->memory_bytes)
        return brick_fail(
            err, BRICK_ERR_MEMORY,
            "slabs of %u slices and the index need %llu MiB, more than --memory %llu MiB allows",
            params->edge + 2 * params->border, (unsigned long long)(need / 1048576 + 1),
            (unsigned long long)(params->memory_bytes / 1048576));
    *memory_bytes = need;
    b->encoders = calloc(b->threads, sizeof *b->encoders);
    b->tallies = calloc(b->threads, sizeof *b->tallies);
    b->batch = calloc(b->batch_size, sizeof *b->batch);
    b->staging = b->staging_bytes ? malloc(b->staging_bytes) : NULL;
    if (!b->encoders || !b->tallies || !b->batch || (b->staging_bytes && !b->staging))
        return brick_fail(err, BRICK_ERR_MEMORY, "out of memory");
    for (unsigned t = 0; t < b->threads; t++)
        if ((code = encoder_init(&b->encoders[t], kernels_best(), &b->grid, err)) ||
            (code = tally_init(&b->tallies[t], err)))
            return code;
    for (uint64_t i = 0; i < b->batch_size; i++)
        if (!(b->batch[i].payload = malloc(payload)))
            return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a batch of bricks");
    return pyramid_init(&b->pyramid, &b->grid, b->pool, params->nearest, emit_row, b, err);
}

static void builder_finish(struct builder *b)
{
    pyramid_finish(&b->pyramid);
    for (uint64_t i = 0; b->batch && i < b->batch_size; i++)
        free(b->batch[i].payload);
    for (unsigned t = 0; t < b->threads; t++) {
        if (b->encoders)
            encoder_finish(&b->encoders[t]);
        if (b->tallies)
            tally_finish(&b->tallies[t]);
    }
    free(b->staging);
    free(b->batch);
    free(b->encoders);
    free(b->tallies);
    brick_writer_destroy(&b->writer);
    brick_pool_destroy(&b->pool);
}

/* Slices [z, z + count) to dst, in the stored type. */
static int read_slices(struct builder *b, struct brick_source *source, uint64_t z, uint64_t count,
                       unsigned char *dst, struct brick_error *err)
{
    if (!b->staging)
        return source->read(source, z, count, dst, err);
    size_t width = brick_type_bytes(source->type);
    uint64_t slice = source->geometry.dims[0] * source->geometry.dims[1];
    uint64_t most = b->staging_bytes / (slice * width);
    for (uint64_t done = 0; done < count;) {
        uint64_t n = count - done < most ? count - done : most;
        int code = source->read(source, z + done, n, b->staging, err);
        if (code || (code = convert_to_f32(source->type, b->staging, (float *)(void *)dst + done * slice,
                                           n * slice, b->params.round_to_f32, (z + done) * slice, err)))
            return code;
        done += n;
    }
    return BRICK_OK;
}

int brick_build(struct brick_source *source, const char *path, const struct brick_build_params *params,
                struct brick_build_report *report, struct brick_error *err)
{
    uint64_t start = brick_now_ns();
    struct builder b;
    struct brick_build_report r = {0};
    int code = builder_init(&b, source, params, &r.memory_bytes, err);
    if (code || (code = brick_writer_create(&b.writer, path, &b.grid, err)))
        goto done;
    uint64_t nz = b.grid.dims[2];
    for (uint64_t z = 0; z < nz;) {
        uint64_t count;
        void *room = pyramid_room(&b.pyramid, &count);
        if ((code = read_slices(&b, source, z, count, room, err)) ||
            (code = pyramid_push(&b.pyramid, count, err)))
            goto done;
        z += count;
        if (params->progress)
            params->progress(params->progress_context, z, nz);
    }
    uint64_t voxels = b.grid.dims[0] * b.grid.dims[1] * nz;
    struct brick_stats stats;
    tally_result(b.tallies, b.threads, b.grid.type, voxels, b.min, b.max, &b.moments, &stats);
    code = brick_writer_finish(b.writer, &stats, source->provenance ? source->provenance : "",
                               &r.output_bytes, err);
    r.input_bytes = voxels * brick_type_bytes(source->type);
    r.bricks = b.grid.bricks;
    r.bricks_constant = b.constant;
    r.converted = source->type != b.grid.type;
    r.seconds = (double)(brick_now_ns() - start) * 1e-9;
    if (report)
        *report = r;
done:
    builder_finish(&b);
    return code;
}
