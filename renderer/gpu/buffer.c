/* Buffer textures: created on first use, replaced by a larger one when they must grow. */
#include "buffer.h"

static uint64_t element_bytes(GLenum format)
{
    return format == GL_RGBA32F ? 16 : format == GL_RG32UI ? 8 : 4;
}

int vr_buffer_write(struct vr_buffer *buffer, struct vr_context *context, GLenum format, const void *data,
                    uint64_t bytes, const char *what, struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    uint64_t elements = bytes / element_bytes(format);
    if (elements > (uint64_t)context->max_buffer_elements)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s needs %llu elements; OpenGL (%s) allows %lld", what,
                          (unsigned long long)elements, context->renderer,
                          (long long)context->max_buffer_elements);
    if (!buffer->name) {
        gl->GenBuffers(1, &buffer->name);
        gl->GenTextures(1, &buffer->texture);
    }
    gl->BindBuffer(GL_TEXTURE_BUFFER, buffer->name);
    if (bytes > buffer->bytes || !buffer->bytes) {
        gl->BufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)bytes, data, GL_DYNAMIC_DRAW);
        buffer->bytes = bytes;
        gl->BindTexture(GL_TEXTURE_BUFFER, buffer->texture);
        gl->TexBuffer(GL_TEXTURE_BUFFER, format, buffer->name);
        gl->BindTexture(GL_TEXTURE_BUFFER, 0);
    } else {
        gl->BufferSubData(GL_TEXTURE_BUFFER, 0, (GLsizeiptr)bytes, data);
    }
    gl->BindBuffer(GL_TEXTURE_BUFFER, 0);
    return vr_context_check(context, what, err);
}

void vr_buffer_use(const struct vr_buffer *buffer, struct vr_context *context, GLuint unit)
{
    context->gl.ActiveTexture(GL_TEXTURE0 + unit);
    context->gl.BindTexture(GL_TEXTURE_BUFFER, buffer->texture);
    context->gl.ActiveTexture(GL_TEXTURE0);
}

void vr_buffer_finish(struct vr_buffer *buffer, struct vr_context *context)
{
    if (buffer->name) {
        context->gl.DeleteTextures(1, &buffer->texture);
        context->gl.DeleteBuffers(1, &buffer->name);
    }
    *buffer = (struct vr_buffer){0};
}
