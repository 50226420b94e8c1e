/* How much each look at a level culls: range, occupancy mask, macrocells. Sums of counts only, so that
 * threads and their order do not matter. */
#include <brick/active.h>

#include <stdlib.h>

#include <brick/threads.h>

struct worker {
    struct brick_scratch scratch;
    unsigned char *payload;
    uint32_t *plane;
    struct brick_active_summary sum;
};

struct look {
    const struct brick_volume *volume;
    const struct brick_active_query *query;
    const uint8_t *states;
    struct worker *workers;
};

static int look_inside(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    const struct look *look = context;
    struct worker *w = &look->workers[worker];
    const struct brick_grid *grid = brick_volume_grid(look->volume);
    uint64_t id = grid->level[look->query->level].first_brick + item;
    struct brick_place place;
    brick_grid_place(grid, id, &place);
    w->sum.macrocells += (uint64_t)place.macrocells[0] * place.macrocells[1] * place.macrocells[2];
    if (look->states[item] < BRICK_STATE_ACTIVE)
        return BRICK_OK;
    int code = brick_volume_read(look->volume, id, w->payload, &w->scratch, err);
    if (code)
        return code;
    const uint32_t stride[2] = {place.macrocells[0], place.macrocells[0] * place.macrocells[1]};
    uint64_t active = brick_active_macrocells(grid, look->query, look->states[item] == BRICK_STATE_WHOLE,
                                              grid->type, w->payload + brick_place_voxel_bytes(grid, &place),
                                              place.macrocells, stride, w->plane, w->plane);
    w->sum.macrocells_active += active;
    w->sum.bricks_macrocells += active > 0;
    w->sum.bytes_read += brick_volume_entry(look->volume, id)->bytes;
    return BRICK_OK;
}

/* Payloads of active bricks, in parallel. */
static int look_into_bricks(const struct look *base, uint64_t bricks, unsigned threads,
                            struct brick_active_summary *summary, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(base->volume);
    uint32_t across = grid->edge / grid->macrocell;
    struct look look = *base;
    struct brick_pool *pool = NULL;
    unsigned workers = 0;
    int code = brick_pool_create(&pool, threads, err);
    if (code)
        return code;
    workers = brick_pool_threads(pool);
    look.workers = calloc(workers, sizeof *look.workers);
    for (unsigned i = 0; look.workers && i < workers; i++) {
        look.workers[i].payload = malloc(brick_grid_max_payload_bytes(grid));
        look.workers[i].plane = calloc((size_t)across * across * across / 32 + 1, sizeof(uint32_t));
        if (!look.workers[i].payload || !look.workers[i].plane)
            code = BRICK_ERR_MEMORY;
    }
    if (!look.workers || code)
        code = brick_fail(err, BRICK_ERR_MEMORY, "out of memory for a brick a thread");
    if (!code)
        code = brick_pool_run(pool, bricks, look_inside, &look, err);
    for (unsigned i = 0; look.workers && i < workers; i++) {
        const struct worker *w = &look.workers[i];
        summary->macrocells += w->sum.macrocells;
        summary->macrocells_active += w->sum.macrocells_active;
        summary->bricks_macrocells += w->sum.bricks_macrocells;
        summary->bytes_read += w->sum.bytes_read;
        brick_scratch_finish(&look.workers[i].scratch);
        free(w->payload);
        free(w->plane);
    }
    free(look.workers);
    brick_pool_destroy(&pool);
    return code;
}

int brick_active_summarise(const struct brick_volume *volume, const struct brick_active_query *query,
                           bool macrocells, unsigned threads, struct brick_active_summary *summary,
                           struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    *summary = (struct brick_active_summary){0};
    if (query->level >= grid->levels)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "level %u: the volume has %u", query->level, grid->levels);
    const struct brick_level *level = &grid->level[query->level];
    uint64_t n = level->bricks[0] * level->bricks[1] * level->bricks[2];
    uint8_t *states = malloc(n);
    if (!states)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for %llu brick states", (unsigned long long)n);
    const struct look look = {.volume = volume, .query = query, .states = states};
    summary->bricks = n;
    summary->bricks_interval = brick_active_by_interval(volume, query, states);
    summary->bricks_active = brick_active_set(volume, query, states);
    int code = macrocells ? look_into_bricks(&look, n, threads, summary, err) : BRICK_OK;
    free(states);
    return code;
}
