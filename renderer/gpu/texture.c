/* Immutable storage of one level. */
#include "texture.h"

GLuint vr_texture_create(struct vr_context *context, GLenum format, int width, int height)
{
    const struct vr_gl *gl = &context->gl;
    GLuint texture;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->BindTexture(GL_TEXTURE_2D, 0);
    return texture;
}

void vr_texture_use(struct vr_context *context, GLuint texture, GLuint unit)
{
    context->gl.ActiveTexture(GL_TEXTURE0 + unit);
    context->gl.BindTexture(GL_TEXTURE_2D, texture);
    context->gl.ActiveTexture(GL_TEXTURE0);
}
