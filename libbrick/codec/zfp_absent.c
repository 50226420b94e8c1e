/* What stands in for zfp_payload.c in a build without the library: it says what is missing. */
#include "zfp_payload.h"

const bool zfp_payload_built = false;

static int absent(struct brick_error *err)
{
    return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                      "codec zfp: this program was built without the library zfp: install the package "
                      "libzfp-dev and build again");
}

int zfp_payload_encode(const struct brick_codec_shape *shape, double tolerance, void *voxels, void *dst,
                       size_t dst_bytes, size_t *written, struct brick_error *err)
{
    (void)shape, (void)tolerance, (void)voxels, (void)dst, (void)dst_bytes, (void)written;
    return absent(err);
}

int zfp_payload_decode(const struct brick_codec_shape *shape, const void *src, size_t src_bytes, void *voxels,
                       struct brick_error *err)
{
    (void)shape, (void)src, (void)src_bytes, (void)voxels;
    return absent(err);
}
