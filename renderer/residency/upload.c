/* Uploads through a pixel buffer. Its store is given up with every batch (BufferData of NULL): the driver
 * hands out another while it still copies from the last. */
#include "upload.h"

#include <stdlib.h>
#include <string.h>

/* Of a batch: a few milliseconds of copying. */
#define BATCH_BYTES ((size_t)8 << 20)

int vr_upload_init(struct vr_upload *u, struct vr_context *context, const struct vr_atlas *atlas,
                   struct brick_error *err)
{
    size_t slot_bytes = ((size_t)atlas->slot_bytes + 15) & ~(size_t)15;
    *u = (struct vr_upload){.most = (uint32_t)(BATCH_BYTES / slot_bytes)};
    if (u->most > atlas->count)
        u->most = atlas->count;
    if (u->most < 1)
        u->most = 1;
    u->room = u->most * slot_bytes;
    u->pending = malloc(u->most * sizeof *u->pending);
    if (!u->pending)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for %u bricks on their way to the GPU", u->most);
    context->gl.GenBuffers(1, &u->buffer);
    return BRICK_OK;
}

void vr_upload_finish(struct vr_upload *u, struct vr_context *context)
{
    if (u->buffer)
        context->gl.DeleteBuffers(1, &u->buffer); /* unmaps it */
    free(u->pending);
    *u = (struct vr_upload){0};
}

int vr_upload_add(struct vr_upload *u, struct vr_context *context, const struct vr_atlas *atlas,
                  uint32_t slot, const uint32_t stored[3], const void *voxels, struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    int result;
    if (u->count == u->most && (result = vr_upload_flush(u, context, atlas, err)))
        return result;
    if (!u->map) {
        gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, u->buffer);
        gl->BufferData(GL_PIXEL_UNPACK_BUFFER, (GLsizeiptr)u->room, NULL, GL_STREAM_DRAW);
        u->map = gl->MapBufferRange(GL_PIXEL_UNPACK_BUFFER, 0, (GLsizeiptr)u->room,
                                    GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
        gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
        if (!u->map)
            return brick_fail(err, BRICK_ERR_MEMORY, "OpenGL (%s) has no pixel buffer of %zu bytes",
                              context->renderer, u->room);
    }
    const size_t count = (size_t)stored[0] * stored[1] * stored[2];
    vr_atlas_convert(atlas, voxels, count, u->map + u->used);
    u->pending[u->count].slot = slot;
    u->pending[u->count].at = u->used;
    memcpy(u->pending[u->count].stored, stored, sizeof u->pending->stored);
    u->count++;
    u->used += (count * atlas->voxels.bytes + 15) & ~(size_t)15;
    return BRICK_OK;
}

int vr_upload_flush(struct vr_upload *u, struct vr_context *context, const struct vr_atlas *atlas,
                    struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    if (!u->map)
        return BRICK_OK;
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, u->buffer);
    GLboolean kept = gl->UnmapBuffer(GL_PIXEL_UNPACK_BUFFER);
    for (uint32_t i = 0; kept && i < u->count; i++)
        vr_atlas_upload(atlas, context, u->pending[i].slot, u->pending[i].stored, u->pending[i].at);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    u->map = NULL;
    u->used = 0;
    u->count = 0;
    if (!kept)
        return brick_fail(err, BRICK_ERR_MEMORY, "OpenGL (%s) has lost a pixel buffer", context->renderer);
    return vr_context_check(context, "brick upload", err);
}
