/* A method as the renderer sees it: a row in its table. */
#ifndef RENDERER_METHODS_METHOD_H
#define RENDERER_METHODS_METHOD_H

#include "frame.h"

struct vr_method_row {
    size_t state_bytes; /* of what the method keeps from picture to picture; zeros are empty */
    /* Draw the frame into image, which has the scene's size; counts passes and samples in report, whose other
     * figures are the renderer's. BRICK_ERR_UNSUPPORTED for what the scene or the quality asks and this
     * method does not do. */
    int (*draw)(void *state, struct vr_frame *frame, struct brick_image *image, struct vr_report *report,
                struct brick_error *err);
    void (*finish)(void *state, struct vr_context *context); /* the context is bound */
    /* What slots are to hold for a frame in place of voxels, or NULL, *texels being the method's own until
     * the next call. Called before drawing, and before the frame has its residency's picture begun. NULL:
     * always voxels. */
    int (*texels)(void *state, const struct vr_frame *frame, const struct vr_texels **texels,
                  struct brick_error *err);
    bool filters;       /* draws from an atlas for VR_FILTER_FAST, too */
    bool glows;         /* is emission independent of extinction drawn? */
    bool clips, meshes; /* draws clip planes, meshes; the renderer refuses what is not drawn */
};

extern const struct vr_method_row vr_raycast, vr_slices, vr_cells;

#endif
