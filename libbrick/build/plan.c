/* The plan decides memory and speed, never bytes of the file. Preferred in this order: whole slices of every
 * level in memory, reading ahead of the encoding; level 0 in tiles of whole lines of bricks, where reading
 * their borders again is cheap; coarser levels' slices in scratch files; level 0 in any tiles; slices without
 * reading ahead. A source that cannot read boxes has no tiles. Invariant: memory_bytes counts every
 * allocation that grows with the volume, the threads or the brick, and an allowance for the program itself.
 */
#include "plan.h"

#include <brick/checked.h>

#include "encode.h"

enum {
    PROGRAM_BYTES = 12 << 20,
    THREAD_BYTES = 1 << 20,
    SLOTS_A_THREAD = 64,
    STAGING_BYTES = 1 << 20,
    AHEAD_BYTES = 4 << 20,
    TILE_BYTES = 12 << 20 /* what is much larger does not stay in the processor's cache until it is used */
};

static uint64_t add(uint64_t a, uint64_t b)
{
    uint64_t sum;
    return brick_add_u64(a, b, &sum) ? sum : UINT64_MAX;
}

static uint64_t mul(uint64_t a, uint64_t b)
{
    uint64_t product;
    return brick_mul_u64(a, b, &product) ? product : UINT64_MAX;
}

static uint64_t least(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static uint64_t most(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

static uint64_t slice_bytes(const struct brick_grid *grid, uint32_t l)
{
    return mul(mul(grid->level[l].dims[0], grid->level[l].dims[1]), brick_type_bytes(grid->type));
}

static uint64_t row_slices(const struct brick_grid *grid, uint32_t l)
{
    return least(grid->edge + 2 * grid->border, grid->level[l].dims[2]);
}

uint64_t plan_coarse_slices(const struct brick_grid *grid, uint32_t l)
{
    const struct brick_level *level = &grid->level[l];
    uint64_t arriving = level->scale[2] > level[-1].scale[2] ? grid->edge / 2 : grid->edge;
    return least(grid->edge + 2 * grid->border + arriving, level->dims[2]);
}

/* Of a tile with its borders: an upper bound. */
static uint64_t tile_bytes(const struct brick_grid *grid, uint32_t l, const uint64_t shape[2])
{
    uint64_t bytes = row_slices(grid, l) * brick_type_bytes(grid->type);
    for (int a = 0; a < 2; a++)
        bytes = mul(bytes, least(add(mul(shape[a], grid->edge), 2 * grid->border), grid->level[l].dims[a]));
    return bytes;
}

/* Of what a tile's core becomes in level l. */
static uint64_t coarse_bytes(const struct brick_grid *grid, uint32_t l, const uint64_t shape[2])
{
    const struct brick_level *fine = &grid->level[l - 1], *coarse = &grid->level[l];
    uint64_t bytes = brick_type_bytes(grid->type);
    for (int a = 0; a < 3; a++) {
        uint64_t n = least(a < 2 ? mul(shape[a], grid->edge) : grid->edge, fine->dims[a]);
        bytes = mul(bytes, coarse->scale[a] > fine->scale[a] ? (n + 1) / 2 : n);
    }
    return bytes;
}

struct planner {
    const struct brick_grid *grid;
    size_t source_width;  /* bytes; 0 when voxels need no conversion */
    uint64_t held_slices; /* by the source */
    uint64_t fixed, budget;
};

/* Complete a plan whose choices are made. */
static void add_up(const struct planner *p, struct plan *plan)
{
    const struct brick_grid *grid = p->grid;
    plan->box_bytes = plan->boxes ? tile_bytes(grid, 0, plan->shape) : 0;
    uint64_t voxels = (plan->boxes ? plan->box_bytes / row_slices(grid, 0) : slice_bytes(grid, 0)) /
                      brick_type_bytes(grid->type);
    plan->staging_bytes = p->source_width ? most(mul(voxels, p->source_width), STAGING_BYTES) : 0;
    plan->in_bytes = plan->out_bytes = 0;
    uint64_t sum = add(p->fixed, plan->staging_bytes);
    sum = add(sum, mul(p->held_slices, mul(voxels, brick_type_bytes(grid->type))));
    sum = add(sum, plan->boxes ? mul(2, plan->box_bytes) : mul(plan->ring_slices, slice_bytes(grid, 0)));
    for (uint32_t l = 1; l < grid->levels; l++)
        if (l < plan->first_in_memory) {
            plan->in_bytes = most(plan->in_bytes, tile_bytes(grid, l, plan->shape));
            plan->out_bytes = most(plan->out_bytes, coarse_bytes(grid, l, plan->shape));
        } else {
            sum = add(sum, mul(3 * plan_coarse_slices(grid, l), slice_bytes(grid, l)));
        }
    plan->memory_bytes = add(sum, mul(3, add(plan->in_bytes, plan->out_bytes)));
}

static bool fits(const struct planner *p, struct plan *plan)
{
    add_up(p, plan);
    return plan->memory_bytes <= p->budget;
}

/* Whole rows first, then fewer lines of bricks, then parts of a line. */
static bool shrink(struct plan *plan, bool parts)
{
    int a = plan->shape[1] > 1 ? 1 : 0;
    if (plan->shape[a] == 1 || (a == 0 && !parts))
        return false;
    plan->shape[a] = (plan->shape[a] + 1) / 2;
    return true;
}

/* Choose tiles for a way of reading level 0, and spools, at most for the levels between it and `last`. parts:
 * of lines of bricks, too, where level 0 can be read in no other way; each boundary costs, so tiles are
 * large. */
static bool choose(const struct planner *p, struct plan *plan, uint32_t last, bool parts)
{
    const struct brick_grid *grid = p->grid;
    uint64_t rest = p->budget - p->fixed;
    for (uint32_t first = 1; first <= last; first++) {
        plan->first_in_memory = first;
        uint64_t rings = 0;
        for (uint32_t l = first; l < grid->levels; l++)
            rings = add(rings, mul(3 * plan_coarse_slices(grid, l), slice_bytes(grid, l)));
        if (plan->boxes && parts && rings > rest / 2 && first < grid->levels)
            continue; /* leave room for tiles worth their borders */
        plan->shape[0] = grid->level[0].bricks[0];
        plan->shape[1] = grid->level[0].bricks[1];
        do
            if (fits(p, plan) && (parts || plan->box_bytes <= TILE_BYTES || plan->shape[1] == 1))
                return true;
        while (shrink(plan, parts));
    }
    return false;
}

static bool choose_ring(const struct planner *p, struct plan *plan, uint64_t ahead, uint32_t last)
{
    uint64_t nz = p->grid->level[0].dims[2];
    /* The next row of bricks, and of thin volumes enough that threads wake each other seldom. */
    uint64_t all = most(2 * p->grid->edge + 2 * p->grid->border, AHEAD_BYTES / slice_bytes(p->grid, 0));
    plan->boxes = false;
    plan->ring_slices = least(row_slices(p->grid, 0) + ahead, nz);
    if (!choose(p, plan, last, true))
        return false;
    uint64_t more = (p->budget - plan->memory_bytes) / slice_bytes(p->grid, 0);
    plan->ring_slices = least(add(plan->ring_slices, more), least(all, nz));
    add_up(p, plan);
    return true;
}

static bool choose_boxes(const struct planner *p, struct plan *plan, bool parts)
{
    plan->boxes = true;
    plan->ring_slices = 0;
    return choose(p, plan, p->grid->levels, parts);
}

static uint64_t codec_bytes(enum brick_codec codec, uint64_t payload)
{
    bool blosc_lz4 = codec == BRICK_CODEC_LZ4 || codec == BRICK_CODEC_LZ4_BITSHUFFLE;
    if (codec == BRICK_CODEC_NONE)
        return 0;
    return (brick_codec_is_lossy(codec) ? 5 : 3) * payload + (blosc_lz4 ? 0 : 8 << 20);
}

int plan_make(struct plan *plan, const struct brick_grid *grid, const struct brick_source *source,
              const struct brick_build_params *params, unsigned threads, struct brick_error *err)
{
    uint64_t payload = brick_grid_max_payload_bytes(grid), bound = brick_codec_bound(params->codec, payload);
    struct planner p = {.grid = grid,
                        .source_width = source->type == grid->type ? 0 : brick_type_bytes(source->type),
                        .held_slices = source->held_slices,
                        .budget = params->memory_bytes};
    *plan = (struct plan){.slots = SLOTS_A_THREAD * threads};
    uint64_t affordable = p.budget / 8 / bound; /* the queue takes an eighth of the budget at most */
    plan->slots = most(least(plan->slots, affordable), threads + 1);
    p.fixed = PROGRAM_BYTES + (uint64_t)(threads + 2) * THREAD_BYTES;
    p.fixed =
        add(p.fixed, threads * (encoder_bytes(grid) + tally_bytes() + codec_bytes(params->codec, payload)));
    p.fixed = add(p.fixed, params->resume || params->keep ? threads * bound : 0); /* stored bytes */
    p.fixed = add(p.fixed, plan->slots * (bound + sizeof(struct encoded)));
    p.fixed = add(p.fixed, mul(grid->bricks, sizeof(struct brick_entry)));
    bool room = p.fixed <= p.budget;
    if (room &&
        (choose_ring(&p, plan, grid->edge / 2, 1) || (source->fetch && choose_boxes(&p, plan, false)) ||
         choose_ring(&p, plan, grid->edge / 2, grid->levels) ||
         (source->read_box && choose_boxes(&p, plan, true)) || choose_ring(&p, plan, 0, grid->levels)))
        return BRICK_OK;
    /* Nothing fits: the smallest plan says what would. */
    plan->boxes = source->read_box != NULL;
    plan->ring_slices = row_slices(grid, 0);
    plan->first_in_memory = grid->levels;
    plan->shape[0] = plan->shape[1] = 1;
    add_up(&p, plan);
    return brick_fail(err, BRICK_ERR_MEMORY,
                      plan->boxes
                          ? "bricks of %u voxels, borders included, and the index need %llu MiB, more than "
                            "--memory %llu MiB allows"
                          : "this source can only be read from front to back: slabs of %u slices and the "
                            "index need %llu MiB, more than --memory %llu MiB allows",
                      grid->edge + 2 * grid->border, (unsigned long long)(plan->memory_bytes / 1048576 + 1),
                      (unsigned long long)(params->memory_bytes / 1048576));
}
