/* From blocks to faces. Each active macrocell gives its faces with inactive ones; sorted, those side by side
 * become one. */
#include "blocks.h"

#include <math.h>
#include <stdlib.h>

#include <brick/checked.h>

struct cells {
    const struct vr_blocks *blocks;
    const struct vr_macrocells *macrocells;
    uint64_t bricks[3];
    int64_t count[3];
    uint32_t a_brick; /* macrocells along a brick's edge */
};

static void cells_init(struct cells *c, const struct vr_blocks *blocks, const struct vr_frame *frame)
{
    *c = (struct cells){.blocks = blocks,
                        .macrocells = vr_residency_macrocells(frame->residency),
                        .a_brick = frame->grid->edge / frame->grid->macrocell};
    for (int a = 0; a < 3; a++) {
        c->bricks[a] = frame->level->bricks[a];
        c->count[a] = (int64_t)(c->bricks[a] * c->a_brick);
    }
}

static bool cell_active(const struct cells *c, const int64_t at[3])
{
    uint32_t in[3];
    uint64_t brick = 0;
    for (int a = 2; a >= 0; a--) {
        if (at[a] < 0 || at[a] >= c->count[a])
            return false;
        brick = brick * c->bricks[a] + (uint64_t)at[a] / c->a_brick;
        in[a] = (uint32_t)((uint64_t)at[a] % c->a_brick);
    }
    const uint32_t place = c->blocks->place[brick];
    if (!place)
        return false;
    const uint32_t *bits = c->blocks->bits[place - 1];
    if (!bits)
        return true;
    const uint32_t *room = (const uint32_t *)c->macrocells->cells;
    if (in[0] >= room[0] || in[1] >= room[1] || in[2] >= room[2])
        return false;
    uint32_t bit = (in[2] * room[1] + in[1]) * room[0] + in[0];
    return bits[bit >> 5] >> (bit & 31) & 1;
}

static void mix(uint64_t *hash, uint64_t word)
{
    *hash = (*hash ^ word) * UINT64_C(0x9e3779b97f4a7c15);
    *hash ^= *hash >> 29;
}

/* What is active, and its fingerprint. */
static int gather(struct vr_blocks *b, const struct vr_frame *frame, const uint32_t **list, size_t *count,
                  uint64_t *fingerprint, struct brick_error *err)
{
    const struct vr_macrocells *m = vr_residency_macrocells(frame->residency);
    const struct brick_level *l = frame->level;
    uint64_t bricks = l->bricks[0] * l->bricks[1] * l->bricks[2], hash = 1;
    /* A pre-integrated step from brick to brick counts whatever the macrocells are (shaders/segments.glsl),
     * and with a lossy codec something may show in one where neither brick has it. */
    const bool whole = frame->prefixes && brick_volume_tolerance(frame->volume) > 0.0;
    int result = vr_residency_order(frame->residency, false, list, count, err);
    if (result)
        return result;
    if (bricks > b->bricks) {
        free(b->place);
        b->bricks = 0;
        if (!(b->place = malloc(bricks * sizeof *b->place)))
            return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the blocks of a picture");
        b->bricks = bricks;
    }
    if (*count > b->bits_room) {
        const uint32_t **bits = realloc(b->bits, *count * sizeof *bits);
        if (!bits)
            return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the blocks of a picture");
        b->bits = bits;
        b->bits_room = *count;
    }
    for (uint64_t i = 0; i < bricks; i++)
        b->place[i] = 0;
    mix(&hash, frame->scene->level);
    for (size_t i = 0; i < *count; i++) {
        uint32_t slot = vr_residency_slot(frame->residency, (*list)[i]);
        b->place[(*list)[i]] = (uint32_t)i + 1;
        b->bits[i] =
            whole || slot == UINT32_MAX ? NULL : m->words + (size_t)slot * 2 * (size_t)m->plane_words;
    }
    for (uint64_t i = 0; i < bricks; i++) {
        const uint32_t *bits = b->place[i] ? b->bits[b->place[i] - 1] : NULL;
        if (b->place[i])
            mix(&hash, i);
        for (int w = 0; bits && w < m->plane_words; w++)
            mix(&hash, UINT64_C(1) << 32 | bits[w]);
    }
    *fingerprint = hash | 1;
    return BRICK_OK;
}

static int add(struct vr_blocks *b, const int64_t at[3], size_t *n, struct brick_error *err)
{
    if (*n == b->room) {
        size_t room = b->room ? 2 * b->room : 4096;
        struct vr_row *grown = realloc(b->row, room * sizeof *grown);
        if (!grown)
            return brick_fail(err, BRICK_ERR_MEMORY, "no memory for %zu blocks of a picture", room);
        b->row = grown;
        b->room = room;
    }
    b->row[(*n)++] = (struct vr_row){(uint32_t)at[0], (uint32_t)at[0] + 1, (uint32_t)at[1], (uint32_t)at[2]};
    return BRICK_OK;
}

static bool at_border(const struct cells *c, const int64_t at[3])
{
    for (int side = 0; side < 6; side++) {
        int64_t next[3] = {at[0], at[1], at[2]};
        next[side / 2] += side & 1 ? 1 : -1;
        if (!cell_active(c, next))
            return true;
    }
    return false;
}

static int add_brick(struct vr_blocks *b, const struct cells *c, uint64_t brick, size_t *n,
                     struct brick_error *err)
{
    const uint32_t e = c->a_brick;
    const uint64_t place[3] = {brick % c->bricks[0], brick / c->bricks[0] % c->bricks[1],
                               brick / c->bricks[0] / c->bricks[1]};
    int result = BRICK_OK;
    for (uint32_t i = 0; i < e * e * e && !result; i++) {
        const int64_t at[3] = {(int64_t)(place[0] * e + i % e), (int64_t)(place[1] * e + i / e % e),
                               (int64_t)(place[2] * e + i / e / e)};
        if (cell_active(c, at) && at_border(c, at))
            result = add(b, at, n, err);
    }
    return result;
}

static int in_rows(const void *a, const void *b)
{
    const struct vr_row *p = a, *q = b;
    if (p->z != q->z)
        return p->z < q->z ? -1 : 1;
    if (p->y != q->y)
        return p->y < q->y ? -1 : 1;
    return (p->from > q->from) - (p->from < q->from);
}

/* Of n blocks; returns the number of rows. */
static size_t join(struct vr_row *row, size_t n)
{
    size_t last = 0;
    if (n)
        qsort(row, n, sizeof *row, in_rows);
    for (size_t i = 1; i < n; i++) {
        if (row[i].z == row[last].z && row[i].y == row[last].y && row[i].from == row[last].to)
            row[last].to = row[i].to;
        else
            row[++last] = row[i];
    }
    return n ? last + 1 : 0;
}

int vr_blocks_update(struct vr_blocks *b, const struct vr_frame *frame, bool *changed,
                     struct brick_error *err)
{
    const uint32_t *list = NULL;
    size_t active = 0, n = 0;
    uint64_t fingerprint = 0;
    struct cells c;
    int result = gather(b, frame, &list, &active, &fingerprint, err);
    if (result)
        return result;
    *changed = fingerprint != b->fingerprint;
    if (!*changed)
        return BRICK_OK;
    b->fingerprint = 0;
    cells_init(&c, b, frame);
    for (size_t i = 0; i < active && !result; i++)
        result = add_brick(b, &c, list[i], &n, err);
    b->count = join(b->row, n);
    if (!result)
        b->fingerprint = fingerprint;
    return result;
}

void vr_blocks_finish(struct vr_blocks *b)
{
    free(b->row);
    free(b->place);
    free(b->bits);
    *b = (struct vr_blocks){0};
}

bool vr_blocks_inside(const struct vr_blocks *b, const struct vr_frame *frame, const double at[3],
                      const double margin[3])
{
    const double edge = frame->grid->macrocell;
    struct cells c;
    int64_t low[3], high[3], i[3];
    cells_init(&c, b, frame);
    for (int a = 0; a < 3; a++) {
        /* The outermost blocks reach a voxel further, over the volume's rim. */
        if (at[a] < -1.0 - margin[a] || at[a] > (double)c.count[a] * edge + margin[a])
            return false;
        low[a] = (int64_t)fmax(floor((at[a] - margin[a]) / edge), 0.0);
        high[a] = (int64_t)fmax(floor((at[a] + margin[a]) / edge), 0.0);
    }
    for (i[2] = low[2]; i[2] <= high[2]; i[2]++)
        for (i[1] = low[1]; i[1] <= high[1]; i[1]++)
            for (i[0] = low[0]; i[0] <= high[0]; i[0]++)
                if (cell_active(&c, i))
                    return true;
    return false;
}
