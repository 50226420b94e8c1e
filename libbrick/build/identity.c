/* Everything that changes a byte of level 0 or of what is made from it, and nothing else: threads and memory
 * may differ from one run to the next. */
#include "identity.h"

#include <inttypes.h>
#include <stdio.h>

/* Of what brick_build makes of a source; to be raised when it makes other bytes. */
#define MAKING 1

char *identity_text(const struct brick_grid *grid, const struct brick_source *source,
                    const struct brick_build_params *params)
{
    char affine[12 * 32], *text = NULL;
    size_t at = 0;
    for (int i = 0; i < 12; i++)
        at += (size_t)snprintf(affine + at, sizeof affine - at, " %.17g", grid->affine[i / 4][i % 4]);
    int n = asprintf(&text,
                     "making: %d\n"
                     "source: %s\n"
                     "voxels: %" PRIu64 "x%" PRIu64 "x%" PRIu64 " %s\n"
                     "slope: %.17g\n"
                     "intercept: %.17g\n"
                     "affine:%s\n"
                     "brick: %u\n"
                     "border: %u\n"
                     "macrocell: %u\n"
                     "codec: %s\n"
                     "codec-level: %d\n"
                     "tolerance: %.17g\n"
                     "downsample: %s\n"
                     "to: %s\n"
                     "%s",
                     MAKING, source->state, grid->dims[0], grid->dims[1], grid->dims[2],
                     brick_type_name(source->type), grid->slope, grid->intercept, affine, grid->edge,
                     grid->border, grid->macrocell, brick_codec_name(params->codec), params->codec_level,
                     params->tolerance, params->nearest ? "nearest" : "mean",
                     params->round_to_f32 ? "f32" : "exact", source->provenance ? source->provenance : "");
    return n < 0 ? NULL : text;
}
