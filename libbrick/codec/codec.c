/* The table of codecs. Blosc codecs are one Blosc 1 chunk a payload, made with one thread and no globals so
 * that the same bytes in give the same bytes out. */
#include <brick/codec.h>

#include <blosc.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delta.h"
#include "zfp_payload.h"

static const struct {
    const char *name;
    const char *compressor; /* Blosc's name; NULL: not Blosc */
    int shuffle;
    bool delta;
} codecs[BRICK_CODEC_COUNT] = {
    [BRICK_CODEC_NONE] = {"none", NULL, 0, false},
    [BRICK_CODEC_LZ4] = {"lz4", BLOSC_LZ4_COMPNAME, BLOSC_SHUFFLE, false},
    [BRICK_CODEC_ZSTD] = {"zstd", BLOSC_ZSTD_COMPNAME, BLOSC_SHUFFLE, false},
    [BRICK_CODEC_LZ4_BITSHUFFLE] = {"lz4-bitshuffle", BLOSC_LZ4_COMPNAME, BLOSC_BITSHUFFLE, false},
    [BRICK_CODEC_ZSTD_DELTA] = {"zstd-delta", BLOSC_ZSTD_COMPNAME, BLOSC_SHUFFLE, true},
    [BRICK_CODEC_ZFP] = {"zfp", NULL, 0, false},
};

struct brick_codec_shape brick_codec_shape(const struct brick_grid *grid, const struct brick_place *place)
{
    return (struct brick_codec_shape){.type = grid->type,
                                      .voxels = {place->stored[0], place->stored[1], place->stored[2]},
                                      .voxel_bytes = brick_place_voxel_bytes(grid, place),
                                      .bytes = brick_place_payload_bytes(grid, place)};
}

const char *brick_codec_name(enum brick_codec codec)
{
    return (unsigned)codec < BRICK_CODEC_COUNT ? codecs[codec].name : NULL;
}

enum brick_codec brick_codec_from_name(const char *name)
{
    unsigned c = 0;
    while (c < BRICK_CODEC_COUNT && strcmp(name, codecs[c].name) != 0)
        c++;
    return (enum brick_codec)c;
}

bool brick_codec_is_lossy(enum brick_codec codec)
{
    return codec == BRICK_CODEC_ZFP;
}

bool brick_codec_is_built(enum brick_codec codec)
{
    return (unsigned)codec < BRICK_CODEC_COUNT && (codec != BRICK_CODEC_ZFP || zfp_payload_built);
}

size_t brick_codec_bound(enum brick_codec codec, size_t n)
{
    return codec == BRICK_CODEC_NONE ? n : n + BLOSC_MAX_OVERHEAD;
}

int brick_codec_encode(enum brick_codec codec, int level, const struct brick_codec_shape *shape,
                       const void *src, void *dst, size_t dst_bytes, size_t *written, struct brick_error *err)
{
    size_t n = shape->bytes, width = brick_type_bytes(shape->type);
    if ((unsigned)codec >= BRICK_CODEC_COUNT || brick_codec_is_lossy(codec) || level < 1 || level > 9 ||
        n > BLOSC_MAX_BUFFERSIZE || dst_bytes < brick_codec_bound(codec, n))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "codec %d, level %d: not possible for %zu bytes",
                          (int)codec, level, n);
    if (!codecs[codec].compressor) {
        memcpy(dst, src, n);
        *written = n;
        return BRICK_OK;
    }
    void *differences = NULL;
    if (codecs[codec].delta) {
        if (!(differences = malloc(n)))
            return brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a brick's differences");
        delta_encode(width, src, differences, n / width);
        src = differences;
    }
    int got = blosc_compress_ctx(level, codecs[codec].shuffle, width, n, src, dst, dst_bytes,
                                 codecs[codec].compressor, 0, 1);
    free(differences);
    if (got <= 0)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "the Blosc library cannot compress with %s (code %d)",
                          codecs[codec].name, got);
    *written = (size_t)got;
    return BRICK_OK;
}

int brick_codec_encode_lossy(enum brick_codec codec, double tolerance, const struct brick_codec_shape *shape,
                             void *voxels, void *dst, size_t dst_bytes, size_t *written,
                             struct brick_error *err)
{
    if (!brick_codec_is_lossy(codec) || !(tolerance >= 0.0))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "codec %d with tolerance %g is not possible", (int)codec,
                          tolerance);
    return zfp_payload_encode(shape, tolerance, voxels, dst, dst_bytes, written, err);
}

double brick_codec_tolerance(enum brick_type type, double slope, double physical)
{
    double scale = fabs(slope), e = physical / scale;
    if (brick_type_is_integer(type)) {
        if (!(e < 65535.0))
            return 65535.0; /* no two values are farther apart */
        e = floor(e);
        if (scale * (e + 1.0) <= physical) /* the quotient was rounded down */
            e += 1.0;
    } else if (!(e < (double)FLT_MAX))
        return (double)FLT_MAX;
    while (e > 0.0 && scale * e > physical)
        e = brick_type_is_integer(type) ? e - 1.0 : nextafter(e, 0.0);
    return e;
}

size_t brick_codec_measure(enum brick_codec codec, const struct brick_codec_shape *shape, const void *src,
                           size_t src_bytes)
{
    if ((unsigned)codec >= BRICK_CODEC_COUNT || brick_codec_is_lossy(codec))
        return 0;
    if (!codecs[codec].compressor)
        return shape && src_bytes >= shape->bytes ? shape->bytes : 0;
    size_t holds, bytes, block, width;
    int flags;
    if (src_bytes < BLOSC_MIN_HEADER_LENGTH)
        return 0;
    blosc_cbuffer_sizes(src, &holds, &bytes, &block);
    blosc_cbuffer_metainfo(src, &width, &flags);
    const char *library = blosc_cbuffer_complib(src);
    int shuffle = flags & BLOSC_DOBITSHUFFLE ? BLOSC_BITSHUFFLE : flags & BLOSC_DOSHUFFLE ? BLOSC_SHUFFLE : 0;
    bool lz4 = library && strcmp(library, BLOSC_LZ4_LIBNAME) == 0,
         zstd = library && strcmp(library, BLOSC_ZSTD_LIBNAME) == 0;
    bool fits = (!shape || (holds == shape->bytes && width == brick_type_bytes(shape->type))) &&
                shuffle == codecs[codec].shuffle && bytes >= BLOSC_MIN_HEADER_LENGTH &&
                (!shape || bytes <= src_bytes) &&
                (strcmp(codecs[codec].compressor, BLOSC_LZ4_COMPNAME) == 0 ? lz4 : zstd);
    return fits ? bytes : 0;
}

int brick_codec_decode(enum brick_codec codec, const struct brick_codec_shape *shape, const void *src,
                       size_t src_bytes, void *dst, struct brick_error *err)
{
    size_t n = shape->bytes, width = brick_type_bytes(shape->type), holds = 0;
    if ((unsigned)codec >= BRICK_CODEC_COUNT)
        return brick_fail(err, BRICK_ERR_FORMAT, "codec %d is unknown", (int)codec);
    if (codec == BRICK_CODEC_ZFP) {
        size_t ranges = n - shape->voxel_bytes;
        if (src_bytes <= ranges)
            return brick_fail(err, BRICK_ERR_FORMAT, "%zu bytes are too few for a zfp payload", src_bytes);
        int code = zfp_payload_decode(shape, src, src_bytes - ranges, dst, err);
        if (!code)
            memcpy((unsigned char *)dst + shape->voxel_bytes,
                   (const unsigned char *)src + (src_bytes - ranges), ranges);
        return code;
    }
    if (!codecs[codec].compressor) {
        if (src_bytes != n)
            return brick_fail(err, BRICK_ERR_FORMAT, "%zu bytes where %zu belong", src_bytes, n);
        memcpy(dst, src, n);
        return BRICK_OK;
    }
    if (src_bytes < BLOSC_MIN_HEADER_LENGTH || blosc_cbuffer_validate(src, src_bytes, &holds) != 0 ||
        holds != n || blosc_decompress_ctx(src, dst, n, 1) != (int)n)
        return brick_fail(err, BRICK_ERR_FORMAT, "not a Blosc chunk of %zu bytes", n);
    if (codecs[codec].delta)
        delta_decode(width, dst, n / width);
    return BRICK_OK;
}
