/* Boxes of active macrocells hold all samples of a brick that show anything. A slab, the piece of a ray
 * between two planes, may also lead from one brick into another. Which macrocells are active there is known
 * only while that brick is resident, so such a slab is drawn whatever the macrocells are: either in a box or,
 * where there is none, in the rim, a layer along the faces as thick as a slab may reach into the brick
 * (shaders/slices_slab.glsl). */
#include "parts.h"

#include <math.h>
#include <stdlib.h>

#define SIDES 6

/* A brick's voxels, from low to high (exclusive). */
static void brick_voxels(const struct vr_frame *frame, uint32_t brick, int low[3], int high[3])
{
    uint64_t rest = brick;
    for (int a = 0; a < 3; a++) {
        uint64_t from = rest % frame->level->bricks[a] * frame->grid->edge, to = from + frame->grid->edge;
        rest /= frame->level->bricks[a];
        low[a] = (int)from;
        high[a] = (int)(to < frame->level->dims[a] ? to : frame->level->dims[a]);
    }
}

/* The cells that voxels own: those at the level's ends own what lies between them and the box's faces. */
static void cells_of(const struct vr_frame *frame, const struct vr_stack *stack, const int low[3],
                     const int high[3], double from[3], double to[3])
{
    for (int a = 0; a < 3; a++) {
        from[a] = low[a] > 0 ? low[a] : stack->low[a];
        to[a] = high[a] < (int)frame->level->dims[a] ? high[a] : stack->high[a];
    }
}

void vr_parts_whole(const struct vr_frame *frame, const struct vr_stack *stack, uint32_t brick,
                    struct vr_stack_box *box)
{
    int low[3], high[3];
    double from[3], to[3];
    brick_voxels(frame, brick, low, high);
    cells_of(frame, stack, low, high, from, to);
    vr_stack_place(stack, from, to, box);
}

static int reserve(struct vr_parts *p, size_t n, struct brick_error *err)
{
    if (n <= p->room)
        return BRICK_OK;
    free(p->boxes);
    free(p->numbers);
    p->boxes = malloc(n * sizeof *p->boxes);
    p->numbers = malloc(n * sizeof *p->numbers);
    p->room = p->boxes && p->numbers ? n : 0;
    return p->room ? BRICK_OK : brick_fail(err, BRICK_ERR_MEMORY, "no memory for %zu boxes", n);
}

/* A brick on its way to the sheets. */
struct find {
    struct vr_parts *parts;
    const struct vr_frame *frame;
    const struct vr_stack *stack;
    struct vr_sheets *sheets;
    int low[3], high[3], offset[3]; /* voxels; texel = voxel + offset */
    const uint32_t *bits;           /* of its macrocells */
};

static int add_box(const struct find *f, const int low[3], const int high[3], struct brick_error *err)
{
    struct vr_parts *p = f->parts;
    double from[3], to[3];
    cells_of(f->frame, f->stack, low, high, from, to);
    vr_stack_place(f->stack, from, to, &p->boxes[p->count]);
    return vr_sheets_box(f->sheets, low, high, f->offset, 0, &p->numbers[p->count++], err);
}

/* Is something visible in a brick that lies beyond a side and touches it? */
static bool shows_beyond(const struct find *f, int axis, bool high)
{
    const uint8_t *states = vr_residency_states(f->frame->residency);
    const uint64_t *bricks = f->frame->level->bricks;
    for (int n = 0; n < 9; n++) {
        const int aside[3] = {high ? 1 : -1, n % 3 - 1, n / 3 - 1};
        uint64_t at[3], brick = 0;
        bool inside = true;
        for (int i = 0; i < 3; i++) {
            const int a = (axis + i) % 3;
            at[a] = (uint64_t)f->low[a] / f->frame->grid->edge + (uint64_t)aside[i]; /* -1: very large */
            inside = inside && at[a] < bricks[a];
        }
        for (int a = 2; a >= 0; a--)
            brick = brick * bricks[a] + at[a];
        if (inside && states[brick] == BRICK_STATE_ACTIVE)
            return true;
    }
    return false;
}

/* May a ray come into the brick through a side? */
static bool enters(const struct find *f, int axis, bool high)
{
    const struct vr_stack *s = f->stack;
    const double ahead = s->perspective ? (high ? f->high : f->low)[axis] - s->eye[axis] : s->dir[axis];
    return high ? ahead < 0.0 : ahead > 0.0;
}

/* Of a slab that leads through a side, does what is beyond matter to who draws it? A slab belongs to the
 * brick at its back, a lit one to that of its middle; nothing is visible in it unless it is in one of the
 * bricks that it lies in. With a lossy codec that is not so, as borders may differ from the next brick's
 * core: then all that may be drawn is, so that skipping changes nothing. */
static bool needs_rim(const struct find *f, int axis, bool high)
{
    const bool neighbour = high ? f->high[axis] < (int)f->frame->level->dims[axis] : f->low[axis] > 0;
    if (!neighbour || brick_volume_tolerance(f->frame->volume) > 0.0)
        return neighbour;
    return (f->frame->scene->mode == BRICK_MODE_SHADED || enters(f, axis, high)) &&
           shows_beyond(f, axis, high);
}

/* Bounds of a side's inactive macrocells, in voxels; false: it has none. */
static bool find_gap(const struct find *f, int axis, bool high, int from[3], int to[3])
{
    const int *room = vr_residency_macrocells(f->frame->residency)->cells;
    const int edge = (int)f->frame->grid->macrocell;
    int first[3] = {0}, last[3], at[3];
    bool any = false;
    for (int a = 0; a < 3; a++) {
        last[a] = (f->high[a] - f->low[a] - 1) / edge;
        from[a] = f->high[a];
        to[a] = f->low[a];
    }
    first[axis] = last[axis] = high ? last[axis] : 0;
    for (at[2] = first[2]; at[2] <= last[2]; at[2]++)
        for (at[1] = first[1]; at[1] <= last[1]; at[1]++)
            for (at[0] = first[0]; at[0] <= last[0]; at[0]++) {
                const int bit = (at[2] * room[1] + at[1]) * room[0] + at[0];
                if (f->bits[bit >> 5] >> (bit & 31) & 1)
                    continue;
                any = true;
                for (int a = 0; a < 3; a++) {
                    const int start = f->low[a] + at[a] * edge, end = start + edge;
                    from[a] = start < from[a] ? start : from[a];
                    to[a] = end > to[a] ? end : to[a];
                    to[a] = to[a] < f->high[a] ? to[a] : f->high[a];
                }
            }
    return any;
}

static int add_rim(const struct find *f, struct brick_error *err)
{
    struct vr_parts *p = f->parts;
    const double share = f->frame->scene->mode == BRICK_MODE_SHADED ? 0.5 : 1.0; /* of a slab */
    uint32_t sides = 0;
    int result = BRICK_OK;
    for (int side = 0; side < SIDES; side++)
        sides |= (uint32_t)needs_rim(f, side / 2, side % 2) << side;
    for (int side = 0; side < SIDES && !result; side++) {
        const double reach = share * f->stack->reach_mm * f->stack->mm[side / 2];
        int low[3], high[3];
        double from[3], to[3];
        if (!(sides >> side & 1) || !find_gap(f, side / 2, side % 2, low, high))
            continue;
        cells_of(f->frame, f->stack, low, high, from, to);
        if (side % 2)
            from[side / 2] = fmax(from[side / 2], to[side / 2] - reach);
        else
            to[side / 2] = fmin(to[side / 2], from[side / 2] + reach);
        vr_stack_place(f->stack, from, to, &p->boxes[p->count]);
        result = vr_sheets_box(f->sheets, f->low, f->high, f->offset, sides | UINT32_C(64) << side,
                               &p->numbers[p->count++], err);
    }
    return result;
}

int vr_parts_find(struct vr_parts *p, const struct vr_frame *frame, const struct vr_stack *stack,
                  uint32_t brick, struct vr_sheets *sheets, struct brick_error *err)
{
    const struct vr_macrocells *m = vr_residency_macrocells(frame->residency);
    const struct vr_atlas *atlas = vr_residency_atlas(frame->residency);
    const uint32_t slot = vr_residency_slot(frame->residency, brick);
    const int edge = (int)frame->grid->macrocell;
    struct find f = {.parts = p,
                     .frame = frame,
                     .stack = stack,
                     .sheets = sheets,
                     .bits = m->words + (size_t)slot * 2 * (size_t)m->plane_words};
    uint32_t place[3];
    size_t boxes = 1;
    if (!p->cells)
        p->cells = malloc((size_t)m->cells[0] * (size_t)m->cells[1] * (size_t)m->cells[2] * sizeof *p->cells);
    if (!p->cells)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the boxes of a brick");
    brick_voxels(frame, brick, f.low, f.high);
    vr_atlas_slot_place(atlas, slot, place);
    for (int a = 0; a < 3; a++)
        f.offset[a] = (int)place[a] * atlas->slot_size[a] + (int)frame->grid->border - f.low[a];
    p->cells[0] = (struct vr_cell_box){.high = {m->cells[0], m->cells[1], m->cells[2]}};
    if (frame->quality->skip)
        boxes = vr_boxes_of(f.bits, m->cells, p->cells);
    int result = reserve(p, boxes + SIDES, err);
    p->count = 0;
    for (size_t i = 0; i < boxes && !result; i++) {
        int from[3], to[3];
        for (int a = 0; a < 3; a++) {
            from[a] = f.low[a] + p->cells[i].low[a] * edge;
            to[a] = f.low[a] + p->cells[i].high[a] * edge;
            to[a] = to[a] < f.high[a] ? to[a] : f.high[a];
        }
        result = add_box(&f, from, to, err);
    }
    if (!result && stack->slabs && frame->quality->skip)
        result = add_rim(&f, err);
    return result;
}

void vr_parts_finish(struct vr_parts *p)
{
    free(p->boxes);
    free(p->numbers);
    free(p->cells);
    *p = (struct vr_parts){0};
}
