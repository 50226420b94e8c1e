/* Meshes are rasterised, by OpenGL's rules for which pixels, and by double precision for how far
 * (mesh.frag.glsl). Depth is t over the farthest there is, in 32-bit floats: of two triangles whose distances
 * differ by more than 2^-24 of themselves the nearer is seen. */
#include "meshes.h"

#include <math.h>
#include <stdio.h>

#include "frame.h"
#include "projection.h"
#include "scene.h"
#include "shaders.h"
#include "texture.h"

enum { UNIT_POSITIONS = VR_UNIT_METHOD, UNIT_TRIANGLES, UNIT_NORMALS, UNIT_COLOURS };

static int write_mesh(struct vr_mesh_buffers *to, struct vr_context *context, const struct brick_mesh *mesh,
                      struct brick_error *err)
{
    uint64_t n = 3 * mesh->vertices;
    int result = vr_buffer_write(&to->positions, context, GL_RG32UI, mesh->position_mm, n * sizeof(double),
                                 "a mesh", err);
    if (!result)
        result = vr_buffer_write(&to->triangles, context, GL_R32UI, mesh->triangle,
                                 3 * mesh->triangles * sizeof(uint32_t), "a mesh", err);
    if (!result && mesh->normal)
        result =
            vr_buffer_write(&to->normals, context, GL_R32F, mesh->normal, n * sizeof(float), "a mesh", err);
    if (!result && mesh->colour)
        result =
            vr_buffer_write(&to->colours, context, GL_R32F, mesh->colour, n * sizeof(float), "a mesh", err);
    brick_mesh_bounds(mesh, to->low_mm, to->high_mm);
    return result;
}

static GLuint attach_texture(struct vr_context *context, GLenum format, GLenum attachment, int width,
                             int height)
{
    GLuint texture = vr_texture_create(context, format, width, height);
    context->gl.FramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture, 0);
    return texture;
}

static void drop_layer(struct vr_mesh_layer *layer, const struct vr_gl *gl)
{
    gl->DeleteFramebuffers(1, &layer->framebuffer);
    gl->DeleteTextures(1, &layer->way);
    gl->DeleteTextures(1, &layer->colour);
    gl->DeleteTextures(1, &layer->depth);
    gl->DeleteVertexArrays(1, &layer->vertex_array);
    layer->framebuffer = layer->way = layer->colour = layer->depth = layer->vertex_array = 0;
    layer->width = layer->height = 0;
}

static int make_layer(struct vr_mesh_layer *layer, struct vr_context *context, int width, int height,
                      struct brick_error *err)
{
    static const GLenum drawn[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    const struct vr_gl *gl = &context->gl;
    if (layer->width == width && layer->height == height)
        return BRICK_OK;
    drop_layer(layer, gl);
    gl->GenVertexArrays(1, &layer->vertex_array);
    gl->GenFramebuffers(1, &layer->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, layer->framebuffer);
    layer->colour = attach_texture(context, GL_RGBA32F, GL_COLOR_ATTACHMENT0, width, height);
    layer->way = attach_texture(context, GL_RG32UI, GL_COLOR_ATTACHMENT1, width, height);
    layer->depth = attach_texture(context, GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT, width, height);
    gl->DrawBuffers(2, drawn);
    bool complete = gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    int result = vr_context_check(context, "meshes' picture buffer", err);
    if (!result && !complete)
        result = brick_fail(err, BRICK_ERR_UNSUPPORTED, "OpenGL (%s) cannot draw meshes to %d x %d pixels",
                            context->renderer, width, height);
    if (result) {
        drop_layer(layer, gl);
        return result;
    }
    layer->width = width;
    layer->height = height;
    return BRICK_OK;
}

int vr_meshes_begin(const struct vr_frame *frame, int width, int height, struct brick_error *err)
{
    struct vr_mesh_layer *layer = &frame->store->meshes;
    const uint64_t number = frame->scene->meshes_number;
    int result = make_layer(layer, frame->context, width, height, err);
    if (result || (number && number == layer->number))
        return result;
    layer->number = 0;
    for (uint32_t m = 0; m < frame->scene->mesh_count && !result; m++)
        result = write_mesh(&layer->mesh[m], frame->context, frame->scene->meshes[m].mesh, err);
    if (!result)
        layer->number = number;
    return result;
}

/* At least the distance of every point of a mesh from the eye, or the plane of eyes. */
static double farthest(const struct vr_frame *frame, const struct vr_projection *p, const double ahead[3])
{
    double far = 0.0;
    for (uint32_t m = 0; m < frame->scene->mesh_count; m++) {
        const struct vr_mesh_buffers *mesh = &frame->store->meshes.mesh[m];
        for (int corner = 0; corner < 8; corner++) {
            double way = 0.0, distance = 0.0;
            for (int i = 0; i < 3; i++) {
                double to = ((corner >> i & 1) ? mesh->high_mm : mesh->low_mm)[i] - p->origin[i];
                way += to * ahead[i];
                distance = hypot(distance, to);
            }
            far = fmax(far, p->parallel ? way : distance);
        }
    }
    return 1.000001 * far;
}

static int use_program(const struct vr_frame *frame, const struct brick_mesh *mesh, struct vr_uniforms *u,
                       struct brick_error *err)
{
    static const struct vr_shader_part vertex[] = {{"mesh.glsl", vr_shader_mesh},
                                                   {"mesh.vert.glsl", vr_shader_mesh_vert}},
                                       fragment[] = {{"mesh.glsl", vr_shader_mesh},
                                                     {"exponential.glsl", vr_shader_exponential},
                                                     {"shading.glsl", vr_shader_shading},
                                                     {"mesh.frag.glsl", vr_shader_mesh_frag}};
    static const struct vr_program_source source = {vertex, sizeof vertex / sizeof *vertex, fragment,
                                                    sizeof fragment / sizeof *fragment};
    char defines[64];
    snprintf(defines, sizeof defines, "%s%s", mesh->normal ? "#define MESH_NORMALS\n" : "",
             mesh->colour ? "#define MESH_COLOURS\n" : "");
    return vr_frame_use_program(frame, &source, defines, u, err);
}

static int draw_mesh(const struct vr_frame *frame, uint32_t index, const struct brick_view *world,
                     const struct vr_projection *p, double far, int x, int y, struct brick_error *err)
{
    static const GLfloat identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const struct vr_mesh *mesh = &frame->scene->meshes[index];
    const struct vr_mesh_layer *layer = &frame->store->meshes;
    const struct vr_mesh_buffers *buffers = &layer->mesh[index];
    struct vr_uniforms u;
    int result = use_program(frame, mesh->mesh, &u, err);
    if (result)
        return result;
    vr_set_view(&u, world);
    vr_frame_set_shading(frame, &u);
    u.gl->UniformMatrix3fv(u.gl->GetUniformLocation(u.program, "normal_matrix"), 1, GL_FALSE, identity);
    vr_set_dvec3(&u, "viewpoint", p->origin);
    u.gl->UniformMatrix3dv(u.gl->GetUniformLocation(u.program, "to_picture"), 1, GL_TRUE, &p->inverse[0][0]);
    vr_set_int(&u, "parallel", p->parallel);
    vr_set_ivec2(&u, "layer_size", layer->width, layer->height);
    vr_set_ivec2(&u, "tile_origin", x, y);
    vr_set_double(&u, "farthest_mm", far);
    vr_set_vec3(&u, "rgb", mesh->rgb);
    vr_set_int(&u, "positions", UNIT_POSITIONS);
    vr_set_int(&u, "triangles", UNIT_TRIANGLES);
    vr_set_int(&u, "normals", UNIT_NORMALS);
    vr_set_int(&u, "colours", UNIT_COLOURS);
    vr_buffer_use(&buffers->positions, frame->context, UNIT_POSITIONS);
    vr_buffer_use(&buffers->triangles, frame->context, UNIT_TRIANGLES);
    if (mesh->mesh->normal)
        vr_buffer_use(&buffers->normals, frame->context, UNIT_NORMALS);
    if (mesh->mesh->colour)
        vr_buffer_use(&buffers->colours, frame->context, UNIT_COLOURS);
    u.gl->DrawArrays(GL_TRIANGLES, 0, (GLsizei)(3 * mesh->mesh->triangles));
    return vr_context_check(frame->context, "drawing a mesh", err);
}

int vr_meshes_draw(const struct vr_frame *frame, int x, int y, struct brick_error *err)
{
    static const GLuint nowhere[4] = {0, 0x7ff00000u}; /* infinity */
    static const GLfloat nothing[4] = {0}, deepest = 1.0f;
    const struct vr_mesh_layer *layer = &frame->store->meshes;
    const struct vr_gl *gl = &frame->context->gl;
    struct brick_view world;
    struct vr_projection p;
    int result = BRICK_OK;

    vr_scene_world_view(&frame->view, frame->grid, &world);
    vr_projection_init(&p, &world);
    double far = farthest(frame, &p, world.dir);
    gl->BindFramebuffer(GL_FRAMEBUFFER, layer->framebuffer);
    gl->BindVertexArray(layer->vertex_array);
    gl->Viewport(0, 0, layer->width, layer->height);
    gl->DepthMask(GL_TRUE); /* clearing heeds it, too */
    gl->DepthFunc(GL_LESS);
    gl->ClearBufferfv(GL_COLOR, 0, nothing);
    gl->ClearBufferuiv(GL_COLOR, 1, nowhere);
    gl->ClearBufferfv(GL_DEPTH, 0, &deepest);
    gl->Enable(GL_DEPTH_TEST);
    for (uint32_t m = 0; m < frame->scene->mesh_count && far > 0.0 && !result; m++)
        result = draw_mesh(frame, m, &world, &p, far, x, y, err);
    gl->Disable(GL_DEPTH_TEST);
    gl->BindVertexArray(0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    return result;
}

void vr_meshes_use(const struct vr_frame *frame, const struct vr_uniforms *u)
{
    vr_texture_use(frame->context, frame->store->meshes.way, VR_UNIT_MESH_WAY);
    vr_texture_use(frame->context, frame->store->meshes.colour, VR_UNIT_MESH_COLOUR);
    vr_set_int(u, "mesh_way", VR_UNIT_MESH_WAY);
    vr_set_int(u, "mesh_colour", VR_UNIT_MESH_COLOUR);
}

void vr_meshes_finish(struct vr_mesh_layer *layer, struct vr_context *context)
{
    drop_layer(layer, &context->gl);
    for (uint32_t m = 0; m < VR_MAX_MESHES; m++) {
        vr_buffer_finish(&layer->mesh[m].positions, context);
        vr_buffer_finish(&layer->mesh[m].triangles, context);
        vr_buffer_finish(&layer->mesh[m].normals, context);
        vr_buffer_finish(&layer->mesh[m].colours, context);
    }
}
