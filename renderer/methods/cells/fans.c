/* Cells seen along parallel rays: one cell's projection is every cell's, which is the paper's idea. So the
 * tetrahedra are projected once, here, and the vertex shader puts their fans wherever there is a cell;
 * lengths and scalars at the thick vertex need no more than weights of a table, and are linear over each
 * triangle. */
#include <math.h>
#include <stdlib.h>

#include "picture.h"
#include "shaders.h"

static void fans_of(const int triangles[VR_BASIS_SLOTS], struct vr_cell_shape *shape)
{
    *shape =
        (struct vr_cell_shape){.vertices = VR_BASIS_SLOTS * VR_BASIS_FAN, .tetrahedra = {VR_BASIS_SLOTS, 1}};
    for (int slot = 0; slot < VR_BASIS_SLOTS; slot++)
        for (int t = 0; t < triangles[slot]; t++) {
            const int fan = slot * VR_BASIS_FAN, vertex[3] = {VR_BASIS_THICK, t, (t + 1) % 4};
            for (int i = 0; i < 3; i++)
                shape->index[shape->indices++] = (uint8_t)(fan + vertex[i]);
        }
}

static int begin(struct vr_cells_picture *p, struct brick_error *err)
{
    struct vr_context *context = p->frame->context;
    struct vr_cell_shape shape;
    int triangles[VR_BASIS_SLOTS];
    float *table = malloc(VR_BASIS_TABLE_FLOATS * sizeof *table);
    if (!table)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the basis hexahedron");
    vr_basis_table(&p->lattice, table, triangles);
    fans_of(triangles, &shape);
    int result = vr_cell_lot_set_shape(&p->cells->lot, context, &shape, err);
    if (!result)
        result = vr_buffer_write(&p->cells->basis, context, GL_RGBA32F, table,
                                 VR_BASIS_TABLE_FLOATS * sizeof *table, "basis hexahedron", err);
    free(table);
    if (!result) {
        vr_set_int(&p->draw.draw, "basis", VR_CELLS_UNIT_BASIS);
        vr_buffer_use(&p->cells->basis, context, VR_CELLS_UNIT_BASIS);
    }
    return result;
}

/* Depths count from the volume's middle, so that floats hold them well. */
static void set_part(const struct vr_cells_picture *p)
{
    const struct vr_uniforms *u = &p->draw.draw;
    const struct vr_lattice *q = &p->lattice;
    const double across = 2.0 / p->draw.canvas->width, down = 2.0 / p->draw.canvas->height;
    double to_x[3], to_y[3], reference = q->depth[3];
    float cuts[VR_CELLS_MAX_PLANES][4];
    for (int a = 0; a < 3; a++) {
        to_x[a] = across * q->column[a];
        to_y[a] = down * q->row[a];
        reference += q->depth[a] * 0.5 * ((double)p->frame->level->dims[a] - 1.0);
    }
    const double origin[3] = {across * (q->column[3] - p->left) - 1.0, down * (q->row[3] - p->top) - 1.0,
                              q->depth[3] - reference};
    vr_set_dvec3(u, "to_x", to_x);
    vr_set_dvec3(u, "to_y", to_y);
    vr_set_dvec3(u, "to_depth", q->depth);
    vr_set_dvec3(u, "origin", origin);
    vr_set_double(u, "pixel_x", across);
    vr_set_double(u, "pixel_y", down);
    for (int i = 0; i < p->planes; i++) {
        const double *n = p->plane[i];
        double at = n[3], right = 0.0, below = 0.0, ahead = 0.0, size = 0.0;
        for (int a = 0; a < 3; a++) {
            at += n[a] * (q->origin[a] + p->left * q->right[a] + p->top * q->down[a]);
            right += n[a] * q->right[a];
            below += n[a] * q->down[a];
            ahead += n[a] * q->direction[a];
            size += fabs(n[a] * q->direction[a]);
        }
        bool along = fabs(ahead) <= 1e-12 * size;
        double scale = along ? 1.0 : -1.0 / ahead;
        cuts[i][0] = (float)(at * scale - (along ? 0.0 : reference));
        cuts[i][1] = (float)(right * scale);
        cuts[i][2] = (float)(below * scale);
        cuts[i][3] = along ? 0.0f : ahead > 0.0 ? 1.0f : -1.0f;
    }
    if (p->planes)
        u->gl->Uniform4fv(u->gl->GetUniformLocation(u->program, "cuts"), p->planes, &cuts[0][0]);
}

static const struct vr_shader_part vertex[] = {{"field.glsl", vr_shader_field},
                                               {"cells_list.glsl", vr_shader_cells_list},
                                               {"cells_fan.vert.glsl", vr_shader_cells_fan_vert}};
static const struct vr_shader_part fragment[] = {{"exponential.glsl", vr_shader_exponential},
                                                 {"transfer.glsl", vr_shader_transfer},
                                                 {"preintegrated.glsl", vr_shader_preintegrated},
                                                 {"cells_integrate.glsl", vr_shader_cells_integrate},
                                                 {"cells_fan.glsl", vr_shader_cells_fan}};

const struct vr_cells_projection vr_cells_fans = {
    .source = {vertex, 3, fragment, 5}, .segments = 1, .begin = begin, .set_part = set_part};
