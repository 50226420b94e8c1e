/* Codecs of brick payloads. All compression comes from libraries; a codec is one row of a table. */
#ifndef BRICK_CODEC_H
#define BRICK_CODEC_H

#include <stddef.h>
#include <stdint.h>

#include <brick/error.h>

#ifdef __cplusplus
extern "C" {
#endif

enum brick_codec {
    BRICK_CODEC_NONE = 0,
    BRICK_CODEC_LZ4 = 1,  /* a Blosc 1 chunk: byte shuffle, then LZ4 */
    BRICK_CODEC_ZSTD = 2, /* a Blosc 1 chunk: byte shuffle, then Zstandard */
    BRICK_CODEC_COUNT = 3
};

const char *brick_codec_name(enum brick_codec codec);
/* BRICK_CODEC_COUNT for an unknown name. */
enum brick_codec brick_codec_from_name(const char *name);
/* Room that encoding n bytes may need. */
size_t brick_codec_bound(enum brick_codec codec, size_t n);
/* Encode n bytes of elements of element_bytes. level 1..9. *written <= brick_codec_bound. Deterministic.
 * n at most 2^31 - 17. */
int brick_codec_encode(enum brick_codec codec, int level, size_t element_bytes, const void *src, size_t n,
                       void *dst, size_t dst_bytes, size_t *written, struct brick_error *err);
/* Decode exactly n bytes, or BRICK_ERR_FORMAT. Safe on hostile input: never writes past dst + n. */
int brick_codec_decode(enum brick_codec codec, const void *src, size_t src_bytes, void *dst, size_t n,
                       struct brick_error *err);

#ifdef __cplusplus
}
#endif
#endif
