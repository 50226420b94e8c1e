/* Cells seen in perspective: no two look the same, so there is no basis to share, and over a projected
 * triangle neither the length of a tetrahedron nor the scalars at its ends are linear. So only a cell's box
 * is projected, and each of its pixels finds in double precision, from the ray itself, where that enters and
 * leaves the cell, and there the two faces at most of the tetrahedra in between (cell projection that casts
 * rays inside the cell, as Weiler et al. 2003, whom the paper compares itself with). Neighbours find the same
 * for the face between them: their pieces of a ray fit together whatever the rasteriser rounds.
 *
 * Of the box the faces towards which rays leave are drawn: each ray leaves through one of them, ahead of the
 * eye, wherever that is, also inside. The box is drawn a little larger, by more than a rasteriser rounds
 * corners by: a pixel that it has too many finds nothing. */
#include <math.h>

#include "picture.h"
#include "projection.h"
#include "shaders.h"

/* Four times what corners are rounded by. */
#define MARGIN_PIXELS (4.0 / 256.0)

/* Triangles of all six faces, counter-clockwise from outside; culling leaves those seen from inside. */
static void box_of(const struct vr_lattice *lattice, struct vr_cell_shape *shape)
{
    double normal[3];
    *shape = (struct vr_cell_shape){.vertices = 8, .tetrahedra = {5, 6}};
    for (int a = 0; a < 3; a++)
        for (int high = 0; high < 2; high++) {
            int at = high << a, u = 1 << (a + 1 + !high) % 3, v = 1 << (a + 1 + high) % 3;
            const int corner[6] = {at, at | u, at | u | v, at, at | u | v, at | v};
            for (int i = 0; i < 6; i++)
                shape->index[shape->indices++] = (uint8_t)corner[i];
        }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        normal[i] = lattice->right[j] * lattice->down[k] - lattice->right[k] * lattice->down[j];
    }
    /* The framebuffer's rows go down where the picture's do, so OpenGL sees the picture from behind. */
    shape->cull = vr_dot(normal, lattice->direction) > 0.0 ? GL_BACK : GL_FRONT;
}

static int begin(struct vr_cells_picture *p, struct brick_error *err)
{
    const struct vr_uniforms *u = &p->draw.draw;
    const struct vr_lattice *q = &p->lattice;
    const double *const linear = &p->frame->view.linear[0][0], *const scale = p->frame->level->scale;
    double ahead_mm[3] = {0}, right_mm[3] = {0}, down_mm[3] = {0}, wider[3];
    struct vr_cell_shape shape;
    for (int a = 0; a < 3; a++) {
        for (int i = 0; i < 3; i++) {
            double mm = linear[3 * i + a] * scale[a];
            ahead_mm[i] += mm * q->direction[a];
            right_mm[i] += mm * q->right[a];
            down_mm[i] += mm * q->down[a];
        }
        wider[a] = MARGIN_PIXELS * (fabs(q->right[a]) + fabs(q->down[a]));
    }
    vr_set_dvec3(u, "eye", q->origin);
    vr_set_dvec3(u, "ahead", q->direction);
    vr_set_dvec3(u, "right", q->right);
    vr_set_dvec3(u, "down", q->down);
    vr_set_vec3(u, "ahead_mm", ahead_mm);
    vr_set_vec3(u, "right_mm", right_mm);
    vr_set_vec3(u, "down_mm", down_mm);
    vr_set_vec3(u, "wider", wider);
    vr_set_dvec3(u, "to_depth", q->depth);
    if (p->planes)
        u->gl->Uniform4dv(u->gl->GetUniformLocation(u->program, "cuts"), p->planes, &p->plane[0][0]);
    box_of(q, &shape);
    return vr_cell_lot_set_shape(&p->cells->lot, p->frame->context, &shape, err);
}

/* The picture's place times the depth, in the viewport's [-1,1]. */
static void set_part(const struct vr_cells_picture *p)
{
    const struct vr_uniforms *u = &p->draw.draw;
    const struct vr_lattice *q = &p->lattice;
    const double across = 2.0 / p->draw.canvas->width, down = 2.0 / p->draw.canvas->height;
    double to_x[3], to_y[3];
    for (int a = 0; a < 3; a++) {
        to_x[a] = across * (q->column[a] - p->left * q->depth[a]) - q->depth[a];
        to_y[a] = down * (q->row[a] - p->top * q->depth[a]) - q->depth[a];
    }
    vr_set_dvec3(u, "to_x", to_x);
    vr_set_dvec3(u, "to_y", to_y);
    vr_set_ivec2(u, "part", p->left, p->top);
}

static const struct vr_shader_part vertex[] = {{"field.glsl", vr_shader_field},
                                               {"cells_list.glsl", vr_shader_cells_list},
                                               {"cells_box.vert.glsl", vr_shader_cells_box_vert}};
static const struct vr_shader_part fragment[] = {{"exponential.glsl", vr_shader_exponential},
                                                 {"field.glsl", vr_shader_field},
                                                 {"transfer.glsl", vr_shader_transfer},
                                                 {"preintegrated.glsl", vr_shader_preintegrated},
                                                 {"cells_integrate.glsl", vr_shader_cells_integrate},
                                                 {"cells_box.glsl", vr_shader_cells_box}};

const struct vr_cells_projection vr_cells_boxes = {
    .source = {vertex, 3, fragment, 6}, .segments = 3, .begin = begin, .set_part = set_part};
