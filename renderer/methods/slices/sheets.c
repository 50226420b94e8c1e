/* Two growing lists, written anew for every draw. Polygons are fans of triangles; two triangles of a fan
 * share their corners to the bit, so that no pixel between them is drawn twice or not at all. */
#include "sheets.h"

#include <stdlib.h>
#include <string.h>

/* Room for n more records. */
static int reserve(uint32_t (**list)[4], size_t count, size_t n, size_t *room, struct brick_error *err)
{
    if (count + n <= *room)
        return BRICK_OK;
    size_t more = 2 * (count + n);
    void *grown = realloc(*list, more * sizeof **list);
    if (!grown)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for %zu vertices", more);
    *list = grown;
    *room = more;
    return BRICK_OK;
}

int vr_sheets_box(struct vr_sheets *s, const int low[3], const int high[3], const int offset[3], uint32_t rim,
                  uint32_t *number, struct brick_error *err)
{
    int result = reserve(&s->box, s->boxes, 3, &s->box_room, err);
    if (result)
        return result;
    for (int a = 0; a < 3; a++) {
        s->box[s->boxes][a] = (uint32_t)low[a];
        s->box[s->boxes + 1][a] = (uint32_t)high[a];
        s->box[s->boxes + 2][a] = (uint32_t)offset[a];
    }
    s->box[s->boxes][3] = rim;
    *number = (uint32_t)(s->boxes / 3);
    s->boxes += 3;
    return BRICK_OK;
}

int vr_sheets_add(struct vr_sheets *s, uint32_t box, int plane, double (*polygon)[2], int n,
                  struct brick_error *err)
{
    int result = reserve(&s->vertex, s->vertices, 3 * (size_t)(n - 2), &s->vertex_room, err);
    if (result)
        return result;
    for (int i = 1; i + 1 < n; i++) {
        const int corners[3] = {0, i, i + 1};
        for (int c = 0; c < 3; c++) {
            const float at[2] = {(float)polygon[corners[c]][0], (float)polygon[corners[c]][1]};
            uint32_t *v = s->vertex[s->vertices++];
            memcpy(v, at, sizeof at);
            v[2] = box;
            v[3] = (uint32_t)plane;
        }
    }
    return BRICK_OK;
}

int vr_sheets_draw(struct vr_sheets *s, struct vr_context *context, GLuint unit, struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    const size_t vertices = s->vertices, boxes = s->boxes;
    int result;
    s->vertices = s->boxes = 0;
    if (!vertices)
        return BRICK_OK;
    if (!s->vertex_array)
        gl->GenVertexArrays(1, &s->vertex_array);
    if ((result = vr_buffer_write(&s->vertex_buffer, context, GL_RGBA32UI, s->vertex,
                                  vertices * sizeof *s->vertex, "polygons of slices", err)) ||
        (result = vr_buffer_write(&s->box_buffer, context, GL_RGBA32UI, s->box, boxes * sizeof *s->box,
                                  "boxes of slices", err)))
        return result;
    vr_buffer_use(&s->vertex_buffer, context, unit);
    vr_buffer_use(&s->box_buffer, context, unit + 1);
    gl->BindVertexArray(s->vertex_array);
    gl->DrawArrays(GL_TRIANGLES, 0, (GLsizei)vertices);
    gl->BindVertexArray(0);
    return vr_context_check(context, "drawing slices", err);
}

void vr_sheets_finish(struct vr_sheets *s, struct vr_context *context)
{
    vr_buffer_finish(&s->vertex_buffer, context);
    vr_buffer_finish(&s->box_buffer, context);
    context->gl.DeleteVertexArrays(1, &s->vertex_array);
    free(s->vertex);
    free(s->box);
    *s = (struct vr_sheets){0};
}
