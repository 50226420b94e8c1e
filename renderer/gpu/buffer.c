/* Buffer textures: created on first use, replaced by a larger one when they must grow. */
#include "buffer.h"

#include <stdlib.h>

/* One call that writes this much that has not changed costs less than two calls. */
#define NEAR_BYTES 4096

static uint64_t element_bytes(GLenum format)
{
    return format == GL_RGBA32F || format == GL_RGBA32UI ? 16 : format == GL_RG32UI ? 8 : 4;
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
        buffer->format = format;
    }
    gl->BindBuffer(GL_TEXTURE_BUFFER, buffer->name);
    if (bytes > buffer->bytes || !buffer->bytes) {
        gl->BufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)bytes, data, GL_DYNAMIC_DRAW);
        buffer->bytes = bytes;
        gl->BindTexture(GL_TEXTURE_BUFFER, buffer->texture);
        gl->TexBuffer(GL_TEXTURE_BUFFER, format, buffer->name);
        gl->BindTexture(GL_TEXTURE_BUFFER, 0);
    } else if (data) {
        gl->BufferSubData(GL_TEXTURE_BUFFER, 0, (GLsizeiptr)bytes, data);
    }
    gl->BindBuffer(GL_TEXTURE_BUFFER, 0);
    return vr_context_check(context, what, err);
}

static int ascending(const void *a, const void *b)
{
    const uint32_t *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

void vr_buffer_update(const struct vr_buffer *buffer, struct vr_context *context, const void *data,
                      size_t record_bytes, uint32_t *records, size_t count)
{
    const struct vr_gl *gl = &context->gl;
    if (!count)
        return;
    qsort(records, count, sizeof *records, ascending);
    gl->BindBuffer(GL_TEXTURE_BUFFER, buffer->name);
    for (size_t i = 0, next; i < count; i = next) {
        for (next = i + 1; next < count; next++)
            if ((records[next] - records[next - 1]) * record_bytes > NEAR_BYTES)
                break;
        size_t at = records[i] * record_bytes, end = (records[next - 1] + (size_t)1) * record_bytes;
        gl->BufferSubData(GL_TEXTURE_BUFFER, (GLintptr)at, (GLsizeiptr)(end - at), (const char *)data + at);
    }
    gl->BindBuffer(GL_TEXTURE_BUFFER, 0);
}

void vr_buffer_clear(const struct vr_buffer *buffer, struct vr_context *context, uint64_t bytes)
{
    const struct vr_gl *gl = &context->gl;
    gl->BindBuffer(GL_TEXTURE_BUFFER, buffer->name);
    gl->ClearBufferSubData(GL_TEXTURE_BUFFER, GL_R8, 0, (GLsizeiptr)bytes, GL_RED, GL_UNSIGNED_BYTE, NULL);
    gl->BindBuffer(GL_TEXTURE_BUFFER, 0);
}

void vr_buffer_read(const struct vr_buffer *buffer, struct vr_context *context, void *data, uint64_t bytes)
{
    const struct vr_gl *gl = &context->gl;
    gl->BindBuffer(GL_TEXTURE_BUFFER, buffer->name);
    gl->GetBufferSubData(GL_TEXTURE_BUFFER, 0, (GLsizeiptr)bytes, data);
    gl->BindBuffer(GL_TEXTURE_BUFFER, 0);
}

void vr_buffer_use(const struct vr_buffer *buffer, struct vr_context *context, GLuint unit)
{
    context->gl.ActiveTexture(GL_TEXTURE0 + unit);
    context->gl.BindTexture(GL_TEXTURE_BUFFER, buffer->texture);
    context->gl.ActiveTexture(GL_TEXTURE0);
}

void vr_buffer_use_image(const struct vr_buffer *buffer, struct vr_context *context, GLuint unit)
{
    context->gl.BindImageTexture(unit, buffer->texture, 0, GL_FALSE, 0, GL_READ_WRITE, buffer->format);
}

void vr_buffer_finish(struct vr_buffer *buffer, struct vr_context *context)
{
    if (buffer->name) {
        context->gl.DeleteTextures(1, &buffer->texture);
        context->gl.DeleteBuffers(1, &buffer->name);
    }
    *buffer = (struct vr_buffer){0};
}
