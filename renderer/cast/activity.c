/* Activity. Invariant: a brick's bits are written by the one thread that took it, before `known` says so;
 * others meanwhile find them for themselves. Where nothing shows no sample counts, so the picture does not
 * depend on it. */
#include "activity.h"

#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>

#include "away.h"

enum { UNKNOWN, TAKEN, KNOWN, ALL };

void vr_cast_activity_finish(struct vr_cast_activity *a)
{
    vr_classified_finish(&a->classified);
    free(a->state);
    free(a->away);
    free(a->known);
    free(a->bits);
    *a = (struct vr_cast_activity){0};
}

static int take_memory(struct vr_cast_activity *a, const struct brick_grid *grid, uint32_t level,
                       struct brick_error *err)
{
    const uint64_t *bricks = grid->level[level].bricks;
    const uint32_t across = grid->edge / grid->macrocell;
    uint64_t bytes;
    if (a->state && a->query.level == level)
        return BRICK_OK;
    vr_cast_activity_finish(a);
    a->across = across;
    a->words = (across * across * across + 31) / 32;
    while (1u << a->shift < grid->macrocell)
        a->shift++;
    if (brick_mul3_u64(bricks[0], bricks[1], bricks[2], &a->bricks) &&
        brick_mul3_u64(a->bricks, a->words, sizeof *a->bits, &bytes) && bytes <= SIZE_MAX) {
        a->state = malloc((size_t)a->bricks);
        a->away = malloc((size_t)(a->bricks + bricks[0] + 2)); /* with room to find them */
        a->known = malloc((size_t)a->bricks * sizeof *a->known);
        a->bits = malloc((size_t)bytes);
    }
    if (a->state && a->away && a->known && a->bits)
        return BRICK_OK;
    vr_cast_activity_finish(a);
    return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the states of the level's bricks");
}

int vr_cast_activity_begin(struct vr_cast_activity *a, const struct brick_volume *volume,
                           const struct brick_active_query *query, bool skip, struct brick_error *err)
{
    int code = take_memory(a, brick_volume_grid(volume), query->level, err);
    if (code)
        return code;
    a->volume = volume;
    a->query = *query; /* whose level the arrays are for */
    if ((code = vr_classified_set(&a->classified, query, err)))
        return code;
    if (a->number == a->classified.number && a->skip == skip)
        return BRICK_OK;
    a->number = a->classified.number;
    a->skip = skip;
    a->active = brick_active_set(volume, query, a->state);
    for (uint64_t b = 0; b < a->bricks; b++)
        atomic_init(&a->known[b], UNKNOWN);
    if (!skip) {
        memset(a->state, BRICK_STATE_WHOLE, (size_t)a->bricks);
        a->active = a->bricks;
    }
    for (uint64_t b = 0; b < a->bricks; b++)
        a->away[b] = a->state[b] >= BRICK_STATE_ACTIVE ? 0 : UINT8_MAX;
    vr_cast_find_away(a->away, brick_volume_grid(volume)->level[query->level].bricks);
    return BRICK_OK;
}

/* True when something may show everywhere. */
static bool find(const struct vr_cast_activity *a, uint64_t brick, const void *ranges, uint32_t *bits)
{
    const struct brick_grid *grid = brick_volume_grid(a->volume);
    struct brick_place place;
    brick_grid_place(grid, grid->level[a->query.level].first_brick + brick, &place);
    memset(bits, 0, a->words * sizeof *bits);
    const uint64_t active =
        brick_active_macrocells(grid, &a->query, false, grid->type, ranges, place.macrocells,
                                (uint32_t[]){a->across, a->across * a->across}, bits, NULL);
    return active == (uint64_t)place.macrocells[0] * place.macrocells[1] * place.macrocells[2];
}

const uint32_t *vr_cast_activity_bits(struct vr_cast_activity *a, uint64_t brick, const void *ranges,
                                      uint32_t *scratch)
{
    uint32_t *bits = a->bits + brick * a->words;
    unsigned char known = atomic_load_explicit(&a->known[brick], memory_order_acquire);
    if (known == KNOWN || known == ALL)
        return known == KNOWN ? bits : NULL;
    if (known == UNKNOWN && atomic_compare_exchange_strong(&a->known[brick], &known, TAKEN)) {
        const bool all = find(a, brick, ranges, bits);
        atomic_store_explicit(&a->known[brick], all ? ALL : KNOWN, memory_order_release);
        return all ? NULL : bits;
    }
    return find(a, brick, ranges, scratch) ? NULL : scratch;
}
