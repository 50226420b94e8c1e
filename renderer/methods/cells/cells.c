/* Projected tetrahedra of a regular grid (Maximo, Marroquim, Farias and Esperanca, "GPU-based cell projection
 * for large structured data sets", 2008), brick by brick: the bricks that the transfer function makes
 * visible, from back to front, as many at a time as the atlas holds; in each the macrocells, in each the
 * cells. What is blended into a pixel, and in which order, depends on neither bricks nor atlas. How a cell is
 * drawn is up to the projection: picture.h. */
#include "picture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "method.h"
#include "psi.h"
#include "shaders.h"

#define PART_EDGE 1024
#define PSI_EDGE  512 /* as cells_integrate.glsl has it */
#define EXP_STEPS 256
#define EXP_WHOLE 88
/* Pieces of a transfer function that a ray may cross for one fragment: llvmpipe ends all loops of a shader
 * after 65535 turns, of 16 rays at once. */
#define MAX_EXACT_PIECES 3000

static void add_plane(struct vr_cells_picture *p, double a, double b, double c, double d)
{
    const double plane[4] = {a, b, c, d};
    memcpy(p->plane[p->planes++], plane, sizeof plane);
}

/* What cuts cells: clip planes; of parallel rays the plane where they begin, where it meets the box; level
 * 0's box where a coarser level, its size rounded up, sticks out. */
static void find_planes(struct vr_cells_picture *p)
{
    const struct brick_level *level = p->frame->level;
    const double *depth = p->lattice.depth;
    double nearest = depth[3];
    for (uint32_t i = 0; i < p->frame->scene->clip_count; i++)
        vr_scene_level_plane(p->frame->scene, p->frame->grid, level, i, p->plane[p->planes++]);
    for (int a = 0; a < 3; a++) {
        double end = ((double)p->frame->grid->dims[a] - 0.5 - level->offset[a]) / level->scale[a];
        nearest += fmin(-0.5 * depth[a], end * depth[a]);
        if (end < (double)level->dims[a] - 0.5)
            add_plane(p, a == 0 ? -1.0 : 0.0, a == 1 ? -1.0 : 0.0, a == 2 ? -1.0 : 0.0, end);
    }
    if (nearest < 0.0 && !p->lattice.perspective)
        add_plane(p, depth[0], depth[1], depth[2], depth[3]);
}

/* The part's sides, and what is ahead: column - left >= 0 and so on, times the depth in a perspective. */
static void find_sides(struct vr_cells_picture *p)
{
    const struct vr_lattice *q = &p->lattice;
    static const double one[4] = {0, 0, 0, 1};
    const double *const times = q->perspective ? q->depth : one;
    for (int i = 0; i < 4; i++) {
        p->side[0][i] = q->column[i] - p->left * times[i];
        p->side[1][i] = (p->left + p->width) * times[i] - q->column[i];
        p->side[2][i] = q->row[i] - p->top * times[i];
        p->side[3][i] = (p->top + p->height) * times[i] - q->row[i];
        p->side[4][i] = q->depth[i];
    }
}

static bool any_inside(const double (*plane)[4], int planes, const double low[3], const double high[3])
{
    for (int i = 0; i < planes; i++) {
        double most = plane[i][3];
        for (int a = 0; a < 3; a++)
            most += fmax(plane[i][a] * low[a], plane[i][a] * high[a]);
        if (most < 0.0)
            return false;
    }
    return true;
}

/* Can the box show in this part of the picture? */
static bool box_visible(const void *context, const double low[3], const double high[3])
{
    const struct vr_cells_picture *p = context;
    return any_inside(p->side, VR_CELLS_SIDES, low, high) && any_inside(p->plane, p->planes, low, high);
}

/* Bricks of the list that can show, to its front. */
static size_t cull_bricks(const struct vr_cells_picture *p, uint32_t *bricks, size_t count)
{
    const struct brick_grid *grid = p->frame->grid;
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        struct brick_place place;
        double low[3], high[3];
        brick_grid_place(grid, p->frame->level->first_brick + bricks[i], &place);
        for (int a = 0; a < 3; a++) {
            low[a] = (double)(place.lo[a] + (int64_t)grid->border) - 0.5;
            high[a] = low[a] + 0.5 + place.core[a];
        }
        if (box_visible(p, low, high))
            bricks[n++] = bricks[i];
    }
    return n;
}

static int draw_lot(struct vr_cells_picture *p, struct brick_error *err)
{
    return vr_cell_lot_draw(&p->cells->lot, &p->draw, p->report, err);
}

/* One resident brick to the lot, which is drawn whenever it is full. */
static int add_brick(struct vr_cells_picture *p, uint32_t brick, struct brick_error *err)
{
    const struct vr_frame *frame = p->frame;
    const struct vr_atlas *atlas = vr_residency_atlas(frame->residency);
    const struct vr_macrocells *macrocells = vr_residency_macrocells(frame->residency);
    struct vr_cell_lot *lot = &p->cells->lot;
    uint32_t slot = vr_residency_slot(frame->residency, brick), at[3];
    const struct vr_lattice *q = &p->lattice;
    struct vr_cell_walk walk = {.whole = q->perspective, .visible = box_visible, .visible_context = p};
    struct brick_place place;
    int first[3], texel[3], result;
    bool opened = false;
    brick_grid_place(frame->grid, frame->level->first_brick + brick, &place);
    vr_cell_walk_init(&walk, frame->grid, &place);
    vr_atlas_slot_place(atlas, slot, at);
    for (int a = 0; a < 3; a++) {
        walk.eye[a] = q->perspective ? q->origin[a] : q->direction[a] > 0.0 ? -INFINITY : INFINITY;
        first[a] = (int)walk.first[a];
        texel[a] = (int)at[a] * atlas->slot_size[a] + (int)frame->grid->border;
    }
    if (frame->quality->skip)
        walk.active = macrocells->words + (size_t)slot * 2 * (size_t)macrocells->plane_words;
    walk.macro_strides[0] = (uint32_t)macrocells->cells[0];
    walk.macro_strides[1] = (uint32_t)(macrocells->cells[0] * macrocells->cells[1]);
    uint32_t turns = walk.macrocells[0] * walk.macrocells[1] * walk.macrocells[2];
    for (uint32_t turn = 0; turn < turns; turn++) {
        if (!vr_cell_lot_has_room(lot, vr_cell_walk_most(&walk))) {
            if ((result = draw_lot(p, err)))
                return result;
            opened = false;
        }
        if (!opened)
            vr_cell_lot_open_run(lot, first, texel);
        opened = true;
        lot->count += vr_cell_walk_macrocell(&walk, turn, lot->entries + lot->count);
    }
    return BRICK_OK;
}

/* All bricks, from back to front. */
static int draw_bricks(struct vr_cells_picture *p, struct brick_error *err)
{
    struct vr_residency *residency = p->frame->residency;
    const struct vr_atlas *atlas = vr_residency_atlas(residency);
    const uint32_t *order;
    size_t count, n;
    int result = vr_residency_order(residency, true, &order, &count, err);
    uint32_t *bricks = malloc((count ? count : 1) * sizeof *bricks);
    if (!result && !bricks)
        result = brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of %zu bricks", count);
    if (result)
        goto done;
    memcpy(bricks, order, count * sizeof *bricks);
    count = cull_bricks(p, bricks, count);
    for (size_t i = 0; i < count && !result; i += n) {
        n = count - i < atlas->count ? count - i : atlas->count;
        result = vr_residency_hold(residency, bricks + i, n, true, err);
        vr_atlas_use(atlas, p->frame->context, VR_UNIT_ATLAS);
        uint64_t start_ns = brick_now_ns();
        double seconds = p->report->seconds_setup + p->report->seconds_draw;
        for (size_t b = 0; b < n && !result; b++)
            result = add_brick(p, bricks[i + b], err);
        if (!result)
            result = draw_lot(p, err);
        p->report->passes++;
        /* What the lots did not count: walking. */
        seconds = p->report->seconds_setup + p->report->seconds_draw - seconds;
        p->report->seconds_setup += fmax(1e-9 * (double)(brick_now_ns() - start_ns) - seconds, 0.0);
    }
done:
    p->cells->lot.count = p->cells->lot.run_count = 0;
    free(bricks);
    return result;
}

static int draw_parts(struct vr_cells_picture *p, struct brick_error *err)
{
    struct vr_context *context = p->frame->context;
    struct vr_canvas canvas = {0};
    int width = (int)p->image->width, height = (int)p->image->height;
    int tw = width < PART_EDGE ? width : PART_EDGE, th = height < PART_EDGE ? height : PART_EDGE;
    int result = vr_canvas_init(&canvas, context, GL_RGBA32F, tw, th, err);
    p->draw.canvas = &canvas;
    for (p->top = 0; !result && p->top < height; p->top += th)
        for (p->left = 0; !result && p->left < width; p->left += tw) {
            p->width = width - p->left < tw ? width - p->left : tw;
            p->height = height - p->top < th ? height - p->top : th;
            find_sides(p);
            p->draw.draw.gl->UseProgram(p->draw.draw.program);
            p->projection->set_part(p);
            vr_canvas_clear(&canvas, context);
            if ((result = draw_bricks(p, err)))
                break;
            vr_canvas_read(&canvas, context, p->width, p->height,
                           p->image->rgba + 4 * ((size_t)p->top * p->image->width + (size_t)p->left), width);
            result = vr_context_check(context, "reading the picture", err);
        }
    vr_canvas_finish(&canvas, context);
    return result;
}

/* Piece i of the transfer function: how many before it are not transparent throughout. */
static int write_shown(struct vr_buffer *buffer, const struct vr_frame *frame, struct brick_error *err)
{
    const struct vr_transfer_table *table = &frame->table;
    uint32_t *before = malloc((table->count + 1) * sizeof *before);
    if (!before)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a transfer function of %u pieces",
                          table->count);
    before[0] = 0;
    for (uint32_t i = 0; i < table->count; i++)
        before[i + 1] = before[i] + (table->pieces[i].sigma != 0.0f || table->pieces[i].sigma_slope != 0.0f);
    int result = vr_buffer_write(buffer, frame->context, GL_R32UI, before,
                                 (table->count + 1) * sizeof *before, "transfer function", err);
    free(before);
    return result;
}

static int write_psi(struct vr_buffer *buffer, struct vr_context *context, struct brick_error *err)
{
    const size_t bytes = PSI_EDGE * PSI_EDGE * sizeof(float);
    float *table = buffer->name ? NULL : malloc(bytes);
    if (buffer->name)
        return BRICK_OK;
    if (!table)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a table of %d x %d", PSI_EDGE, PSI_EDGE);
    vr_psi_table(table, PSI_EDGE);
    int result = vr_buffer_write(buffer, context, GL_R32F, table, bytes, "partial pre-integration", err);
    free(table);
    return result;
}

static int write_exponentials(struct vr_buffer *buffer, struct vr_context *context, struct brick_error *err)
{
    float table[EXP_STEPS + 1 + EXP_WHOLE];
    for (int i = 0; i <= EXP_STEPS; i++)
        table[i] = (float)exp(-(double)i / EXP_STEPS);
    for (int i = 0; i < EXP_WHOLE; i++)
        table[EXP_STEPS + 1 + i] = (float)exp(-(double)i);
    return buffer->name ? BRICK_OK
                        : vr_buffer_write(buffer, context, GL_R32F, table, sizeof table, "exponential", err);
}

static int use_programs(struct vr_cells_picture *p, struct brick_error *err)
{
    static const struct vr_shader_part look[] = {{"field.glsl", vr_shader_field},
                                                 {"cells_list.glsl", vr_shader_cells_list},
                                                 {"transfer.glsl", vr_shader_transfer},
                                                 {"cells_shown.glsl", vr_shader_cells_shown}};
    static const struct vr_program_source look_source = {NULL, 0, look, 4};
    static const char *const integrations[] = {"PREFIX", "EXACT", "PSI", "EXP", "AVERAGE", "SCALAR"};
    char defines[VR_FRAME_DEFINES_BYTES + 512];
    size_t n = vr_frame_defines(p->frame, defines);
    snprintf(defines + n, sizeof defines - n, "#define ROW %d\n", VR_CELL_LOT_ROW);
    int result = vr_frame_use_program(p->frame, &look_source, defines, &p->draw.look, err);
    int m = snprintf(
        defines + n, sizeof defines - n,
        "#define SLOTS %d\n#define FAN %d\n#define TEXELS %d\n"
        "#define INTEGRATION_EXACT 0\n#define INTEGRATION_PSI 1\n#define INTEGRATION_EXP 2\n"
        "#define INTEGRATION_AVERAGE 3\n#define INTEGRATION_SCALAR 4\n#define INTEGRATION_PREFIX 5\n"
        "#define INTEGRATION INTEGRATION_%s\n",
        VR_BASIS_SLOTS, VR_BASIS_FAN, VR_BASIS_TEXELS, integrations[p->frame->quality->cells_integration]);
    if (p->planes)
        snprintf(defines + n + m, sizeof defines - n - (size_t)m, "#define CUTS %d\n", p->planes);
    return result ? result
                  : vr_frame_use_program(p->frame, &p->projection->source, defines, &p->draw.draw, err);
}

/* What both programs read, whatever the part. */
static int set_uniforms(struct vr_cells_picture *p, struct brick_error *err)
{
    const struct vr_frame *frame = p->frame;
    struct vr_context *context = frame->context;
    struct vr_cells_state *c = p->cells;
    const bool exp = frame->quality->cells_integration == VR_CELLS_EXP;
    const struct vr_uniforms *const both[2] = {&p->draw.look, &p->draw.draw};
    int result;
    for (int i = 0; i < 2; i++) {
        context->gl.UseProgram(both[i]->program);
        vr_frame_set_field(frame, both[i]);
        if ((result = vr_frame_set_transfer(frame, both[i], err)))
            return result;
        vr_set_int(both[i], "cells", VR_CELLS_UNIT_LIST);
        vr_set_int(both[i], "shown", VR_CELLS_UNIT_SHOWN);
        vr_set_int(both[i], "psi_table", VR_CELLS_UNIT_TABLE);
        vr_set_int(both[i], "exp_table", VR_CELLS_UNIT_TABLE);
        vr_set_int(both[i], "piece_count", (int)frame->table.count);
    }
    if ((result = write_shown(&c->shown, frame, err)) || (result = p->projection->begin(p, err)) ||
        (exp && (result = write_exponentials(&c->exponentials, context, err))) ||
        (frame->quality->cells_integration == VR_CELLS_PSI && (result = write_psi(&c->psi, context, err))))
        return result;
    vr_buffer_use(&c->shown, context, VR_CELLS_UNIT_SHOWN);
    vr_buffer_use(exp ? &c->exponentials : &c->psi, context, VR_CELLS_UNIT_TABLE);
    p->draw.unit = VR_CELLS_UNIT_LIST;
    p->draw.select = frame->quality->skip || brick_volume_stats(frame->volume)->nonfinite;
    return BRICK_OK;
}

static int check(const struct vr_cells_picture *p, struct brick_error *err)
{
    const struct vr_frame *frame = p->frame;
    const unsigned most = MAX_EXACT_PIECES / (unsigned)p->projection->segments;
    if (frame->scene->mode != BRICK_MODE_DVR)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "projected cells render dvr only, unshaded");
    if ((unsigned)frame->quality->cells_integration >= VR_CELLS_INTEGRATIONS)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "integration %d of cells does not exist",
                          (int)frame->quality->cells_integration);
    if (frame->quality->cells_integration == VR_CELLS_EXACT && frame->table.count > most)
        return brick_fail(
            err, BRICK_ERR_UNSUPPORTED,
            "the transfer function has %u pieces, more than the %u that cells cut at one by one: choose "
            "prefix integrals, or fewer points",
            frame->table.count, most);
    return BRICK_OK;
}

static int draw(void *state, struct vr_frame *frame, struct brick_image *image, struct vr_report *report,
                struct brick_error *err)
{
    struct vr_cells_picture p = {.cells = state, .frame = frame, .image = image, .report = report};
    uint64_t start_ns = brick_now_ns();
    int result;
    vr_lattice_init(&p.lattice, &frame->view, frame->level);
    p.projection = p.lattice.perspective ? &vr_cells_boxes : &vr_cells_fans;
    if ((result = check(&p, err)))
        return result;
    if (frame->quality->cells_integration == VR_CELLS_PREFIX && !frame->prefixes &&
        (result = vr_prefixes_create(&frame->prefixes, &frame->table, err)))
        return result;
    p.draw.frame = frame;
    report->tetrahedra = vr_cell_tetrahedra(frame->level);
    find_planes(&p);
    if (!p.cells->lot.entries && (result = vr_cell_lot_init(&p.cells->lot, frame->context, err)))
        return result;
    if (!(result = use_programs(&p, err)))
        result = set_uniforms(&p, err);
    report->seconds_setup = 1e-9 * (double)(brick_now_ns() - start_ns);
    if (!result)
        result = draw_parts(&p, err);
    frame->context->gl.UseProgram(0);
    return result;
}

static void finish(void *state, struct vr_context *context)
{
    struct vr_cells_state *c = state;
    vr_cell_lot_finish(&c->lot, context);
    vr_buffer_finish(&c->basis, context);
    vr_buffer_finish(&c->shown, context);
    vr_buffer_finish(&c->psi, context);
    vr_buffer_finish(&c->exponentials, context);
}

const struct vr_method_row vr_cells = {
    .state_bytes = sizeof(struct vr_cells_state), .draw = draw, .finish = finish, .clips = true};
