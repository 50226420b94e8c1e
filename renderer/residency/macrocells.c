/* Macrocell activity. Invariant: a macrocell without its active bit holds no sample that could change the
 * picture: ranges cover the field over the macrocell's cells and are widened by what float32 interpolation
 * may add. */
#include "macrocells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>

static uint64_t cell_count(const struct vr_macrocells *m)
{
    return (uint64_t)m->cells[0] * (uint64_t)m->cells[1] * (uint64_t)m->cells[2];
}

int vr_macrocells_init(struct vr_macrocells *m, const struct brick_grid *grid, uint32_t slots,
                       struct brick_error *err)
{
    uint64_t cells, words;
    *m = (struct vr_macrocells){.slots = slots};
    for (int a = 0; a < 3; a++) {
        uint64_t core = grid->dims[a] < grid->edge ? grid->dims[a] : grid->edge;
        m->cells[a] = (int)((core + grid->macrocell - 1) / grid->macrocell);
    }
    m->plane_words = (int)((cell_count(m) + 31) / 32);
    if (!brick_mul3_u64(cell_count(m), slots, 2 * sizeof(float), &cells) ||
        !brick_mul3_u64((uint64_t)m->plane_words, slots, 2 * sizeof(uint32_t), &words) ||
        !(m->ranges = malloc(cells)) || !(m->words = calloc(1, words))) {
        free(m->ranges);
        *m = (struct vr_macrocells){0};
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the macrocells of %u bricks", slots);
    }
    return BRICK_OK;
}

void vr_macrocells_finish(struct vr_macrocells *m, struct vr_context *context)
{
    vr_buffer_finish(&m->buffer, context);
    free(m->ranges);
    free(m->words);
    *m = (struct vr_macrocells){0};
}

void vr_macrocells_set(struct vr_macrocells *m, uint32_t slot, const struct brick_grid *grid,
                       const struct brick_place *place, const void *ranges)
{
    float *out = m->ranges + slot * cell_count(m) * 2;
    size_t i = 0;
    for (uint64_t c = 0; c < cell_count(m); c++)
        out[2 * c] = INFINITY, out[2 * c + 1] = -INFINITY;
    for (uint32_t z = 0; z < place->macrocells[2]; z++)
        for (uint32_t y = 0; y < place->macrocells[1]; y++)
            for (uint32_t x = 0; x < place->macrocells[0]; x++, i += 2) {
                size_t c = 2 * ((z * (size_t)m->cells[1] + y) * (size_t)m->cells[0] + x);
                out[c] = (float)brick_type_load(grid->type, ranges, i);
                out[c + 1] = (float)brick_type_load(grid->type, ranges, i + 1);
            }
}

uint64_t vr_macrocells_classify(struct vr_macrocells *m, uint32_t slot, const struct brick_grid *grid,
                                const struct brick_active_query *query, bool whole)
{
    const uint32_t cells[3] = {(uint32_t)m->cells[0], (uint32_t)m->cells[1], (uint32_t)m->cells[2]};
    uint32_t *active = m->words + (size_t)slot * 2 * (size_t)m->plane_words;
    memset(active, 0, 2 * (size_t)m->plane_words * sizeof *active);
    return brick_active_macrocells(grid, query, whole, BRICK_F32, m->ranges + slot * cell_count(m) * 2, cells,
                                   (uint32_t[]){cells[0], cells[0] * cells[1]}, active,
                                   active + m->plane_words);
}

int vr_macrocells_upload(struct vr_macrocells *m, struct vr_context *context, struct brick_error *err)
{
    return vr_buffer_write(&m->buffer, context, GL_R32UI, m->words,
                           (uint64_t)m->slots * 2 * (uint64_t)m->plane_words * sizeof *m->words,
                           "macrocell bits", err);
}

void vr_macrocells_update(struct vr_macrocells *m, struct vr_context *context, uint32_t *slots, size_t count)
{
    vr_buffer_update(&m->buffer, context, m->words, 2 * (size_t)m->plane_words * sizeof *m->words, slots,
                     count);
}
