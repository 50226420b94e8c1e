/* The table of codecs. lz4 and zstd are Blosc 1 chunks (byte shuffle, then the compressor), one chunk a
 * payload, made with one thread and no globals so that the same bytes in give the same bytes out. */
#include <brick/codec.h>

#include <blosc.h>
#include <string.h>

static const struct {
    const char *name;
    const char *compressor; /* Blosc's name; NULL: bytes as they are */
} codecs[BRICK_CODEC_COUNT] = {
    [BRICK_CODEC_NONE] = {"none", NULL},
    [BRICK_CODEC_LZ4] = {"lz4", BLOSC_LZ4_COMPNAME},
    [BRICK_CODEC_ZSTD] = {"zstd", BLOSC_ZSTD_COMPNAME},
};

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

size_t brick_codec_bound(enum brick_codec codec, size_t n)
{
    return codec == BRICK_CODEC_NONE ? n : n + BLOSC_MAX_OVERHEAD;
}

int brick_codec_encode(enum brick_codec codec, int level, size_t element_bytes, const void *src, size_t n,
                       void *dst, size_t dst_bytes, size_t *written, struct brick_error *err)
{
    if ((unsigned)codec >= BRICK_CODEC_COUNT || level < 1 || level > 9 || n > BLOSC_MAX_BUFFERSIZE ||
        dst_bytes < brick_codec_bound(codec, n))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "codec %d, level %d: not possible for %zu bytes",
                          (int)codec, level, n);
    if (!codecs[codec].compressor) {
        memcpy(dst, src, n);
        *written = n;
        return BRICK_OK;
    }
    int got = blosc_compress_ctx(level, BLOSC_SHUFFLE, element_bytes, n, src, dst, dst_bytes,
                                 codecs[codec].compressor, 0, 1);
    if (got <= 0)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "the Blosc library cannot compress with %s (code %d)",
                          codecs[codec].name, got);
    *written = (size_t)got;
    return BRICK_OK;
}

int brick_codec_decode(enum brick_codec codec, const void *src, size_t src_bytes, void *dst, size_t n,
                       struct brick_error *err)
{
    if ((unsigned)codec >= BRICK_CODEC_COUNT)
        return brick_fail(err, BRICK_ERR_FORMAT, "codec %d is unknown", (int)codec);
    if (!codecs[codec].compressor) {
        if (src_bytes != n)
            return brick_fail(err, BRICK_ERR_FORMAT, "%zu bytes where %zu belong", src_bytes, n);
        memcpy(dst, src, n);
        return BRICK_OK;
    }
    size_t holds = 0;
    if (src_bytes < BLOSC_MIN_HEADER_LENGTH || blosc_cbuffer_validate(src, src_bytes, &holds) != 0 ||
        holds != n || blosc_decompress_ctx(src, dst, n, 1) != (int)n)
        return brick_fail(err, BRICK_ERR_FORMAT, "not a Blosc chunk of %zu bytes", n);
    return BRICK_OK;
}
