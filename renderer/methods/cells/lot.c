/* The paper looks for cells without opacity and fills vertex arrays on the CPU; here a pass of the GPU looks
 * at the cells of the list, four a fragment, and the CPU closes the gaps. Of a cell the GPU then gets four
 * bytes: vertices are numbers, and one array of indices serves all cells (section 4.2.3 shares what it can in
 * the same way). */
#include "lot.h"

#include <stdlib.h>
#include <string.h>

#include <brick/threads.h>

#define ROWS        512
#define ROW_ENTRIES (VR_CELL_LOT_ROW * 4)
#define ROOM        ((size_t)ROWS * ROW_ENTRIES)

/* Entries a draw: their vertices are numbered in 16 bits. */
static size_t entries_a_draw(const struct vr_cell_lot *lot)
{
    return 65536u / lot->shape.vertices;
}

int vr_cell_lot_init(struct vr_cell_lot *lot, struct vr_context *context, struct brick_error *err)
{
    *lot = (struct vr_cell_lot){.entries = malloc(ROOM * sizeof *lot->entries),
                                .runs = malloc(ROWS * sizeof *lot->runs),
                                .flags = malloc(ROOM * sizeof *lot->flags)};
    int result = lot->entries && lot->runs && lot->flags
                     ? vr_canvas_init(&lot->canvas, context, GL_RGBA8, VR_CELL_LOT_ROW, ROWS, err)
                     : brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of cells");
    if (result) {
        vr_cell_lot_finish(lot, context);
        return result;
    }
    context->gl.GenVertexArrays(1, &lot->vertex_array);
    context->gl.GenBuffers(1, &lot->indices);
    return BRICK_OK;
}

void vr_cell_lot_finish(struct vr_cell_lot *lot, struct vr_context *context)
{
    free(lot->entries);
    free(lot->runs);
    free(lot->flags);
    vr_buffer_finish(&lot->buffer, context);
    vr_canvas_finish(&lot->canvas, context);
    context->gl.DeleteBuffers(1, &lot->indices);
    context->gl.DeleteVertexArrays(1, &lot->vertex_array);
    *lot = (struct vr_cell_lot){0};
}

int vr_cell_lot_set_shape(struct vr_cell_lot *lot, struct vr_context *context,
                          const struct vr_cell_shape *shape, struct brick_error *err)
{
    uint16_t *indices;
    size_t n = 0;
    const bool same = lot->shape.vertices == shape->vertices && lot->shape.indices == shape->indices &&
                      !memcmp(lot->shape.index, shape->index, shape->indices);
    lot->shape = *shape;
    if (same)
        return BRICK_OK;
    const size_t entries = entries_a_draw(lot);
    if (!(indices = malloc(entries * shape->indices * sizeof *indices))) {
        lot->shape = (struct vr_cell_shape){0};
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the triangles of %zu cells", entries);
    }
    for (size_t entry = 0; entry < entries; entry++)
        for (int i = 0; i < shape->indices; i++)
            indices[n++] = (uint16_t)(entry * shape->vertices + shape->index[i]);
    context->gl.BindVertexArray(lot->vertex_array);
    context->gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, lot->indices);
    context->gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(n * sizeof *indices), indices,
                           GL_STATIC_DRAW);
    context->gl.BindVertexArray(0);
    free(indices);
    return vr_context_check(context, "triangles of cells", err);
}

bool vr_cell_lot_has_room(const struct vr_cell_lot *lot, size_t entries)
{
    /* Each run begins a row of the canvas. */
    return lot->run_count < ROWS && lot->count + entries + (lot->run_count + 1) * ROW_ENTRIES <= ROOM;
}

void vr_cell_lot_open_run(struct vr_cell_lot *lot, const int first[3], const int texel[3])
{
    struct vr_cell_run *run = &lot->runs[lot->run_count++];
    memcpy(run->first, first, sizeof run->first);
    memcpy(run->texel, texel, sizeof run->texel);
    run->begin = lot->count;
}

static int write_list(struct vr_cell_lot *lot, const struct vr_cell_draw *draw, struct brick_error *err)
{
    int result = vr_buffer_write(&lot->buffer, draw->frame->context, GL_R32UI, lot->entries,
                                 lot->count * sizeof *lot->entries, "list of cells", err);
    vr_buffer_use(&lot->buffer, draw->frame->context, draw->unit);
    return result;
}

/* Leaves only cells that show something. */
static int select_cells(struct vr_cell_lot *lot, const struct vr_cell_draw *draw, struct brick_error *err)
{
    const struct vr_gl *gl = &draw->frame->context->gl;
    int row = 0;
    size_t kept = 0;
    gl->UseProgram(draw->look.program);
    gl->BindVertexArray(lot->vertex_array);
    vr_canvas_use(&lot->canvas, draw->frame->context);
    gl->Disable(GL_BLEND);
    gl->Enable(GL_SCISSOR_TEST);
    for (size_t r = 0; r < lot->run_count; r++) {
        const struct vr_cell_run *run = &lot->runs[r];
        int rows = (int)((run->count + ROW_ENTRIES - 1) / ROW_ENTRIES);
        vr_set_int(&draw->look, "first_cell", (int)run->begin);
        vr_set_int(&draw->look, "end_cell", (int)(run->begin + run->count));
        vr_set_int(&draw->look, "first_row", row);
        vr_set_ivec3(&draw->look, "brick_texel", run->texel);
        gl->Scissor(0, row, VR_CELL_LOT_ROW, rows);
        gl->DrawArrays(GL_TRIANGLES, 0, 3);
        row += rows;
    }
    gl->Disable(GL_SCISSOR_TEST);
    gl->BindVertexArray(0);
    vr_canvas_read(&lot->canvas, draw->frame->context, VR_CELL_LOT_ROW, row, lot->flags, VR_CELL_LOT_ROW);
    const float *flags = lot->flags;
    for (size_t r = 0; r < lot->run_count; r++) {
        struct vr_cell_run *run = &lot->runs[r];
        size_t begin = kept;
        for (size_t i = 0; i < run->count; i++) {
            lot->entries[kept] = lot->entries[run->begin + i];
            kept += flags[i] > 0.5f;
        }
        flags += (run->count + ROW_ENTRIES - 1) / ROW_ENTRIES * ROW_ENTRIES;
        run->begin = begin;
        run->count = kept - begin;
    }
    lot->count = kept;
    return vr_context_check(draw->frame->context, "looking for visible cells", err);
}

static void draw_runs(const struct vr_cell_lot *lot, const struct vr_cell_draw *draw)
{
    const struct vr_gl *gl = &draw->frame->context->gl;
    const size_t most = entries_a_draw(lot);
    gl->UseProgram(draw->draw.program);
    gl->BindVertexArray(lot->vertex_array);
    vr_canvas_use(draw->canvas, draw->frame->context);
    gl->Enable(GL_BLEND);
    gl->BlendEquation(GL_FUNC_ADD);
    gl->BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    if (lot->shape.cull) {
        gl->Enable(GL_CULL_FACE);
        gl->CullFace(lot->shape.cull);
    }
    for (size_t r = 0; r < lot->run_count; r++) {
        const struct vr_cell_run *run = &lot->runs[r];
        vr_set_ivec3(&draw->draw, "brick_first", run->first);
        vr_set_ivec3(&draw->draw, "brick_texel", run->texel);
        for (size_t i = 0; i < run->count; i += most) {
            size_t n = run->count - i < most ? run->count - i : most;
            vr_set_int(&draw->draw, "first_cell", (int)(run->begin + i));
            gl->DrawElements(GL_TRIANGLES, (GLsizei)(n * lot->shape.indices), GL_UNSIGNED_SHORT, NULL);
        }
    }
    gl->Disable(GL_CULL_FACE);
    gl->Disable(GL_BLEND);
    gl->BindVertexArray(0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}

int vr_cell_lot_draw(struct vr_cell_lot *lot, const struct vr_cell_draw *draw, struct vr_report *report,
                     struct brick_error *err)
{
    uint64_t start_ns = brick_now_ns(), drawn_ns;
    int result = BRICK_OK;
    for (size_t r = 0; r < lot->run_count; r++)
        lot->runs[r].count =
            (r + 1 < lot->run_count ? lot->runs[r + 1].begin : lot->count) - lot->runs[r].begin;
    if (lot->count)
        result = write_list(lot, draw, err);
    if (!result && lot->count && draw->select && !(result = select_cells(lot, draw, err)) && lot->count)
        result = write_list(lot, draw, err);
    drawn_ns = brick_now_ns();
    if (!result && lot->count) {
        draw_runs(lot, draw);
        draw->frame->context->gl.Finish();
        result = vr_context_check(draw->frame->context, "projecting cells", err);
        for (size_t i = 0; i < lot->count; i++)
            report->samples += lot->shape.tetrahedra[lot->entries[i] >> VR_CELL_PIECE_BIT];
    }
    report->seconds_setup += 1e-9 * (double)(drawn_ns - start_ns);
    report->seconds_draw += 1e-9 * (double)(brick_now_ns() - drawn_ns);
    lot->count = lot->run_count = 0;
    return result;
}
