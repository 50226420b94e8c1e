/* The voxels of a brick as a zfp stream of fixed accuracy: zfp_payload.c, or zfp_absent.c without the
 * library. */
#ifndef BRICK_CODEC_ZFP_PAYLOAD_H
#define BRICK_CODEC_ZFP_PAYLOAD_H

#include <brick/codec.h>

extern const bool zfp_payload_built;

/* As brick_codec_encode_lossy. */
int zfp_payload_encode(const struct brick_codec_shape *shape, double tolerance, void *voxels, void *dst,
                       size_t dst_bytes, size_t *written, struct brick_error *err);
/* Decode a stream of exactly src_bytes to shape->voxel_bytes at voxels. */
int zfp_payload_decode(const struct brick_codec_shape *shape, const void *src, size_t src_bytes, void *voxels,
                       struct brick_error *err);

#endif
