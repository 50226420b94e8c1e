/* Drawing the blocks, twice: into one depth buffer their nearest front faces, into another their farthest
 * back faces.
 *
 * Nothing may be lost. The rasteriser puts corners on a grid of a fraction of a pixel, so a ray that touches
 * a block could miss its picture: blocks are drawn larger by a sixteenth of a pixel where a pixel is largest,
 * in the far corner of the volume. Depth is not interpolated but found in the fragment, as far as the ray may
 * be from where it meets the face's plane, given the rounding of float32 (bounds.frag.glsl). The plane of any
 * front face of a box, met outside the face too, comes before the box, so it does not matter which of two
 * faces the rasteriser gives a pixel on their edge. That is also why faces between two active blocks are
 * drawn: without them a wall seen at a grazing angle, where its own faces are thinner than the rasteriser's
 * grid, has holes.
 *
 * The near plane (section 7): rays of a perspective begin in one point. If that is in a block, all of them
 * begin there; if not, each enters the blocks through a face ahead of it. In a parallel projection faces
 * behind the eye are drawn too. So there are no holes to fill. */
#include "bounds.h"

#include <math.h>

#include "projection.h"
#include "shaders.h"
#include "texture.h"

enum { FIRST, LAST };

#define MARGIN_PIXELS (1.0 / 16)
#define SNAPS         4 /* or so many of the rasteriser's steps */

static void drop_textures(struct vr_bounds *b, const struct vr_gl *gl)
{
    gl->DeleteFramebuffers(2, b->framebuffer);
    gl->DeleteTextures(2, b->texture);
    gl->DeleteVertexArrays(1, &b->vertex_array);
    b->width = b->height = 0;
}

static int make_textures(struct vr_bounds *b, struct vr_context *context, int width, int height,
                         struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    bool complete = true;
    if (b->width == width && b->height == height)
        return BRICK_OK;
    drop_textures(b, gl);
    gl->GenFramebuffers(2, b->framebuffer);
    gl->GenVertexArrays(1, &b->vertex_array);
    for (int i = 0; i < 2; i++) {
        b->texture[i] = vr_texture_create(context, GL_DEPTH_COMPONENT32F, width, height);
        gl->BindFramebuffer(GL_FRAMEBUFFER, b->framebuffer[i]);
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, b->texture[i], 0);
        complete = complete && gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    }
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    int result = vr_context_check(context, "depth buffers", err);
    if (!result && !complete)
        result = brick_fail(err, BRICK_ERR_UNSUPPORTED, "OpenGL (%s) cannot draw to depth buffers of %d x %d",
                            context->renderer, width, height);
    b->width = result ? 0 : width;
    b->height = result ? 0 : height;
    return result;
}

/* How far ahead the volume reaches, in units of the view's dir; 0: it is behind. */
static double farthest_ahead(const struct vr_frame *frame, const struct vr_projection *p)
{
    double most = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        double to[3];
        for (int a = 0; a < 3; a++)
            to[a] = (corner >> a & 1 ? (double)frame->grid->dims[a] : -1.0) - p->origin[a];
        most = fmax(most, vr_dot(p->inverse[2], to));
        if (p->parallel) /* the origin moves with the pixel, but not ahead: as it is */
            most = fmax(most, 1e-300);
    }
    return most;
}

static void set_margins(struct vr_bounds *b, const struct vr_frame *frame)
{
    const struct brick_view *view = &frame->view;
    const struct brick_level *level = frame->level;
    struct vr_projection p;
    double widest = 0.0, smallest = INFINITY, eye[3], twice[3];
    GLint bits = 0;
    vr_projection_init(&p, view);
    frame->context->gl.GetIntegerv(GL_SUBPIXEL_BITS, &bits);
    const double pixels = fmax(MARGIN_PIXELS, ldexp(SNAPS, -bits)), ahead = farthest_ahead(frame, &p);
    for (int a = 0; a < 3; a++) {
        double pixel = p.parallel ? fabs(view->origin_u[a]) + fabs(view->origin_v[a])
                                  : ahead * (fabs(view->dir_u[a]) + fabs(view->dir_v[a]));
        b->margin[a] = fmax(pixels * pixel, 1e-3 * level->scale[a]);
        widest = fmax(widest, fabs(view->dir[a]) + frame->scene->width * fabs(view->dir_u[a]) +
                                  frame->scene->height * fabs(view->dir_v[a]));
        smallest = fmin(smallest, b->margin[a]);
        eye[a] = (p.origin[a] - level->offset[a]) / level->scale[a];
        twice[a] = 2.0 * b->margin[a] / level->scale[a];
    }
    b->scale = ahead > 0.0 ? exp2(-ceil(log2(ahead))) : 1.0;
    /* An eye that is in no block is farther than a margin from all that is drawn, on some axis. */
    b->nearest_ahead = 0.5 * smallest / widest;
    b->inside = !p.parallel && vr_blocks_inside(&b->blocks, frame, eye, twice);
}

int vr_bounds_begin(struct vr_bounds *b, const struct vr_frame *frame, int width, int height,
                    struct brick_error *err)
{
    bool changed = false;
    int result = make_textures(b, frame->context, width, height, err);
    if (result || (result = vr_blocks_update(&b->blocks, frame, &changed, err)))
        return result;
    if (changed && b->blocks.count)
        result = vr_buffer_write(&b->buffer, frame->context, GL_RGBA32UI, b->blocks.row,
                                 b->blocks.count * sizeof *b->blocks.row, "bounding geometry", err);
    if (result)
        b->blocks.fingerprint = 0;
    set_margins(b, frame);
    return result;
}

static int use_program(const struct vr_frame *frame, struct vr_uniforms *u, struct brick_error *err)
{
    static const struct vr_shader_part vertex = {"bounds.vert.glsl", vr_shader_bounds_vert};
    static const struct vr_shader_part fragment = {"bounds.frag.glsl", vr_shader_bounds_frag};
    static const struct vr_program_source source = {
        .vertex = &vertex, .vertex_count = 1, .fragment = &fragment, .fragment_count = 1};
    return vr_frame_use_program(frame, &source, "", u, err);
}

static void set_uniforms(const struct vr_bounds *b, const struct vr_frame *frame,
                         const struct vr_projection *p, const struct vr_uniforms *u, int x, int y)
{
    const struct brick_view *view = &frame->view;
    vr_set_dvec3(u, "origin", p->origin);
    u->gl->UniformMatrix3dv(u->gl->GetUniformLocation(u->program, "to_picture"), 1, GL_TRUE,
                            &p->inverse[0][0]);
    vr_set_dvec3(u, "level_scale", frame->level->scale);
    vr_set_dvec3(u, "level_offset", frame->level->offset);
    vr_set_dvec3(u, "margin", b->margin);
    vr_set_double(u, "cell", frame->grid->macrocell);
    vr_set_double(u, "nearest_ahead", b->nearest_ahead);
    vr_set_float(u, "depth_scale", b->scale);
    vr_set_int(u, "parallel", p->parallel);
    vr_set_ivec2(u, "tile_origin", x, y);
    vr_set_ivec2(u, "layer_size", b->width, b->height);
    vr_set_vec3(u, "eye", view->origin);
    vr_set_vec3(u, "eye_u", view->origin_u);
    vr_set_vec3(u, "eye_v", view->origin_v);
    vr_set_dvec3(u, "dir", view->dir);
    vr_set_vec3(u, "way", view->dir);
    vr_set_vec3(u, "way_u", view->dir_u);
    vr_set_vec3(u, "way_v", view->dir_v);
    vr_set_int(u, "rows", VR_UNIT_METHOD);
    vr_buffer_use(&b->buffer, frame->context, VR_UNIT_METHOD);
}

int vr_bounds_draw(const struct vr_bounds *b, const struct vr_frame *frame, int x, int y,
                   struct brick_error *err)
{
    const struct vr_gl *gl = &frame->context->gl;
    const GLfloat start = b->inside ? 0.0f : 1.0f, none = 0.0f;
    struct vr_projection p;
    struct vr_uniforms u;
    int result = use_program(frame, &u, err);
    if (result)
        return result;
    vr_projection_init(&p, &frame->view);
    set_uniforms(b, frame, &p, &u, x, y);
    gl->BindVertexArray(b->vertex_array);
    gl->Viewport(0, 0, b->width, b->height);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthMask(GL_TRUE);
    for (int pass = FIRST; pass <= LAST; pass++) {
        gl->BindFramebuffer(GL_FRAMEBUFFER, b->framebuffer[pass]);
        gl->ClearBufferfv(GL_DEPTH, 0, pass == FIRST ? &start : &none);
        gl->DepthFunc(pass == FIRST ? GL_LESS : GL_GREATER);
        vr_set_int(&u, "front", pass == FIRST);
        if (pass == LAST || !b->inside)
            gl->DrawArrays(GL_TRIANGLES, 0, (GLsizei)((pass == FIRST ? 18 : 36) * b->blocks.count));
    }
    gl->Disable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->BindVertexArray(0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    return vr_context_check(frame->context, "drawing the bounding geometry", err);
}

void vr_bounds_use(const struct vr_bounds *b, const struct vr_frame *frame, const struct vr_uniforms *u)
{
    static const char *const names[2] = {"bounds_first", "bounds_last"};
    for (int i = 0; i < 2; i++) {
        vr_texture_use(frame->context, b->texture[i], VR_UNIT_METHOD + (GLuint)i);
        vr_set_int(u, names[i], VR_UNIT_METHOD + i);
    }
    vr_set_double(u, "bounds_ahead", 1.0 / b->scale);
}

void vr_bounds_finish(struct vr_bounds *b, struct vr_context *context)
{
    vr_blocks_finish(&b->blocks);
    vr_buffer_finish(&b->buffer, context);
    drop_textures(b, &context->gl);
    *b = (struct vr_bounds){0};
}
