/* The offscreen target. Row 0 of the framebuffer is the picture's top row: the shader counts rows downward,
 * so nothing is flipped. */
#include "target.h"

#define TILE 256

int vr_target_init(struct vr_target *target, struct vr_context *context, int width, int height,
                   struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    static const GLenum attachments[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    int result;

    *target = (struct vr_target){.width = width, .height = height};
    gl->GenVertexArrays(1, &target->vertex_array);
    gl->GenTextures(1, &target->colour);
    gl->BindTexture(GL_TEXTURE_2D, target->colour);
    gl->TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, width, height);
    gl->GenTextures(1, &target->counter);
    gl->BindTexture(GL_TEXTURE_2D, target->counter);
    gl->TexStorage2D(GL_TEXTURE_2D, 1, GL_R32UI, width, height);
    gl->BindTexture(GL_TEXTURE_2D, 0);
    gl->GenFramebuffers(1, &target->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, attachments[0], GL_TEXTURE_2D, target->colour, 0);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, attachments[1], GL_TEXTURE_2D, target->counter, 0);
    gl->DrawBuffers(2, attachments);
    result = vr_context_check(context, "picture buffer", err);
    if (!result && gl->CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        result = brick_fail(err, BRICK_ERR_UNSUPPORTED, "OpenGL (%s) cannot draw to float32 pictures",
                            context->renderer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    if (result)
        vr_target_finish(target, context);
    return result;
}

void vr_target_finish(struct vr_target *target, struct vr_context *context)
{
    const struct vr_gl *gl = &context->gl;
    gl->DeleteFramebuffers(1, &target->framebuffer);
    gl->DeleteTextures(1, &target->colour);
    gl->DeleteTextures(1, &target->counter);
    gl->DeleteVertexArrays(1, &target->vertex_array);
    *target = (struct vr_target){0};
}

void vr_target_draw(const struct vr_target *target, struct vr_context *context, int width, int height)
{
    const struct vr_gl *gl = &context->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
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
                    float *rgba, int stride, uint32_t *scratch, uint64_t *count)
{
    const struct vr_gl *gl = &context->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, stride);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl->ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, rgba);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, 0);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT1);
    gl->ReadPixels(0, 0, width, height, GL_RED_INTEGER, GL_UNSIGNED_INT, scratch);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    for (int64_t i = 0; i < (int64_t)width * height; i++)
        *count += scratch[i];
}
