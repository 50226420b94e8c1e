/* Pre-classified voxels (Wilson, Van Gelder and Wilhelms 1994, section 2.1): the texture holds, in place of
 * values, the colour and the opacity of a slice's thickness of each voxel. */
#ifndef RENDERER_METHODS_SLICES_PALETTE_H
#define RENDERER_METHODS_SLICES_PALETTE_H

#include "frame.h"

/* Kept from picture to picture; one of zeros is empty. */
struct vr_palette {
    struct vr_texels texels; /* first: what convert is given is this */
    enum brick_type stored;
    double slope, intercept;
    /* What the entries below are of. */
    struct brick_transfer transfer; /* its knots are a copy; no intervals */
    double spacing_mm;
    uint32_t bits;
    void *entries; /* of every value of 8 or 16 bits, from the least on; NULL for f32 */
    size_t room;
};

/* With bits 8, 16 or 32 a channel, of slices of spacing_mm. palette->texels.number is another if anything
 * is. */
int vr_palette_set(struct vr_palette *palette, const struct vr_frame *frame, double spacing_mm, uint32_t bits,
                   struct brick_error *err);
void vr_palette_finish(struct vr_palette *palette);

#endif
