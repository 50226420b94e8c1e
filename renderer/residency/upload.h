/* Bricks on their way into the atlas, several in one pixel buffer, so that the driver copies while the host
 * goes on. */
#ifndef RENDERER_RESIDENCY_UPLOAD_H
#define RENDERER_RESIDENCY_UPLOAD_H

#include "atlas.h"

struct vr_upload {
    GLuint buffer;
    size_t room, used;
    uint8_t *map; /* NULL when nothing is pending */
    struct {
        uint32_t slot, stored[3];
        size_t at;
    } * pending;
    uint32_t count, most;
};

/* The context is bound in all of these. */
int vr_upload_init(struct vr_upload *upload, struct vr_context *context, const struct vr_atlas *atlas,
                   struct brick_error *err);
void vr_upload_finish(struct vr_upload *upload, struct vr_context *context);

/* Copy a brick's voxels, stored[a] on axis a; they are in the atlas after the next flush, or
 * before. */
int vr_upload_add(struct vr_upload *upload, struct vr_context *context, const struct vr_atlas *atlas,
                  uint32_t slot, const uint32_t stored[3], const void *voxels, struct brick_error *err);
int vr_upload_flush(struct vr_upload *upload, struct vr_context *context, const struct vr_atlas *atlas,
                    struct brick_error *err);

#endif
