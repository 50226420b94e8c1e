/* The picture's textures and the passes over all its pixels. */
#include "picture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "shaders.h"
#include "texture.h"

int vr_picture_init(struct vr_picture *p, struct vr_context *context, GLenum format, int width, int height,
                    struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    const int edge = VR_PICTURE_TILE;
    int result;
    *p = (struct vr_picture){.tiles = {(width + edge - 1) / edge, (height + edge - 1) / edge}};
    if ((result = vr_canvas_init(&p->colour, context, format, width, height, err)) ||
        (result = vr_canvas_init(&p->spans, context, GL_RGBA32UI, width, height, err)))
        goto fail;
    p->rgba = malloc((size_t)width * (size_t)height * 4 * sizeof *p->rgba);
    p->unfinished = malloc((size_t)(p->tiles[0] + 1) * (size_t)(p->tiles[1] + 1) * sizeof *p->unfinished);
    if (!p->rgba || !p->unfinished) {
        result = brick_fail(err, BRICK_ERR_MEMORY, "no memory for a picture of %d x %d", width, height);
        goto fail;
    }
    gl->GenVertexArrays(1, &p->vertex_array);
    p->depth = vr_texture_create(context, GL_DEPTH_COMPONENT24, width, height);
    gl->BindFramebuffer(GL_FRAMEBUFFER, p->colour.framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, p->depth, 0);
    bool complete = gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    gl->GenFramebuffers(1, &p->depth_framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, p->depth_framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, p->depth, 0);
    complete = complete && gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    result = vr_context_check(context, "picture buffer", err);
    if (!result && !complete)
        result =
            brick_fail(err, BRICK_ERR_UNSUPPORTED, "OpenGL (%s) cannot draw to a picture buffer of %d x %d",
                       context->renderer, width, height);
    if (!result)
        return BRICK_OK;
fail:
    vr_picture_finish(p, context);
    return result;
}

void vr_picture_finish(struct vr_picture *p, struct vr_context *context)
{
    const struct vr_gl *gl = &context->gl;
    vr_canvas_finish(&p->colour, context);
    vr_canvas_finish(&p->spans, context);
    gl->DeleteFramebuffers(1, &p->depth_framebuffer);
    gl->DeleteTextures(1, &p->depth);
    gl->DeleteVertexArrays(1, &p->vertex_array);
    free(p->rgba);
    free(p->unfinished);
    *p = (struct vr_picture){0};
}

static void draw_all(const struct vr_picture *p, const struct vr_gl *gl)
{
    gl->BindVertexArray(p->vertex_array);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->BindVertexArray(0);
}

void vr_picture_set_stack(const struct vr_frame *frame, const struct vr_stack *stack,
                          const struct vr_uniforms *u, int x, int y)
{
    const struct brick_view *v = &frame->view;
    const double *scale = frame->level->scale, *offset = frame->level->offset;
    double at[6][3];
    for (int a = 0; a < 3; a++) {
        at[0][a] = (v->origin[a] - offset[a]) / scale[a];
        at[1][a] = v->origin_u[a] / scale[a];
        at[2][a] = v->origin_v[a] / scale[a];
        at[3][a] = v->dir[a] / scale[a];
        at[4][a] = v->dir_u[a] / scale[a];
        at[5][a] = v->dir_v[a] / scale[a];
    }
    static const char *const names[6] = {"origin", "origin_u", "origin_v", "dir", "dir_u", "dir_v"};
    for (int i = 0; i < 6; i++)
        vr_set_dvec3(u, names[i], at[i]);
    vr_set_double(u, "first_depth", stack->first_mm);
    vr_set_double(u, "spacing", stack->spacing_mm);
    vr_set_ivec2(u, "part_origin", x, y);
}

int vr_picture_begin(struct vr_picture *p, const struct vr_frame *frame, const struct vr_stack *stack, int x,
                     int y, float clear, struct brick_error *err)
{
    static const struct vr_shader_part parts[] = {{"slices_stack.glsl", vr_shader_slices_stack},
                                                  {"slices_span.glsl", vr_shader_slices_span}};
    static const struct vr_program_source source = {.fragment = parts, .fragment_count = 2};
    const struct vr_gl *gl = &frame->context->gl;
    const GLfloat filled[4] = {clear, clear, clear, clear}, far = 1.0f;
    struct vr_uniforms u;
    char defines[64];
    snprintf(defines, sizeof defines, "#define CLIP_PLANES %d\n%s", VR_MAX_CLIP_PLANES,
             stack->perspective ? "#define PERSPECTIVE\n" : "");
    int result = vr_frame_use_program(frame, &source, defines, &u, err);
    if (result)
        return result;
    vr_picture_set_stack(frame, stack, &u, x, y);
    vr_set_dvec3(&u, "box_low", stack->low);
    vr_set_dvec3(&u, "box_high", stack->high);
    vr_set_int(&u, "clip_count", stack->clip_count);
    gl->Uniform4dv(gl->GetUniformLocation(u.program, "clip"), VR_MAX_CLIP_PLANES, stack->clip[0]);
    vr_set_int(&u, "slices", stack->count);
    vr_canvas_use(&p->spans, frame->context);
    draw_all(p, gl);
    vr_canvas_use(&p->colour, frame->context);
    gl->ClearBufferfv(GL_COLOR, 0, filled);
    gl->DepthMask(GL_TRUE);
    gl->ClearBufferfv(GL_DEPTH, 0, &far);
    gl->DepthMask(GL_FALSE);
    vr_texture_use(frame->context, p->spans.colour, VR_UNIT_SPANS);
    return vr_context_check(frame->context, "spans of rays", err);
}

/* Counts of unfinished tiles from the top left corner on. */
static void count_tiles(struct vr_picture *p, double termination)
{
    const int width = p->colour.width, height = p->colour.height, across = p->tiles[0] + 1;
    for (int i = 0; i < across; i++)
        p->unfinished[i] = 0;
    for (int ty = 0; ty < p->tiles[1]; ty++) {
        uint32_t *row = p->unfinished + (size_t)(ty + 1) * (size_t)across, sum = 0;
        row[0] = 0;
        for (int tx = 0; tx < p->tiles[0]; tx++) {
            bool open = false;
            for (int y = ty * VR_PICTURE_TILE; y < (ty + 1) * VR_PICTURE_TILE && y < height && !open; y++)
                for (int x = tx * VR_PICTURE_TILE; x < (tx + 1) * VR_PICTURE_TILE && x < width && !open; x++)
                    open = !(1.0f - p->rgba[4 * ((size_t)y * (size_t)width + (size_t)x) + 3] <=
                             (float)termination);
            sum += open;
            row[tx + 1] = row[tx + 1 - across] + sum;
        }
    }
}

int vr_picture_stop(struct vr_picture *p, const struct vr_frame *frame, double termination,
                    struct brick_error *err)
{
    static const struct vr_shader_part parts[] = {{"slices_stop.glsl", vr_shader_slices_stop}};
    static const struct vr_program_source source = {.fragment = parts, .fragment_count = 1};
    const struct vr_gl *gl = &frame->context->gl;
    struct vr_uniforms u;
    int result = vr_frame_use_program(frame, &source, "", &u, err);
    if (result)
        return result;
    vr_texture_use(frame->context, p->colour.colour, VR_UNIT_PICTURE);
    vr_set_int(&u, "picture", VR_UNIT_PICTURE);
    vr_set_float(&u, "termination", termination);
    gl->BindFramebuffer(GL_FRAMEBUFFER, p->depth_framebuffer);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_ALWAYS);
    gl->DepthMask(GL_TRUE);
    draw_all(p, gl);
    gl->DepthFunc(GL_LESS);
    gl->DepthMask(GL_FALSE);
    vr_texture_use(frame->context, 0, VR_UNIT_PICTURE);
    vr_canvas_read(&p->colour, frame->context, p->colour.width, p->colour.height, p->rgba, p->colour.width);
    count_tiles(p, termination);
    vr_canvas_use(&p->colour, frame->context);
    return vr_context_check(frame->context, "ending rays", err);
}

bool vr_picture_open(const struct vr_picture *p, const double low[2], const double high[2])
{
    const size_t across = (size_t)p->tiles[0] + 1;
    size_t from[2], to[2];
    for (int a = 0; a < 2; a++) {
        double first = floor(low[a] / VR_PICTURE_TILE), last = floor(high[a] / VR_PICTURE_TILE);
        from[a] = (size_t)fmin(fmax(first, 0.0), p->tiles[a]);
        to[a] = (size_t)fmin(fmax(last + 1.0, 0.0), p->tiles[a]);
    }
    const uint32_t *n = p->unfinished;
    return n[to[1] * across + to[0]] + n[from[1] * across + from[0]] !=
           n[to[1] * across + from[0]] + n[from[1] * across + to[0]];
}

int vr_picture_classify(struct vr_picture *p, const struct vr_frame *frame, struct brick_error *err)
{
    static const struct vr_shader_part parts[] = {{"exponential.glsl", vr_shader_exponential},
                                                  {"transfer.glsl", vr_shader_transfer},
                                                  {"slices_largest.glsl", vr_shader_slices_largest}};
    static const struct vr_program_source source = {.fragment = parts, .fragment_count = 3};
    const struct vr_gl *gl = &frame->context->gl;
    struct vr_canvas classified = {0};
    struct vr_uniforms u;
    char defines[64];
    snprintf(defines, sizeof defines, "#define SEARCH_STEPS %u\n", frame->table.search_steps);
    int result = vr_frame_use_program(frame, &source, defines, &u, err);
    if (result || (result = vr_canvas_init(&classified, frame->context, GL_RGBA32F, p->colour.width,
                                           p->colour.height, err)))
        return result;
    if (!(result = vr_frame_set_transfer(frame, &u, err))) {
        vr_texture_use(frame->context, p->colour.colour, VR_UNIT_PICTURE);
        vr_set_int(&u, "picture", VR_UNIT_PICTURE);
        vr_set_float(&u, "unit_mm", frame->scene->transfer->unit_mm);
        vr_canvas_use(&classified, frame->context);
        draw_all(p, gl);
        vr_texture_use(frame->context, 0, VR_UNIT_PICTURE);
        vr_canvas_read(&classified, frame->context, p->colour.width, p->colour.height, p->rgba,
                       p->colour.width);
        result = vr_context_check(frame->context, "classifying the picture", err);
    }
    vr_canvas_finish(&classified, frame->context);
    return result;
}
