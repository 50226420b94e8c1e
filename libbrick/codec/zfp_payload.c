/* A zfp stream of a brick's voxels, block by block, with zfp's own header in front. Integers travel as
 * float32, which holds all of 16 bits, and are rounded and clamped on the way back.
 *
 * zfp does not bound its reads and writes. Invariants that do: a block takes at most SLACK bytes; before each
 * block the position is inside the stream, which lies in a buffer with SLACK bytes more; so a hostile stream
 * ends in an error, and a stream that outgrows its room is given up.
 *
 * zfp's accuracy is a bound for the worst block; real errors are several times smaller. Since every voxel is
 * compared with the decoded one anyway, encoding begins with a coarser accuracy and halves it until the bound
 * holds. */
#include "zfp_payload.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zfp.h>

enum {
    SLACK = (ZFP_MAX_BITS + ZFP_HEADER_MAX_BITS) / 8 + 64,
    BOLD = 4, /* accuracy tried first, in tolerances */
};
/* Below this, zfp's scaling of a block of tiny values would overflow float32. */
static const double least_tolerance = 0x1p-80;

const bool zfp_payload_built = true;

struct block {
    uint32_t at[3];
    size_t size[3]; /* 1..4 */
};

/* Block number i, x fastest; false behind the last. */
static bool block_at(const struct brick_codec_shape *shape, size_t i, struct block *b)
{
    size_t n[3] = {(shape->voxels[0] + 3) / 4, (shape->voxels[1] + 3) / 4, (shape->voxels[2] + 3) / 4};
    const size_t at[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
    for (int a = 0; a < 3; a++) {
        b->at[a] = (uint32_t)(4 * at[a]);
        size_t rest = shape->voxels[a] - b->at[a];
        b->size[a] = rest < 4 ? rest : 4;
    }
    return at[2] < n[2];
}

static float rounded(float v, float lowest, float highest)
{
    v = rintf(v);
    return v >= lowest ? v <= highest ? v : highest : lowest; /* NaN: lowest */
}

/* For every voxel i of a block, float f: do. */
#define EACH(T, DO)                                                                                          \
    do {                                                                                                     \
        for (size_t z = 0; z < b->size[2]; z++)                                                              \
            for (size_t y = 0; y < b->size[1]; y++)                                                          \
                for (size_t x = 0; x < b->size[0]; x++) {                                                    \
                    T *v = (T *)voxels +                                                                     \
                           ((b->at[2] + z) * shape->voxels[1] + b->at[1] + y) * shape->voxels[0] +           \
                           b->at[0] + x;                                                                     \
                    float *f = &floats[16 * z + 4 * y + x];                                                  \
                    DO;                                                                                      \
                }                                                                                            \
    } while (0)

static void get_block(const struct brick_codec_shape *shape, const struct block *b, const void *voxels,
                      float floats[64])
{
    switch (shape->type) {
    case BRICK_U8:
        EACH(const uint8_t, *f = (float)*v);
        break;
    case BRICK_I8:
        EACH(const int8_t, *f = (float)*v);
        break;
    case BRICK_U16:
        EACH(const uint16_t, *f = (float)*v);
        break;
    case BRICK_I16:
        EACH(const int16_t, *f = (float)*v);
        break;
    default:
        EACH(const float, *f = *v);
        break;
    }
}

static void put_block(const struct brick_codec_shape *shape, const struct block *b, float floats[64],
                      void *voxels)
{
    switch (shape->type) {
    case BRICK_U8:
        EACH(uint8_t, *v = (uint8_t)rounded(*f, 0.0f, 255.0f));
        break;
    case BRICK_I8:
        EACH(int8_t, *v = (int8_t)rounded(*f, -128.0f, 127.0f));
        break;
    case BRICK_U16:
        EACH(uint16_t, *v = (uint16_t)rounded(*f, 0.0f, 65535.0f));
        break;
    case BRICK_I16:
        EACH(int16_t, *v = (int16_t)rounded(*f, -32768.0f, 32767.0f));
        break;
    default:
        EACH(float, *v = *f);
        break;
    }
}
#undef EACH

/* zfp's objects around a buffer that has SLACK bytes more than the stream may take. */
struct stream {
    unsigned char *buffer;
    size_t bytes;
    bitstream *bits;
    zfp_stream *zfp;
    zfp_field *field;
};

static int stream_init(struct stream *s, size_t bytes, struct brick_error *err)
{
    *s = (struct stream){.buffer = calloc(1, bytes + SLACK), .bytes = bytes};
    s->bits = s->buffer ? stream_open(s->buffer, bytes + SLACK) : NULL;
    s->zfp = s->bits ? zfp_stream_open(s->bits) : NULL;
    s->field = zfp_field_alloc();
    return s->zfp && s->field ? BRICK_OK : brick_fail(err, BRICK_ERR_MEMORY, "out of memory for zfp");
}

static void stream_finish(struct stream *s)
{
    if (s->field)
        zfp_field_free(s->field);
    if (s->zfp)
        zfp_stream_close(s->zfp);
    if (s->bits)
        stream_close(s->bits);
    free(s->buffer);
}

/* False when the stream would take all of its room. */
static bool encode_blocks(struct stream *s, const struct brick_codec_shape *shape, double accuracy,
                          const void *voxels, size_t *written)
{
    zfp_stream_rewind(s->zfp);
    zfp_stream_set_accuracy(s->zfp, accuracy);
    zfp_field_set_type(s->field, zfp_type_float);
    zfp_field_set_size_3d(s->field, shape->voxels[0], shape->voxels[1], shape->voxels[2]);
    if (!zfp_write_header(s->zfp, s->field, ZFP_HEADER_FULL))
        return false;
    struct block b;
    float floats[64];
    for (size_t i = 0; block_at(shape, i, &b); i++) {
        if (stream_wtell(s->bits) >= 8 * s->bytes)
            return false;
        get_block(shape, &b, voxels, floats);
        zfp_encode_partial_block_strided_float_3(s->zfp, floats, b.size[0], b.size[1], b.size[2], 1, 4, 16);
    }
    zfp_stream_flush(s->zfp);
    *written = stream_size(s->bits);
    return *written < s->bytes;
}

/* Everything of the stream but the padding of its last word is read, and nothing behind it. */
static bool decode_blocks(struct stream *s, const struct brick_codec_shape *shape, size_t bytes, void *voxels)
{
    zfp_stream_rewind(s->zfp);
    if (!zfp_read_header(s->zfp, s->field, ZFP_HEADER_FULL) || s->field->type != zfp_type_float ||
        s->field->nx != shape->voxels[0] || s->field->ny != shape->voxels[1] ||
        s->field->nz != shape->voxels[2] || s->field->nw ||
        zfp_stream_compression_mode(s->zfp) != zfp_mode_fixed_accuracy)
        return false;
    struct block b;
    float floats[64];
    for (size_t i = 0; block_at(shape, i, &b); i++) {
        if (stream_rtell(s->bits) >= 8 * bytes)
            return false;
        zfp_decode_partial_block_strided_float_3(s->zfp, floats, b.size[0], b.size[1], b.size[2], 1, 4, 16);
        put_block(shape, &b, floats, voxels);
    }
    size_t end = stream_rtell(s->bits);
    return end <= 8 * bytes && 8 * bytes - end < 64;
}

static bool all_finite(const float *v, size_t n)
{
    bool finite = true;
    for (size_t i = 0; i < n; i++)
        finite &= isfinite(v[i]) != 0;
    return finite;
}

static bool within(enum brick_type type, const void *a, const void *b, size_t n, double tolerance)
{
    bool ok = true;
    switch (type) {
#define CASE(TYPE, T)                                                                                        \
    case TYPE:                                                                                               \
        for (size_t i = 0; i < n; i++)                                                                       \
            ok &= fabs((double)((const T *)a)[i] - (double)((const T *)b)[i]) <= tolerance;                  \
        return ok;
        CASE(BRICK_U8, uint8_t)
        CASE(BRICK_I8, int8_t)
        CASE(BRICK_U16, uint16_t)
        CASE(BRICK_I16, int16_t)
        CASE(BRICK_F32, float)
#undef CASE
    default:
        return false;
    }
}

int zfp_payload_encode(const struct brick_codec_shape *shape, double tolerance, void *voxels, void *dst,
                       size_t dst_bytes, size_t *written, struct brick_error *err)
{
    size_t n = shape->voxel_bytes / brick_type_bytes(shape->type), bytes;
    *written = 0;
    if (shape->type == BRICK_F32 ? tolerance < least_tolerance || !all_finite(voxels, n) : tolerance < 1.0)
        return BRICK_OK;
    struct stream s;
    void *decoded = malloc(shape->voxel_bytes);
    int code = stream_init(&s, dst_bytes < shape->voxel_bytes ? dst_bytes : shape->voxel_bytes, err);
    if (!code && !decoded)
        code = brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a decoded brick");
    for (double accuracy = BOLD * tolerance; !code && !*written && accuracy >= tolerance; accuracy /= 2) {
        if (!encode_blocks(&s, shape, accuracy, voxels, &bytes))
            break; /* a finer one would be larger still */
        if (!decode_blocks(&s, shape, bytes, decoded) || !within(shape->type, voxels, decoded, n, tolerance))
            continue;
        memcpy(dst, s.buffer, bytes);
        memcpy(voxels, decoded, shape->voxel_bytes);
        *written = bytes;
    }
    stream_finish(&s);
    free(decoded);
    return code;
}

int zfp_payload_decode(const struct brick_codec_shape *shape, const void *src, size_t src_bytes, void *voxels,
                       struct brick_error *err)
{
    struct stream s;
    int code = stream_init(&s, src_bytes, err);
    if (!code) {
        memcpy(s.buffer, src, src_bytes);
        if (!decode_blocks(&s, shape, src_bytes, voxels))
            code = brick_fail(err, BRICK_ERR_FORMAT, "not a zfp stream of %u x %u x %u values",
                              shape->voxels[0], shape->voxels[1], shape->voxels[2]);
    }
    stream_finish(&s);
    return code;
}
