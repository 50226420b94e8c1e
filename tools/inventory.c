/* Why: text, JSON and the page of `brick info` show the same facts, so they are gathered in one place. Tables
 * only: no brick is read, and one pass over the index does it. */
#include "inventory.h"

#include <math.h>
#include <stdlib.h>

#include <brick/active.h>

#include "transfer.h"

const double inventory_shares[INVENTORY_PERCENTILES] = {0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99};

static int ascending(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* sizes: of the inventory's size.count payloads. */
static void rank_sizes(struct inventory *inventory, uint32_t *sizes)
{
    uint64_t n = inventory->size.count;
    if (!n)
        return;
    qsort(sizes, (size_t)n, sizeof *sizes, ascending);
    inventory->size.smallest = sizes[0];
    inventory->size.largest = sizes[n - 1];
    inventory->size.mean /= (double)n;
    for (int i = 0; i < INVENTORY_PERCENTILES; i++)
        inventory->size.percentile[i] = sizes[(uint64_t)(inventory_shares[i] * (double)(n - 1))];
}

static void count_brick(struct inventory *inventory, uint32_t level, uint64_t id, uint32_t *sizes)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    const struct brick_entry *entry = brick_volume_entry(inventory->volume, id);
    if (entry->flags & BRICK_FLAG_CONSTANT) {
        inventory->level[level].constant++;
        return;
    }
    struct brick_place place;
    brick_grid_place(grid, id, &place);
    uint64_t decoded = brick_place_payload_bytes(grid, &place);
    uint64_t part = entry->bytes * (uint64_t)INVENTORY_SIZE_PARTS / decoded;
    inventory->size.part[part < INVENTORY_SIZE_PARTS ? part : INVENTORY_SIZE_PARTS - 1]++;
    inventory->size.mean += entry->bytes;
    sizes[inventory->size.count++] = entry->bytes;
    inventory->level[level].payload_bytes += entry->bytes;
    if (entry->codec < BRICK_CODEC_COUNT)
        inventory->codec_used[entry->codec] = true;
}

static int count_bricks(struct inventory *inventory, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    uint32_t *sizes = malloc((size_t)grid->bricks * sizeof *sizes);
    if (!sizes)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the sizes of %llu bricks",
                          (unsigned long long)grid->bricks);
    for (uint32_t l = 0; l < grid->levels; l++) {
        const struct brick_level *level = &grid->level[l];
        uint64_t n = level->bricks[0] * level->bricks[1] * level->bricks[2];
        inventory->level[l].bricks = n;
        inventory->level[l].voxel_bytes =
            level->dims[0] * level->dims[1] * level->dims[2] * brick_type_bytes(grid->type);
        for (uint64_t id = level->first_brick; id < level->first_brick + n; id++)
            count_brick(inventory, l, id, sizes);
        inventory->constant += inventory->level[l].constant;
    }
    rank_sizes(inventory, sizes);
    free(sizes);
    return 0;
}

/* Physical values of the statistics; a negative slope turns the order round. */
static void count_values(struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    const struct brick_stats *stats = brick_volume_stats(inventory->volume);
    if (!stats->count)
        return;
    brick_volume_value_range(inventory->volume, inventory->range);
    inventory->mean = grid->slope * stats->mean + grid->intercept;
    inventory->deviation = fabs(grid->slope) * sqrt(stats->variance);
    for (int i = 0; i < INVENTORY_PERCENTILES; i++) {
        double q = grid->slope < 0 ? 1 - inventory_shares[i] : inventory_shares[i];
        inventory->percentile[i] =
            grid->slope * brick_stats_percentile(stats, grid->type, q) + grid->intercept;
    }
    histogram_init(&inventory->histogram, inventory->volume, HISTOGRAM_PARTS_MAX);
}

/* How many of the n ascending samples are below v, or (or_at) at it. */
static uint32_t samples_below(const double *sample, double v, bool or_at)
{
    uint32_t lo = 0, hi = INVENTORY_SAMPLES;
    while (lo < hi) {
        uint32_t half = (lo + hi) / 2;
        if (sample[half] < v || (or_at && sample[half] == v))
            lo = half + 1;
        else
            hi = half;
    }
    return lo;
}

/* Every brick adds 1 from its smallest to its largest value: noted as a step up and a step down, and summed
 * once at the end. Ranges are widened as culling does, so the shares are those of a picture. */
static void count_active(struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    double *value = inventory->active.value;
    uint64_t up[INVENTORY_SAMPLES + 1] = {0}, down[INVENTORY_SAMPLES + 1] = {0}, bricks = 0, ended = 0;
    uint64_t n = inventory->level[0].bricks, begun = 0;
    const double *range = inventory->range;
    for (int i = 0; i < INVENTORY_SAMPLES; i++)
        value[i] = i < INVENTORY_SAMPLES - 1 ? range[0] + (range[1] - range[0]) * i / (INVENTORY_SAMPLES - 1)
                                             : range[1];
    for (uint64_t id = 0; id < n; id++) {
        double lo, hi;
        if (!brick_volume_physical_range(inventory->volume, id, &lo, &hi))
            continue;
        brick_active_widen(grid->slope, grid->intercept, &lo, &hi);
        up[samples_below(value, lo, false)]++;
        down[samples_below(value, hi, true)]++;
        bricks++;
    }
    for (int i = 0; i < INVENTORY_SAMPLES; i++) {
        begun += up[i];
        ended += down[i];
        inventory->active.crossed[i] = (double)(begun - ended) / (double)n;
        inventory->active.above[i] = (double)(bricks - ended) / (double)n;
    }
    histogram_shares_above(inventory->volume, value, inventory->active.voxels, INVENTORY_SAMPLES);
}

static int count_visible(struct inventory *inventory, const char *tf, bool macrocells, uint32_t threads,
                         struct brick_error *err)
{
    struct brick_transfer *transfer = NULL;
    int code = tool_transfer_load(&transfer, tf, inventory->volume, err);
    if (!code) {
        const struct brick_active_query query = {.mode = BRICK_MODE_DVR, .transfer = transfer, .level = 0};
        code = brick_active_summarise(inventory->volume, &query, macrocells, threads, &inventory->tf_active,
                                      err);
        inventory->tf = tf;
        inventory->macrocells = macrocells;
    }
    brick_transfer_destroy(&transfer);
    return code;
}

int inventory_init(struct inventory *inventory, const struct brick_volume *volume, const char *tf,
                   bool macrocells, uint32_t threads, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    *inventory = (struct inventory){.volume = volume};
    brick_grid_spacing_mm(grid, inventory->spacing_mm);
    brick_affine_axes(grid->affine, inventory->axes);
    int code = count_bricks(inventory, err);
    if (code)
        return code;
    count_values(inventory);
    count_active(inventory);
    return tf ? count_visible(inventory, tf, macrocells, threads, err) : 0;
}
