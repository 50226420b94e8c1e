/* What `brick info` prints. */
#ifndef TOOLS_INVENTORY_H
#define TOOLS_INVENTORY_H

#include <stdbool.h>

#include <brick/volume.h>

#define INVENTORY_PERCENTILES 7
#define INVENTORY_ROWS        16

struct inventory {
    const struct brick_volume *volume;
    struct {
        uint64_t bricks, constant, voxel_bytes, payload_bytes;
    } level[BRICK_MAX_LEVELS];
    uint64_t constant;
    bool codec_used[BRICK_CODEC_COUNT];
    double spacing_mm[3];
    char axes[4];
    double range[2], mean, deviation; /* physical; of finite voxels */
    double percentile[INVENTORY_PERCENTILES];
    double row[INVENTORY_ROWS]; /* share of finite voxels in equal parts of the range */
    const char *tf;             /* NULL: not asked */
    uint64_t active;            /* bricks of level 0 that tf makes visible */
};

/* tf may be NULL. volume and tf outlive the inventory. */
int inventory_init(struct inventory *inventory, const struct brick_volume *volume, const char *tf,
                   struct brick_error *err);
void inventory_print_text(const struct inventory *inventory, bool bricks);
/* Exit code. */
int inventory_print_json(const struct inventory *inventory, bool bricks);

#endif
