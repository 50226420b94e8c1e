/* The offscreen target. Row 0 of the framebuffer is the picture's top row: the shader counts rows downward,
 * so nothing is flipped. Drawing goes to a framebuffer without attachments: a shader that reads and writes
 * its own pixel of an image needs no second copy, and a pixel that is not drawn keeps what it has. Words are
 * integers so that no driver touches the bits of a NaN or a denormal number. */
#include "target.h"

#include "texture.h"

/* Tiles between flushes: enough that every core has some. */
#define TILES_A_FLUSH 64

int vr_target_init(struct vr_target *target, struct vr_context *context, int width, int height, bool depth,
                   struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    bool complete;
    int result;

    *target = (struct vr_target){.width = width, .height = height};
    gl->GenVertexArrays(1, &target->vertex_array);
    target->words = vr_texture_create(context, GL_RGBA32UI, width, height);
    target->numbers = vr_texture_create(context, GL_RG32UI, width, height);
    gl->GenFramebuffers(1, &target->draw_framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->draw_framebuffer);
    gl->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_WIDTH, width);
    gl->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_HEIGHT, height);
    if (depth) {
        target->depth = vr_texture_create(context, GL_DEPTH_COMPONENT32F, width, height);
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, target->depth, 0);
    }
    complete = gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    gl->GenFramebuffers(1, &target->read_framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->read_framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target->words, 0);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, target->numbers, 0);
    complete = complete && gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    result = vr_context_check(context, "picture buffer", err);
    if (!result && !complete)
        result = brick_fail(err, BRICK_ERR_UNSUPPORTED, "OpenGL (%s) cannot draw to images of %d x %d",
                            context->renderer, width, height);
    if (result)
        vr_target_finish(target, context);
    return result;
}

void vr_target_finish(struct vr_target *target, struct vr_context *context)
{
    const struct vr_gl *gl = &context->gl;
    gl->DeleteFramebuffers(1, &target->draw_framebuffer);
    gl->DeleteFramebuffers(1, &target->read_framebuffer);
    gl->DeleteTextures(1, &target->words);
    gl->DeleteTextures(1, &target->numbers);
    gl->DeleteTextures(1, &target->depth);
    gl->DeleteVertexArrays(1, &target->vertex_array);
    *target = (struct vr_target){0};
}

void vr_target_copy(const struct vr_target *target, struct vr_context *context, const struct vr_target *from,
                    int width, int height)
{
    const struct vr_gl *gl = &context->gl;
    gl->CopyImageSubData(from->words, GL_TEXTURE_2D, 0, 0, 0, 0, target->words, GL_TEXTURE_2D, 0, 0, 0, 0,
                         width, height, 1);
    gl->CopyImageSubData(from->numbers, GL_TEXTURE_2D, 0, 0, 0, 0, target->numbers, GL_TEXTURE_2D, 0, 0, 0, 0,
                         width, height, 1);
}

void vr_target_clear(const struct vr_target *target, struct vr_context *context)
{
    static const GLenum attachments[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    static const GLuint zeros[4] = {0};
    const struct vr_gl *gl = &context->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->read_framebuffer);
    gl->DrawBuffers(2, attachments);
    for (int i = 0; i < 2; i++)
        gl->ClearBufferuiv(GL_COLOR, i, zeros);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}

void vr_target_use(const struct vr_target *target, struct vr_context *context, GLuint words_unit,
                   GLuint numbers_unit)
{
    const struct vr_gl *gl = &context->gl;
    gl->BindImageTexture(words_unit, target->words, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32UI);
    gl->BindImageTexture(numbers_unit, target->numbers, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RG32UI);
}

/* The triangle lies at 1/2. Depth is written only where the test is on. */
static void set_depth(const struct vr_gl *gl, enum vr_target_depth depth)
{
    if (depth == VR_TARGET_DEPTH_OFF) {
        gl->Disable(GL_DEPTH_TEST);
        return;
    }
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(depth == VR_TARGET_DEPTH_WRITE ? GL_ALWAYS : GL_GREATER);
    gl->DepthMask(depth == VR_TARGET_DEPTH_WRITE);
}

static int less(int a, int b)
{
    return a < b ? a : b;
}

void vr_target_draw(const struct vr_target *target, struct vr_context *context, int width, int height,
                    const uint32_t *flags, int tiles_across, enum vr_target_depth depth)
{
    const struct vr_gl *gl = &context->gl;
    const int edge = VR_TARGET_TILE;
    int since_flush = 0;
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->draw_framebuffer);
    gl->BindVertexArray(target->vertex_array);
    gl->Viewport(0, 0, target->width, target->height);
    set_depth(gl, depth);
    gl->Enable(GL_SCISSOR_TEST);
    for (int y = 0; y < height; y += edge)
        for (int x = 0; x < width;) {
            const uint32_t *flag = flags + (size_t)(y / edge) * (size_t)tiles_across + x / edge;
            int run = 0; /* tiles side by side go in one draw */
            while (x + run * edge < width && flag[run])
                run++;
            if (run) {
                gl->Scissor(x, y, less(width - x, run * edge), less(height - y, edge));
                gl->DrawArrays(GL_TRIANGLES, 0, 3);
                since_flush += run;
            }
            if (since_flush >= TILES_A_FLUSH) {
                gl->Flush();
                since_flush = 0;
            }
            x += (run + 1) * edge;
        }
    gl->Disable(GL_SCISSOR_TEST);
    gl->Disable(GL_DEPTH_TEST);
    gl->BindVertexArray(0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                      GL_FRAMEBUFFER_BARRIER_BIT);
}

void vr_target_read(const struct vr_target *target, struct vr_context *context, int width, int height,
                    float *rgba, int stride, uint32_t *numbers)
{
    const struct vr_gl *gl = &context->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->read_framebuffer);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, stride);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl->ReadPixels(0, 0, width, height, GL_RGBA_INTEGER, GL_UNSIGNED_INT, rgba);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, 0);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT1);
    gl->ReadPixels(0, 0, width, height, GL_RG_INTEGER, GL_UNSIGNED_INT, numbers);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}
