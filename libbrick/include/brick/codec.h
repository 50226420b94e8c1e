/* Codecs of brick payloads. All compression comes from libraries; a codec is one row of a table. */
#ifndef BRICK_CODEC_H
#define BRICK_CODEC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <brick/error.h>
#include <brick/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

enum brick_codec {
    BRICK_CODEC_NONE = 0,
    BRICK_CODEC_LZ4 = 1,            /* a Blosc 1 chunk: byte shuffle, then LZ4 */
    BRICK_CODEC_ZSTD = 2,           /* a Blosc 1 chunk: byte shuffle, then Zstandard */
    BRICK_CODEC_LZ4_BITSHUFFLE = 3, /* a Blosc 1 chunk: bit shuffle, then LZ4 */
    BRICK_CODEC_ZSTD_DELTA = 4,     /* differences of neighbours along x, then as zstd */
    BRICK_CODEC_ZFP = 5,            /* lossy: a zfp stream of fixed accuracy; needs the library zfp */
    BRICK_CODEC_COUNT = 6
};

/* What a payload decodes to: voxels, x fastest, and ranges behind them, all of one type. */
struct brick_codec_shape {
    enum brick_type type; /* stored */
    uint32_t voxels[3];
    size_t voxel_bytes, bytes; /* of the voxels; of all */
};
struct brick_codec_shape brick_codec_shape(const struct brick_grid *grid, const struct brick_place *place);

const char *brick_codec_name(enum brick_codec codec);
/* BRICK_CODEC_COUNT for an unknown name. */
enum brick_codec brick_codec_from_name(const char *name);
/* Does decoding give other values than were encoded? */
bool brick_codec_is_lossy(enum brick_codec codec);
/* Can this build encode and decode it? */
bool brick_codec_is_built(enum brick_codec codec);
/* Room that encoding n bytes may need. */
size_t brick_codec_bound(enum brick_codec codec, size_t n);

/* Encode a payload with a lossless codec. level 1..9. *written <= brick_codec_bound. Deterministic.
 * shape->bytes at most 2^31 - 17. This and the next take up to twice shape->bytes of memory while they run.
 */
int brick_codec_encode(enum brick_codec codec, int level, const struct brick_codec_shape *shape,
                       const void *src, void *dst, size_t dst_bytes, size_t *written,
                       struct brick_error *err);

/* Encode a payload's voxels with a lossy codec such that decoding moves none by more than `tolerance` stored
 * values, which is checked voxel by voxel, and put what decoding will give in their place. The payload is
 * then dst and, behind it, the ranges of these new voxels as they are: the caller's to append.
 * *written = 0 and nothing changed when the bound cannot be kept (NaN, Inf, a tolerance too small for the
 * values) or the stream would take dst_bytes or as many as the voxels: use a lossless codec. Deterministic.
 * BRICK_ERR_UNSUPPORTED without the library. */
int brick_codec_encode_lossy(enum brick_codec codec, double tolerance, const struct brick_codec_shape *shape,
                             void *voxels, void *dst, size_t dst_bytes, size_t *written,
                             struct brick_error *err);
/* The largest difference of stored values that is none larger than `physical` after slope: whole for integer
 * types. */
double brick_codec_tolerance(enum brick_type type, double slope, double physical);

/* Bytes that a payload of this codec and shape takes at the start of src, as its own header tells: at most
 * src_bytes. 0: there is none. With shape NULL any shape will do, and any size; codec none then tells
 * nothing. A hint, not a proof: decode it. Never for lossy codecs, whose payloads do not tell; zstd and
 * zstd-delta look alike. */
size_t brick_codec_measure(enum brick_codec codec, const struct brick_codec_shape *shape, const void *src,
                           size_t src_bytes);

/* Decode exactly shape->bytes, or BRICK_ERR_FORMAT; BRICK_ERR_UNSUPPORTED without the library. Safe on
 * hostile input: never reads past src + src_bytes or writes past dst + shape->bytes. */
int brick_codec_decode(enum brick_codec codec, const struct brick_codec_shape *shape, const void *src,
                       size_t src_bytes, void *dst, struct brick_error *err);

#ifdef __cplusplus
}
#endif
#endif
