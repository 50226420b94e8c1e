/* Why: `brick info --json`: the inventory for programs. */
#include <stdio.h>

#include <cjson/cJSON.h>

#include "inventory.h"
#include "message.h"

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
        if (inventory->level[l].payload_bytes)
            cJSON_AddNumberToObject(level, "ratio",
                                    (double)inventory->level[l].voxel_bytes /
                                        (double)inventory->level[l].payload_bytes);
        cJSON_AddItemToArray(levels, level);
    }
    return levels;
}

static cJSON *percentiles_json(const double values[INVENTORY_PERCENTILES])
{
    cJSON *percentiles = cJSON_CreateObject();
    for (int i = 0; i < INVENTORY_PERCENTILES; i++) {
        char name[16];
        snprintf(name, sizeof name, "%g", 100 * inventory_shares[i]);
        cJSON_AddNumberToObject(percentiles, name, values[i]);
    }
    return percentiles;
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
    cJSON_AddItemToObject(json, "percentiles", percentiles_json(inventory->percentile));
    double shares[HISTOGRAM_PARTS_MAX];

    const struct histogram *histogram = &inventory->histogram;
    for (uint32_t i = 0; i < histogram->parts; i++)
        shares[i] = histogram->count[i] / (double)stats->count;
    cJSON_AddNumberToObject(json, "histogram_low", histogram->low);
    cJSON_AddNumberToObject(json, "histogram_width", histogram->width);
    cJSON_AddItemToObject(json, "histogram", cJSON_CreateDoubleArray(shares, (int)histogram->parts));

    cJSON *active = cJSON_AddObjectToObject(json, "active");
    cJSON_AddItemToObject(active, "values",
                          cJSON_CreateDoubleArray(inventory->active.value, INVENTORY_SAMPLES));
    cJSON_AddItemToObject(active, "bricks_crossed",
                          cJSON_CreateDoubleArray(inventory->active.crossed, INVENTORY_SAMPLES));
    cJSON_AddItemToObject(active, "bricks_above",
                          cJSON_CreateDoubleArray(inventory->active.above, INVENTORY_SAMPLES));
    cJSON_AddItemToObject(active, "voxels_above",
                          cJSON_CreateDoubleArray(inventory->active.voxels, INVENTORY_SAMPLES));
}

static cJSON *sizes_json(const struct inventory *inventory)
{
    cJSON *sizes = cJSON_CreateObject();
    double values[INVENTORY_PERCENTILES], parts[INVENTORY_SIZE_PARTS];
    cJSON_AddNumberToObject(sizes, "count", (double)inventory->size.count);
    if (!inventory->size.count)
        return sizes;
    for (int i = 0; i < INVENTORY_PERCENTILES; i++)
        values[i] = inventory->size.percentile[i];
    for (int i = 0; i < INVENTORY_SIZE_PARTS; i++)
        parts[i] = (double)inventory->size.part[i];
    cJSON_AddNumberToObject(sizes, "smallest", inventory->size.smallest);
    cJSON_AddNumberToObject(sizes, "largest", inventory->size.largest);
    cJSON_AddNumberToObject(sizes, "mean", inventory->size.mean);
    cJSON_AddItemToObject(sizes, "percentiles", percentiles_json(values));
    cJSON_AddItemToObject(sizes, "by_share_of_decoded", cJSON_CreateDoubleArray(parts, INVENTORY_SIZE_PARTS));
    return sizes;
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
    cJSON_AddNumberToObject(json, "constant_share", (double)inventory->constant / (double)grid->bricks);
    cJSON_AddNumberToObject(json, "tolerance", brick_volume_tolerance(inventory->volume));
    cJSON *codecs = cJSON_AddArrayToObject(json, "codecs");
    for (int codec = 0; codec < BRICK_CODEC_COUNT; codec++)
        if (inventory->codec_used[codec])
            cJSON_AddItemToArray(codecs, cJSON_CreateString(brick_codec_name((enum brick_codec)codec)));
    cJSON_AddItemToObject(json, "levels", levels_json(inventory));
    cJSON_AddItemToObject(json, "brick_bytes", sizes_json(inventory));
    add_values(json, inventory);
    if (inventory->tf) {
        cJSON_AddStringToObject(json, "tf", inventory->tf);
        cJSON_AddNumberToObject(json, "bricks_active", (double)inventory->tf_active.bricks_active);
        cJSON_AddNumberToObject(json, "active_share",
                                (double)inventory->tf_active.bricks_active /
                                    (double)inventory->level[0].bricks);
        cJSON_AddNumberToObject(json, "bricks_interval", (double)inventory->tf_active.bricks_interval);
        if (inventory->macrocells) {
            cJSON_AddNumberToObject(json, "bricks_with_active_macrocells",
                                    (double)inventory->tf_active.bricks_macrocells);
            cJSON_AddNumberToObject(json, "macrocells", (double)inventory->tf_active.macrocells);
            cJSON_AddNumberToObject(json, "macrocells_active",
                                    (double)inventory->tf_active.macrocells_active);
            cJSON_AddNumberToObject(json, "bytes_read", (double)inventory->tf_active.bytes_read);
        }
    }
    cJSON_AddStringToObject(json, "provenance", provenance ? provenance : "");
    if (bricks)
        cJSON_AddItemToObject(json, "brick_list", bricks_json(inventory));
    return tool_json_print("info", json);
}
