/* Colour textures to blend into. Row 0 of the framebuffer is the picture's top row, as with vr_target:
 * projections put it there, so nothing is flipped. */
#include "canvas.h"

#include <stdbool.h>

#include "texture.h"

int vr_canvas_init(struct vr_canvas *canvas, struct vr_context *context, GLenum format, int width, int height,
                   struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    *canvas = (struct vr_canvas){.width = width, .height = height};
    canvas->colour = vr_texture_create(context, format, width, height);
    gl->GenFramebuffers(1, &canvas->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, canvas->framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, canvas->colour, 0);
    bool complete = gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    int result = vr_context_check(context, "picture buffer", err);
    if (!result && !complete)
        result =
            brick_fail(err, BRICK_ERR_UNSUPPORTED, "OpenGL (%s) cannot draw to a picture buffer of %d x %d",
                       context->renderer, width, height);
    if (result)
        vr_canvas_finish(canvas, context);
    return result;
}

void vr_canvas_finish(struct vr_canvas *canvas, struct vr_context *context)
{
    context->gl.DeleteFramebuffers(1, &canvas->framebuffer);
    context->gl.DeleteTextures(1, &canvas->colour);
    *canvas = (struct vr_canvas){0};
}

void vr_canvas_use(const struct vr_canvas *canvas, struct vr_context *context)
{
    context->gl.BindFramebuffer(GL_FRAMEBUFFER, canvas->framebuffer);
    context->gl.Viewport(0, 0, canvas->width, canvas->height);
}

void vr_canvas_clear(const struct vr_canvas *canvas, struct vr_context *context)
{
    static const GLfloat zeros[4] = {0};
    vr_canvas_use(canvas, context);
    context->gl.ClearBufferfv(GL_COLOR, 0, zeros);
}

void vr_canvas_read(const struct vr_canvas *canvas, struct vr_context *context, int width, int height,
                    float *rgba, int stride)
{
    const struct vr_gl *gl = &context->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, canvas->framebuffer);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, stride);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl->ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, rgba);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, 0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}
