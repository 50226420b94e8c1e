/* Synthetic volumes as a source: any size, streamed, the same bytes for every thread count and slab size.
 *
 * The field is asked for spans of a row (synth.h); this file spreads rows over threads, rounds to the voxel
 * type and states the geometry: 1 mm voxels, index axes along LPS, the first voxel at the origin. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>
#include <brick/threads.h>

#include "synth.h"

static const struct synth_field fields[] = {
    {"marschner-lobb", NULL, NULL, synth_marschner_lobb_span},
    {"ct", synth_ct_init, synth_ct_slice, synth_ct_span},
    {"ramp", NULL, NULL, synth_ramp_span},
    {"checker", NULL, NULL, synth_checker_span},
    {"constant", synth_constant_init, NULL, synth_constant_span},
    {"shells", NULL, NULL, synth_shells_span},
};

const char *const fmt_synth_names[] = {"marschner-lobb", "ct", "ramp", "checker", "constant", "shells", NULL};

struct synth_source {
    struct brick_source source;
    struct synth_volume volume;
    const struct synth_field *field;
    struct brick_pool *pool;
    char provenance[96];
    char state[64];
};

/* Clamp and round to nearest. f32 is stored as it is. */
static void store_span(const struct synth_volume *volume, const float *values, unsigned n, void *dst)
{
    const float lo = (float)volume->lo, hi = (float)volume->hi;
    int32_t rounded[SYNTH_SPAN];
    if (volume->type == BRICK_F32) {
        memcpy(dst, values, n * sizeof(float));
        return;
    }
    for (unsigned i = 0; i < n; i++) {
        float v = values[i] > lo ? values[i] : lo;
        v = v < hi ? v : hi;
        rounded[i] = (int32_t)(v < 0 ? v - 0.5f : v + 0.5f);
    }
    switch (volume->type) {
    case BRICK_U8:
        for (unsigned i = 0; i < n; i++)
            ((uint8_t *)dst)[i] = (uint8_t)rounded[i];
        break;
    case BRICK_I8:
        for (unsigned i = 0; i < n; i++)
            ((int8_t *)dst)[i] = (int8_t)rounded[i];
        break;
    case BRICK_U16:
        for (unsigned i = 0; i < n; i++)
            ((uint16_t *)dst)[i] = (uint16_t)rounded[i];
        break;
    default: /* i16: the only stored type left */
        for (unsigned i = 0; i < n; i++)
            ((int16_t *)dst)[i] = (int16_t)rounded[i];
        break;
    }
}

/* One piece of a read: a group of rows of one slice. */
struct read_job {
    const struct synth_source *synth;
    uint64_t z;
    uint64_t rows_per_item, items_per_slice;
    uint8_t *dst;
};

static int read_rows(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    (void)worker, (void)err;
    const struct read_job *job = context;
    const struct synth_volume *volume = &job->synth->volume;
    const struct synth_field *field = job->synth->field;
    const uint64_t nx = volume->dims[0], ny = volume->dims[1];
    const size_t voxel = brick_type_bytes(volume->type);
    const uint64_t slice_at = item / job->items_per_slice;
    const uint64_t y_first = item % job->items_per_slice * job->rows_per_item;
    const uint64_t y_end = ny - y_first < job->rows_per_item ? ny : y_first + job->rows_per_item;
    struct synth_slice slice;
    slice.z = job->z + slice_at;
    slice.parts = 0;
    if (field->slice)
        field->slice(volume, &slice);
    for (uint64_t y = y_first; y < y_end; y++)
        for (uint64_t x = 0; x < nx; x += SYNTH_SPAN) {
            float values[SYNTH_SPAN];
            const unsigned n = nx - x < SYNTH_SPAN ? (unsigned)(nx - x) : SYNTH_SPAN;
            field->span(volume, &slice, x, n, y, values);
            store_span(volume, values, n, job->dst + ((slice_at * ny + y) * nx + x) * voxel);
        }
    return BRICK_OK;
}

static int synth_read(struct brick_source *source, uint64_t z, uint64_t count, void *dst,
                      struct brick_error *err)
{
    struct synth_source *synth = (struct synth_source *)source;
    const uint64_t *dims = synth->volume.dims;
    if (z > dims[2] || count > dims[2] - z)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "synth: slices %llu to %llu of %llu",
                          (unsigned long long)z, (unsigned long long)(z + count),
                          (unsigned long long)dims[2]);
    /* Enough voxels an item to drown its overhead, few enough to share one slice between threads. */
    const uint64_t voxels_per_item = 1 << 15;
    struct read_job job = {.synth = synth, .z = z, .dst = dst};
    job.rows_per_item = dims[0] < voxels_per_item ? voxels_per_item / dims[0] : 1;
    job.items_per_slice = (dims[1] - 1) / job.rows_per_item + 1;
    return brick_pool_run(synth->pool, count * job.items_per_slice, read_rows, &job, err);
}

static void synth_destroy(struct brick_source *source)
{
    struct synth_source *synth = (struct synth_source *)source;
    brick_pool_destroy(&synth->pool);
    synth_ct_finish(&synth->volume);
    free(synth);
}

static int check_params(const struct fmt_synth_params *params, struct brick_error *err)
{
    uint64_t voxels, bytes;
    if (params->type >= BRICK_TYPE_STORED_COUNT)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "synth: the type must be u8, i8, u16, i16 or f32");
    for (int i = 0; i < 3; i++)
        if (params->dims[i] < 1 || params->dims[i] > BRICK_MAX_DIM)
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "synth: an axis of %llu voxels; 1 to %llu are possible",
                              (unsigned long long)params->dims[i], (unsigned long long)BRICK_MAX_DIM);
    if (!brick_mul3_u64(params->dims[0], params->dims[1], params->dims[2], &voxels) ||
        !brick_mul_u64(voxels, brick_type_bytes(params->type), &bytes) || bytes > INT64_MAX)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "synth: %llux%llux%llu voxels are more than 2^63 bytes",
                          (unsigned long long)params->dims[0], (unsigned long long)params->dims[1],
                          (unsigned long long)params->dims[2]);
    return BRICK_OK;
}

int fmt_synth_open(struct brick_source **source, const char *name, const struct fmt_synth_params *params,
                   struct brick_error *err)
{
    static const double lowest[BRICK_TYPE_STORED_COUNT] = {0, -128, 0, -32768, 0};
    static const double highest[BRICK_TYPE_STORED_COUNT] = {255, 127, 65535, 32767, 1};
    struct synth_source *synth = NULL;
    const struct synth_field *field = NULL;
    *source = NULL;
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
        if (strcmp(fields[i].name, name) == 0)
            field = &fields[i];
    if (!field)
        return brick_fail(
            err, BRICK_ERR_ARGUMENT,
            "synth: no field '%s'; there are marschner-lobb, ct, ramp, checker, constant and shells", name);
    int result = check_params(params, err);
    if (result)
        return result;
    synth = calloc(1, sizeof *synth);
    if (!synth)
        return brick_fail(err, BRICK_ERR_MEMORY, "synth: out of memory");
    struct synth_volume *volume = &synth->volume;
    memcpy(volume->dims, params->dims, sizeof volume->dims);
    volume->type = params->type;
    volume->seed = params->seed;
    volume->value = params->value;
    volume->lo = lowest[params->type];
    volume->hi = highest[params->type];
    volume->slope = 1;
    synth->field = field;
    if (field->init && (result = field->init(volume, err)))
        goto fail;
    if ((result = brick_pool_create(&synth->pool, params->threads, err)))
        goto fail;
    snprintf(synth->provenance, sizeof synth->provenance, "synth: %s\nseed: %llu\n", field->name,
             (unsigned long long)params->seed);
    struct brick_geometry *geometry = &synth->source.geometry;
    memcpy(geometry->dims, params->dims, sizeof geometry->dims);
    for (int i = 0; i < 3; i++)
        geometry->affine[i][i] = 1;
    geometry->slope = volume->slope;
    geometry->intercept = volume->intercept;
    synth->source.type = params->type;
    synth->source.provenance = synth->provenance;
    snprintf(synth->state, sizeof synth->state, "synthetic, value %.17g", params->value);
    synth->source.state = synth->state;
    synth->source.read = synth_read;
    synth->source.destroy = synth_destroy;
    *source = &synth->source;
    return BRICK_OK;
fail:
    synth_destroy(&synth->source);
    return result;
}
