/* The offscreen target. Row 0 of the framebuffer is the picture's top row: the shader counts rows downward,
 * so nothing is flipped. */
#include "target.h"

#define TILE 256

static GLuint attach(const struct vr_gl *gl, GLenum attachment, GLenum format, int width, int height)
{
    GLuint texture;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->BindTexture(GL_TEXTURE_2D, 0);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture, 0);
    return texture;
}

int vr_target_init(struct vr_target *target, struct vr_context *context, int width, int height,
                   bool several_passes, struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    static const GLenum attachments[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    int result = BRICK_OK;

    *target = (struct vr_target){.width = width, .height = height, .count = several_passes ? 2 : 1};
    gl->GenVertexArrays(1, &target->vertex_array);
    for (int i = 0; !result && i < target->count; i++) {
        gl->GenFramebuffers(1, &target->framebuffer[i]);
        gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer[i]);
        target->colour[i] = attach(gl, attachments[0], GL_RGBA32F, width, height);
        target->numbers[i] = attach(gl, attachments[1], GL_RG32UI, width, height);
        gl->DrawBuffers(2, attachments);
        result = vr_context_check(context, "picture buffer", err);
        if (!result && gl->CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
            result = brick_fail(err, BRICK_ERR_UNSUPPORTED, "OpenGL (%s) cannot draw to float32 pictures",
                                context->renderer);
    }
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    if (result)
        vr_target_finish(target, context);
    return result;
}

void vr_target_finish(struct vr_target *target, struct vr_context *context)
{
    const struct vr_gl *gl = &context->gl;
    gl->DeleteFramebuffers(2, target->framebuffer);
    gl->DeleteTextures(2, target->colour);
    gl->DeleteTextures(2, target->numbers);
    gl->DeleteVertexArrays(1, &target->vertex_array);
    *target = (struct vr_target){0};
}

void vr_target_use(const struct vr_target *target, struct vr_context *context, GLuint colour_unit,
                   GLuint numbers_unit)
{
    const struct vr_gl *gl = &context->gl;
    gl->ActiveTexture(GL_TEXTURE0 + colour_unit);
    gl->BindTexture(GL_TEXTURE_2D, target->colour[target->drawn]);
    gl->ActiveTexture(GL_TEXTURE0 + numbers_unit);
    gl->BindTexture(GL_TEXTURE_2D, target->numbers[target->drawn]);
    gl->ActiveTexture(GL_TEXTURE0);
}

void vr_target_draw(struct vr_target *target, struct vr_context *context, int width, int height)
{
    const struct vr_gl *gl = &context->gl;
    target->drawn = (target->drawn + 1) % target->count;
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer[target->drawn]);
    gl->BindVertexArray(target->vertex_array);
    gl->Viewport(0, 0, target->width, target->height);
    gl->Disable(GL_BLEND);
    gl->Disable(GL_DEPTH_TEST);
    gl->Enable(GL_SCISSOR_TEST);
    for (int y = 0; y < height; y += TILE)
        for (int x = 0; x < width; x += TILE) {
            gl->Scissor(x, y, width - x < TILE ? width - x : TILE, height - y < TILE ? height - y : TILE);
            gl->DrawArrays(GL_TRIANGLES, 0, 3);
            gl->Flush();
        }
    gl->Disable(GL_SCISSOR_TEST);
    gl->BindVertexArray(0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}

void vr_target_read(const struct vr_target *target, struct vr_context *context, int width, int height,
                    float *rgba, int stride, uint32_t *numbers)
{
    const struct vr_gl *gl = &context->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer[target->drawn]);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, stride);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl->ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, rgba);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, 0);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT1);
    gl->ReadPixels(0, 0, width, height, GL_RG_INTEGER, GL_UNSIGNED_INT, numbers);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}
