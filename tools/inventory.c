/* Why: text and JSON of `brick info` show the same facts, so they are gathered in one place. */
#include "inventory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <brick/active.h>
#include <cjson/cJSON.h>

#include "message.h"
#include "transfer.h"

#define BAR_WIDTH 40

static const double shares[INVENTORY_PERCENTILES] = {0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99};

static void count_bricks(struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    for (uint32_t l = 0; l < grid->levels; l++) {
        const struct brick_level *level = &grid->level[l];
        uint64_t n = level->bricks[0] * level->bricks[1] * level->bricks[2];
        inventory->level[l].bricks = n;
        inventory->level[l].voxel_bytes =
            level->dims[0] * level->dims[1] * level->dims[2] * brick_type_bytes(grid->type);
        for (uint64_t id = level->first_brick; id < level->first_brick + n; id++) {
            const struct brick_entry *entry = brick_volume_entry(inventory->volume, id);
            inventory->level[l].payload_bytes += entry->bytes;
            if (entry->flags & BRICK_FLAG_CONSTANT)
                inventory->level[l].constant++;
            else if (entry->codec < BRICK_CODEC_COUNT)
                inventory->codec_used[entry->codec] = true;
        }
        inventory->constant += inventory->level[l].constant;
    }
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
        double q = grid->slope < 0 ? 1 - shares[i] : shares[i];
        inventory->percentile[i] =
            grid->slope * brick_stats_percentile(stats, grid->type, q) + grid->intercept;
    }
    double width = inventory->range[1] - inventory->range[0];
    for (uint32_t i = 0; i < stats->bins; i++) {
        double start =
            grid->slope * brick_stats_bin_start(grid->type, stats->first_bin + i) + grid->intercept;
        double place = width > 0 ? (start - inventory->range[0]) / width * INVENTORY_ROWS : 0;
        int row = place < 0 ? 0 : place >= INVENTORY_ROWS ? INVENTORY_ROWS - 1 : (int)place;
        inventory->row[row] += (double)stats->histogram[i] / (double)stats->count;
    }
}

static int count_active(struct inventory *inventory, const char *tf, struct brick_error *err)
{
    struct brick_transfer *transfer = NULL;
    uint8_t *states = malloc(inventory->level[0].bricks);
    int code = states ? tool_transfer_load(&transfer, tf, inventory->volume, err)
                      : brick_fail(err, BRICK_ERR_MEMORY, "no memory for %llu brick states",
                                   (unsigned long long)inventory->level[0].bricks);
    if (!code) {
        const struct brick_active_query query = {.mode = BRICK_MODE_DVR, .transfer = transfer, .level = 0};
        inventory->active = brick_active_set(inventory->volume, &query, states);
        inventory->tf = tf;
    }
    brick_transfer_destroy(&transfer);
    free(states);
    return code;
}

int inventory_init(struct inventory *inventory, const struct brick_volume *volume, const char *tf,
                   struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    *inventory = (struct inventory){.volume = volume};
    brick_grid_spacing_mm(grid, inventory->spacing_mm);
    brick_affine_axes(grid->affine, inventory->axes);
    count_bricks(inventory);
    count_values(inventory);
    return tf ? count_active(inventory, tf, err) : 0;
}

static void print_levels(const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    printf("\nlevel  %-20s %10s %10s %12s %7s\n", "voxels", "bricks", "constant", "bytes", "ratio");
    for (uint32_t l = 0; l < grid->levels; l++) {
        const uint64_t *dims = grid->level[l].dims;
        char size[72];
        snprintf(size, sizeof size, "%llu x %llu x %llu", (unsigned long long)dims[0],
                 (unsigned long long)dims[1], (unsigned long long)dims[2]);
        printf("%5u  %-20s %10llu %10llu %12llu ", l, size, (unsigned long long)inventory->level[l].bricks,
               (unsigned long long)inventory->level[l].constant,
               (unsigned long long)inventory->level[l].payload_bytes);
        if (inventory->level[l].payload_bytes)
            printf("%7.2f\n",
                   (double)inventory->level[l].voxel_bytes / (double)inventory->level[l].payload_bytes);
        else
            printf("%7s\n", "-");
    }
}

static void print_values(const struct inventory *inventory)
{
    const struct brick_stats *stats = brick_volume_stats(inventory->volume);
    printf("not finite  %llu of %llu voxels\n", (unsigned long long)stats->nonfinite,
           (unsigned long long)(stats->count + stats->nonfinite));
    if (!stats->count)
        return;
    printf("range       %.7g .. %.7g\nmean        %.7g, standard deviation %.7g\npercentiles",
           inventory->range[0], inventory->range[1], inventory->mean, inventory->deviation);
    for (int i = 0; i < INVENTORY_PERCENTILES; i++)
        printf("%s %g%%: %.6g", i ? "," : " ", 100 * shares[i], inventory->percentile[i]);
    printf("\n\nhistogram\n");
    double peak = 0;
    for (int i = 0; i < INVENTORY_ROWS; i++)
        peak = fmax(peak, inventory->row[i]);
    for (int i = 0; i < INVENTORY_ROWS; i++) {
        double from = inventory->range[0] + i * (inventory->range[1] - inventory->range[0]) / INVENTORY_ROWS;
        char bar[BAR_WIDTH + 1] = "";
        memset(bar, '#', (size_t)lround(inventory->row[i] / peak * BAR_WIDTH));
        printf("%12.6g %7.3f%% %s\n", from, 100 * inventory->row[i], bar);
    }
}

static void print_bricks(const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    printf("\n%10s %5s %6s %6s %6s %14s %10s %-5s %14s %14s %10s\n", "brick", "level", "x", "y", "z",
           "offset", "bytes", "codec", "min", "max", "not finite");
    for (uint64_t id = 0; id < grid->bricks; id++) {
        const struct brick_entry *entry = brick_volume_entry(inventory->volume, id);
        struct brick_place place;
        double lo = NAN, hi = NAN;
        brick_grid_place(grid, id, &place);
        brick_volume_physical_range(inventory->volume, id, &lo, &hi);
        printf("%10llu %5u %6llu %6llu %6llu %14llu %10u %-5s %14.7g %14.7g %10u\n", (unsigned long long)id,
               place.level, (unsigned long long)place.at[0], (unsigned long long)place.at[1],
               (unsigned long long)place.at[2], (unsigned long long)entry->offset, entry->bytes,
               entry->flags & BRICK_FLAG_CONSTANT ? "const"
                                                  : brick_codec_name((enum brick_codec)entry->codec),
               lo, hi, entry->nonfinite);
    }
}

void inventory_print_text(const struct inventory *inventory, bool bricks)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    uint64_t file_bytes = brick_volume_file_bytes(inventory->volume);
    const char *provenance = brick_volume_provenance(inventory->volume);

    printf("file        %s, %s\n", brick_volume_path(inventory->volume), tool_size_text(file_bytes).text);
    printf("size        %llu x %llu x %llu voxels of %s, %s, ratio %.2f\n", (unsigned long long)grid->dims[0],
           (unsigned long long)grid->dims[1], (unsigned long long)grid->dims[2], brick_type_name(grid->type),
           tool_size_text(inventory->level[0].voxel_bytes).text,
           (double)inventory->level[0].voxel_bytes / (double)file_bytes);
    printf("spacing     %.7g x %.7g x %.7g mm, axes %s\n", inventory->spacing_mm[0], inventory->spacing_mm[1],
           inventory->spacing_mm[2], inventory->axes);
    for (int row = 0; row < 3; row++)
        printf("%-11s %12.7g %12.7g %12.7g %12.7g\n", row ? "" : "affine", grid->affine[row][0],
               grid->affine[row][1], grid->affine[row][2], grid->affine[row][3]);
    printf("values      %.9g * stored + %.9g\n", grid->slope, grid->intercept);
    printf("bricks      %llu, %llu constant; core %u, border %u, macrocell %u; codec",
           (unsigned long long)grid->bricks, (unsigned long long)inventory->constant, grid->edge,
           grid->border, grid->macrocell);
    bool any = false;
    for (int codec = 0; codec < BRICK_CODEC_COUNT; codec++)
        if (inventory->codec_used[codec]) {
            printf(" %s", brick_codec_name((enum brick_codec)codec));
            any = true;
        }
    printf("%s\n", any ? "" : " none");
    if (inventory->tf)
        printf("visible     %llu of %llu bricks of level 0 (%.1f%%) with %s\n",
               (unsigned long long)inventory->active, (unsigned long long)inventory->level[0].bricks,
               100 * (double)inventory->active / (double)inventory->level[0].bricks, inventory->tf);
    print_values(inventory);
    print_levels(inventory);
    if (provenance && *provenance)
        printf("\nprovenance\n%s%s", provenance, provenance[strlen(provenance) - 1] == '\n' ? "" : "\n");
    if (bricks)
        print_bricks(inventory);
}

static cJSON *dims_json(const uint64_t dims[3])
{
    const double numbers[3] = {(double)dims[0], (double)dims[1], (double)dims[2]};
    return cJSON_CreateDoubleArray(numbers, 3);
}

static cJSON *levels_json(const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    cJSON *levels = cJSON_CreateArray();
    for (uint32_t l = 0; l < grid->levels; l++) {
        cJSON *level = cJSON_CreateObject();
        cJSON_AddItemToObject(level, "dims", dims_json(grid->level[l].dims));
        cJSON_AddItemToObject(level, "bricks_per_axis", dims_json(grid->level[l].bricks));
        cJSON_AddItemToObject(level, "scale", cJSON_CreateDoubleArray(grid->level[l].scale, 3));
        cJSON_AddItemToObject(level, "offset", cJSON_CreateDoubleArray(grid->level[l].offset, 3));
        cJSON_AddNumberToObject(level, "bricks", (double)inventory->level[l].bricks);
        cJSON_AddNumberToObject(level, "bricks_constant", (double)inventory->level[l].constant);
        cJSON_AddNumberToObject(level, "voxel_bytes", (double)inventory->level[l].voxel_bytes);
        cJSON_AddNumberToObject(level, "payload_bytes", (double)inventory->level[l].payload_bytes);
        cJSON_AddItemToArray(levels, level);
    }
    return levels;
}

static void add_values(cJSON *json, const struct inventory *inventory)
{
    const struct brick_stats *stats = brick_volume_stats(inventory->volume);
    cJSON_AddNumberToObject(json, "voxels_finite", (double)stats->count);
    cJSON_AddNumberToObject(json, "voxels_nonfinite", (double)stats->nonfinite);
    if (!stats->count)
        return;
    cJSON_AddItemToObject(json, "range", cJSON_CreateDoubleArray(inventory->range, 2));
    cJSON_AddNumberToObject(json, "mean", inventory->mean);
    cJSON_AddNumberToObject(json, "standard_deviation", inventory->deviation);
    cJSON *percentiles = cJSON_AddObjectToObject(json, "percentiles");
    for (int i = 0; i < INVENTORY_PERCENTILES; i++) {
        char name[16];
        snprintf(name, sizeof name, "%g", 100 * shares[i]);
        cJSON_AddNumberToObject(percentiles, name, inventory->percentile[i]);
    }
    cJSON_AddItemToObject(json, "histogram", cJSON_CreateDoubleArray(inventory->row, INVENTORY_ROWS));
}

static cJSON *bricks_json(const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    cJSON *list = cJSON_CreateArray();
    for (uint64_t id = 0; id < grid->bricks; id++) {
        const struct brick_entry *entry = brick_volume_entry(inventory->volume, id);
        struct brick_place place;
        double range[2];
        cJSON *brick = cJSON_CreateObject();
        bool constant = entry->flags & BRICK_FLAG_CONSTANT;
        brick_grid_place(grid, id, &place);
        cJSON_AddNumberToObject(brick, "level", place.level);
        cJSON_AddItemToObject(brick, "at", dims_json(place.at));
        cJSON_AddNumberToObject(brick, "offset", (double)entry->offset);
        cJSON_AddNumberToObject(brick, "bytes", entry->bytes);
        cJSON_AddBoolToObject(brick, "constant", constant);
        if (!constant)
            cJSON_AddStringToObject(brick, "codec", brick_codec_name((enum brick_codec)entry->codec));
        if (brick_volume_physical_range(inventory->volume, id, &range[0], &range[1]))
            cJSON_AddItemToObject(brick, "range", cJSON_CreateDoubleArray(range, 2));
        cJSON_AddNumberToObject(brick, "nonfinite", entry->nonfinite);
        cJSON_AddItemToArray(list, brick);
    }
    return list;
}

int inventory_print_json(const struct inventory *inventory, bool bricks)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    const char *provenance = brick_volume_provenance(inventory->volume);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "file_bytes", (double)brick_volume_file_bytes(inventory->volume));
    cJSON_AddItemToObject(json, "dims", dims_json(grid->dims));
    cJSON_AddStringToObject(json, "type", brick_type_name(grid->type));
    cJSON_AddItemToObject(json, "spacing_mm", cJSON_CreateDoubleArray(inventory->spacing_mm, 3));
    cJSON_AddStringToObject(json, "axes", inventory->axes);
    cJSON_AddItemToObject(json, "affine", cJSON_CreateDoubleArray(&grid->affine[0][0], 12));
    cJSON_AddNumberToObject(json, "slope", grid->slope);
    cJSON_AddNumberToObject(json, "intercept", grid->intercept);
    cJSON_AddNumberToObject(json, "edge", grid->edge);
    cJSON_AddNumberToObject(json, "border", grid->border);
    cJSON_AddNumberToObject(json, "macrocell", grid->macrocell);
    cJSON_AddNumberToObject(json, "bricks", (double)grid->bricks);
    cJSON_AddNumberToObject(json, "bricks_constant", (double)inventory->constant);
    cJSON *codecs = cJSON_AddArrayToObject(json, "codecs");
    for (int codec = 0; codec < BRICK_CODEC_COUNT; codec++)
        if (inventory->codec_used[codec])
            cJSON_AddItemToArray(codecs, cJSON_CreateString(brick_codec_name((enum brick_codec)codec)));
    cJSON_AddItemToObject(json, "levels", levels_json(inventory));
    add_values(json, inventory);
    if (inventory->tf) {
        cJSON_AddStringToObject(json, "tf", inventory->tf);
        cJSON_AddNumberToObject(json, "bricks_active", (double)inventory->active);
        cJSON_AddNumberToObject(json, "active_share",
                                (double)inventory->active / (double)inventory->level[0].bricks);
    }
    cJSON_AddStringToObject(json, "provenance", provenance ? provenance : "");
    if (bricks)
        cJSON_AddItemToObject(json, "brick_list", bricks_json(inventory));
    return tool_json_print("info", json);
}
