/* Boxes of active macrocells hold all samples of a brick that show anything. A slab, the piece of a ray
 * between two planes, may also lead from one brick into another. Which macrocells are active there is known
 * only while that brick is resident, so such a slab is drawn whatever the macrocells are: either in a box or,
 * where there is none, in the rim, the outermost voxels along the faces behind which there are bricks.
 * Both ends of a slab lie in cells that touch, so the rim is a voxel thick (shaders/slices_slab.glsl). */
#include "parts.h"

#include <stdlib.h>

#define RIM_MAX 6

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
static void place_voxels(const struct vr_frame *frame, const struct vr_stack *stack, const int low[3],
                         const int high[3], struct vr_stack_box *box)
{
    double from[3], to[3];
    for (int a = 0; a < 3; a++) {
        from[a] = low[a] > 0 ? low[a] : stack->low[a];
        to[a] = high[a] < (int)frame->level->dims[a] ? high[a] : stack->high[a];
    }
    vr_stack_place(stack, from, to, box);
}

void vr_parts_whole(const struct vr_frame *frame, const struct vr_stack *stack, uint32_t brick,
                    struct vr_stack_box *box)
{
    int low[3], high[3];
    brick_voxels(frame, brick, low, high);
    place_voxels(frame, stack, low, high, box);
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
};

static int add(const struct find *f, const int low[3], const int high[3], bool rim, struct brick_error *err)
{
    struct vr_parts *p = f->parts;
    place_voxels(f->frame, f->stack, low, high, &p->boxes[p->count]);
    return vr_sheets_box(f->sheets, low, high, f->offset, rim, &p->numbers[p->count++], err);
}

/* Slices that do not overlap, cut off one after the other. */
static int add_rim(const struct find *f, struct brick_error *err)
{
    int rest[2][3], result = BRICK_OK;
    for (int a = 0; a < 3; a++)
        rest[0][a] = f->low[a], rest[1][a] = f->high[a];
    for (int side = 0; side < RIM_MAX && !result; side++) {
        const int a = side / 2, high = side % 2;
        const bool neighbour = high ? f->high[a] < (int)f->frame->level->dims[a] : f->low[a] > 0;
        if (!neighbour || rest[0][a] >= rest[1][a])
            continue;
        int cut[2][3];
        for (int i = 0; i < 3; i++)
            cut[0][i] = rest[0][i], cut[1][i] = rest[1][i];
        cut[!high][a] = rest[high][a] + (high ? -1 : 1);
        rest[high][a] = cut[!high][a];
        result = add(f, cut[0], cut[1], true, err);
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
    struct find f = {.parts = p, .frame = frame, .stack = stack, .sheets = sheets};
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
        boxes = vr_boxes_of(m->words + (size_t)slot * 2 * (size_t)m->plane_words, m->cells, p->cells);
    int result = reserve(p, boxes + RIM_MAX, err);
    p->count = 0;
    for (size_t i = 0; i < boxes && !result; i++) {
        int from[3], to[3];
        for (int a = 0; a < 3; a++) {
            from[a] = f.low[a] + p->cells[i].low[a] * edge;
            to[a] = f.low[a] + p->cells[i].high[a] * edge;
            to[a] = to[a] < f.high[a] ? to[a] : f.high[a];
        }
        result = add(&f, from, to, false, err);
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
