/* What the shared shader parts declare, set by name. Uniforms that a program does not use have location -1,
 * which OpenGL ignores. */
#include "frame.h"

#include <math.h>

#include "scene.h"

static GLint at(const struct vr_uniforms *u, const char *name)
{
    return u->gl->GetUniformLocation(u->program, name);
}

int vr_frame_use_program(const struct vr_frame *frame, const struct vr_program_source *source,
                         const char *defines, struct vr_uniforms *u, struct brick_error *err)
{
    u->gl = &frame->context->gl;
    int result = vr_programs_get(&frame->store->programs, frame->context, source, defines, &u->program, err);
    if (!result)
        u->gl->UseProgram(u->program);
    return result;
}

void vr_set_int(const struct vr_uniforms *u, const char *name, int v)
{
    u->gl->Uniform1i(at(u, name), v);
}

void vr_set_float(const struct vr_uniforms *u, const char *name, double v)
{
    u->gl->Uniform1f(at(u, name), (float)v);
}

void vr_set_double(const struct vr_uniforms *u, const char *name, double v)
{
    u->gl->Uniform1d(at(u, name), v);
}

void vr_set_ivec2(const struct vr_uniforms *u, const char *name, int x, int y)
{
    u->gl->Uniform2i(at(u, name), x, y);
}

void vr_set_ivec3(const struct vr_uniforms *u, const char *name, const int v[3])
{
    u->gl->Uniform3iv(at(u, name), 1, v);
}

void vr_set_vec3(const struct vr_uniforms *u, const char *name, const double v[3])
{
    const float f[3] = {(float)v[0], (float)v[1], (float)v[2]};
    u->gl->Uniform3fv(at(u, name), 1, f);
}

void vr_set_dvec3(const struct vr_uniforms *u, const char *name, const double v[3])
{
    u->gl->Uniform3dv(at(u, name), 1, v);
}

static int log2_of(uint32_t power)
{
    int n = 0;
    while (power > 1)
        power >>= 1, n++;
    return n;
}

void vr_set_view(const struct vr_uniforms *u, const struct brick_view *view)
{
    vr_set_dvec3(u, "origin", view->origin);
    vr_set_dvec3(u, "origin_u", view->origin_u);
    vr_set_dvec3(u, "origin_v", view->origin_v);
    vr_set_dvec3(u, "dir", view->dir);
    vr_set_dvec3(u, "dir_u", view->dir_u);
    vr_set_dvec3(u, "dir_v", view->dir_v);
}

void vr_frame_set_rays(const struct vr_frame *frame, const struct vr_uniforms *u)
{
    const struct brick_view *view = &frame->view;
    double box_high[3], clip[VR_MAX_CLIP_PLANES][4];
    for (int a = 0; a < 3; a++)
        box_high[a] = (double)frame->grid->dims[a] - 0.5;
    vr_set_view(u, view);
    u->gl->UniformMatrix3dv(at(u, "linear"), 1, GL_TRUE, &view->linear[0][0]);
    vr_set_dvec3(u, "box_high", box_high);
    vr_set_dvec3(u, "level_scale", frame->level->scale);
    vr_set_dvec3(u, "level_offset", frame->level->offset);
    vr_set_double(u, "step_mm", frame->step_mm);
    for (uint32_t p = 0; p < frame->scene->clip_count; p++)
        vr_scene_clip_plane(frame->scene, frame->grid, p, clip[p]);
    u->gl->Uniform4dv(at(u, "clip_planes"), (GLsizei)frame->scene->clip_count, &clip[0][0]);
}

void vr_frame_set_field(const struct vr_frame *frame, const struct vr_uniforms *u)
{
    const struct vr_atlas *atlas = vr_residency_atlas(frame->residency);
    const struct vr_macrocells *macrocells = vr_residency_macrocells(frame->residency);
    int last[3], bricks[3];
    for (int a = 0; a < 3; a++) {
        last[a] = (int)frame->level->dims[a] - 1;
        bricks[a] = (int)frame->level->bricks[a];
    }
    vr_set_ivec3(u, "level_last", last);
    vr_set_ivec3(u, "level_bricks", bricks);
    u->gl->Uniform2f(at(u, "atlas_texel"), 1.0f / (float)atlas->size[0], 1.0f / (float)atlas->size[1]);
    vr_set_float(u, "voxel_scale", atlas->voxels.scale);
    vr_set_float(u, "voxel_offset", atlas->voxels.offset);
    vr_set_float(u, "voxel_grains", atlas->voxels.grains);
    vr_set_ivec3(u, "slots", atlas->slots);
    vr_set_ivec3(u, "slot_size", atlas->slot_size);
    vr_set_ivec3(u, "slot_cells", macrocells->cells);
    vr_set_int(u, "plane_words", macrocells->plane_words);
    vr_set_int(u, "brick_shift", log2_of(frame->grid->edge));
    vr_set_int(u, "macro_shift", log2_of(frame->grid->macrocell));
    vr_set_int(u, "border", (int)frame->grid->border);
    vr_set_int(u, "atlas", VR_UNIT_ATLAS);
    vr_set_int(u, "pages", VR_UNIT_PAGES);
    vr_set_int(u, "macrocells", VR_UNIT_MACROCELLS);
    vr_set_float(u, "value_sign", frame->grid->slope < 0.0 ? -1.0 : 1.0);
    vr_buffer_use(vr_residency_pages(frame->residency), frame->context, VR_UNIT_PAGES);
    vr_buffer_use(&macrocells->buffer, frame->context, VR_UNIT_MACROCELLS);
    vr_atlas_use(atlas, frame->context, VR_UNIT_ATLAS);
}

void vr_frame_set_stand_ins(const struct vr_frame *frame, const struct vr_uniforms *u)
{
    GLint halvings[BRICK_MAX_LEVELS][3] = {{0}};
    for (uint32_t l = frame->scene->level; l < frame->grid->levels; l++)
        for (int a = 0; a < 3; a++)
            halvings[l][a] = log2_of((uint32_t)(frame->grid->level[l].scale[a] / frame->level->scale[a]));
    u->gl->Uniform3iv(at(u, "level_halvings"), BRICK_MAX_LEVELS, halvings[0]);
}

void vr_frame_set_shading(const struct vr_frame *frame, const struct vr_uniforms *u)
{
    const struct vr_scene *scene = frame->scene;
    const float material[4] = {(float)scene->ambient, (float)scene->diffuse, (float)scene->specular,
                               (float)scene->shininess};
    float normals[3][3];
    vr_scene_normals(frame->grid, frame->level, normals);
    u->gl->UniformMatrix3fv(at(u, "normal_matrix"), 1, GL_TRUE, &normals[0][0]);
    u->gl->Uniform4fv(at(u, "material"), 1, material);
}

int vr_frame_set_transfer(const struct vr_frame *frame, const struct vr_uniforms *u, struct brick_error *err)
{
    const struct vr_transfer_table *table = &frame->table;
    struct vr_frame_store *store = frame->store;
    int result;
    if ((result = vr_buffer_write(&store->pieces, frame->context, GL_RGBA32F, table->pieces,
                                  table->count * sizeof *table->pieces, "transfer function", err)) ||
        (result = vr_buffer_write(&store->bins, frame->context, GL_RG32UI, table->bins,
                                  table->bin_count * sizeof *table->bins, "transfer function", err)))
        return result;
    vr_buffer_use(&store->pieces, frame->context, VR_UNIT_PIECES);
    vr_buffer_use(&store->bins, frame->context, VR_UNIT_BINS);
    vr_set_int(u, "pieces", VR_UNIT_PIECES);
    vr_set_int(u, "bins", VR_UNIT_BINS);
    vr_set_float(u, "bin_origin", table->bin_origin);
    vr_set_float(u, "bin_scale", table->bin_scale);
    vr_set_float(u, "bin_last", table->bin_count - 1.0);
    u->gl->Uniform2f(at(u, "visible"), table->visible[0], table->visible[1]);
    if (!frame->prefixes)
        return BRICK_OK;
    if ((result = vr_buffer_write(&store->prefixes, frame->context, GL_RGBA32UI, frame->prefixes,
                                  table->count * sizeof *frame->prefixes, "transfer function", err)))
        return result;
    vr_buffer_use(&store->prefixes, frame->context, VR_UNIT_PREFIXES);
    vr_set_int(u, "prefixes", VR_UNIT_PREFIXES);
    return BRICK_OK;
}
