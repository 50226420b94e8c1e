/* Arrays that shaders read by texelFetch (buffer textures), growing as needed. Storage blocks would do as
 * well, but Mesa's llvmpipe reads those one lane at a time, and gives 0 to lanes that have left a loop. */
#ifndef RENDERER_GPU_BUFFER_H
#define RENDERER_GPU_BUFFER_H

#include "context.h"

struct vr_buffer {
    GLuint name, texture;
    uint64_t bytes; /* room */
};

/* The context is bound in all of these. A buffer of zeros is empty. */

/* Replace the contents. format: GL_R32UI, GL_RGBA32F, ...; the same for every call. BRICK_ERR_UNSUPPORTED
 * when the driver allows no array of so many elements, naming what it is for. */
int vr_buffer_write(struct vr_buffer *buffer, struct vr_context *context, GLenum format, const void *data,
                    uint64_t bytes, const char *what, struct brick_error *err);
/* Make it the array of a texture unit. */
void vr_buffer_use(const struct vr_buffer *buffer, struct vr_context *context, GLuint unit);
void vr_buffer_finish(struct vr_buffer *buffer, struct vr_context *context);

#endif
