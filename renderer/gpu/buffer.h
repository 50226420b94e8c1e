/* Arrays that shaders read by texelFetch (buffer textures), growing as needed. Storage blocks would do as
 * well, but Mesa's llvmpipe reads those one lane at a time, and gives 0 to lanes that have left a loop. */
#ifndef RENDERER_GPU_BUFFER_H
#define RENDERER_GPU_BUFFER_H

#include "context.h"

struct vr_buffer {
    GLuint name, texture;
    GLenum format;
    uint64_t bytes; /* room */
};

/* The context is bound in all of these. A buffer of zeros is empty. */

/* Replace the contents; data NULL: of `bytes` not yet known. format: GL_R32UI, GL_RGBA32F, ...; the same for
 * every call. BRICK_ERR_UNSUPPORTED when the driver allows no array of so many elements, naming what it is
 * for. */
int vr_buffer_write(struct vr_buffer *buffer, struct vr_context *context, GLenum format, const void *data,
                    uint64_t bytes, const char *what, struct brick_error *err);
/* Write again some of equal records of an array that has been written: records[0..count) are their numbers,
 * which are sorted; data is the whole array. Neighbours and near neighbours go in one piece. */
void vr_buffer_update(const struct vr_buffer *buffer, struct vr_context *context, const void *data,
                      size_t record_bytes, uint32_t *records, size_t count);
/* All bytes of the first `bytes` to 0. */
void vr_buffer_clear(const struct vr_buffer *buffer, struct vr_context *context, uint64_t bytes);
void vr_buffer_read(const struct vr_buffer *buffer, struct vr_context *context, void *data, uint64_t bytes);
/* Make it the array of a texture unit; of an image unit, for reading and writing. */
void vr_buffer_use(const struct vr_buffer *buffer, struct vr_context *context, GLuint unit);
void vr_buffer_use_image(const struct vr_buffer *buffer, struct vr_context *context, GLuint unit);
void vr_buffer_finish(struct vr_buffer *buffer, struct vr_context *context);

#endif
