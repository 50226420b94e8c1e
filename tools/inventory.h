/* What `brick info` knows: gathered from the tables alone, printed as text or JSON, drawn by report.c. */
#ifndef TOOLS_INVENTORY_H
#define TOOLS_INVENTORY_H

#include <stdbool.h>

#include <brick/active.h>
#include <brick/volume.h>

#include "histogram.h"

#define INVENTORY_PERCENTILES 7
#define INVENTORY_SAMPLES     129
#define INVENTORY_SIZE_PARTS  20
extern const double inventory_shares[INVENTORY_PERCENTILES]; /* 0.01 .. 0.99 */

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
    struct histogram histogram;
    /* Bytes of the payloads of all levels; constant bricks have none. */
    struct {
        uint64_t count;
        uint32_t smallest, largest;
        double mean;
        uint32_t percentile[INVENTORY_PERCENTILES];
        uint64_t part[INVENTORY_SIZE_PARTS]; /* bricks by payload / decoded size; the last part is open */
    } size;
    /* Against values at equal distances over the range, the ends included. */
    struct {
        double value[INVENTORY_SAMPLES];
        double crossed[INVENTORY_SAMPLES]; /* share of level 0's bricks that an isosurface may cross */
        double above[INVENTORY_SAMPLES];   /* share of them that may reach the value */
        double voxels[INVENTORY_SAMPLES];  /* share of finite voxels at or above it */
    } active;
    const char *tf;                        /* NULL: not asked */
    bool macrocells;                       /* the last fields of tf_active were asked for */
    struct brick_active_summary tf_active; /* of level 0: what tf makes visible */
};

/* tf may be NULL. macrocells: read the bricks that tf makes visible, with so many threads, and count the
 * macrocells that it does. volume and tf outlive the inventory. */
int inventory_init(struct inventory *inventory, const struct brick_volume *volume, const char *tf,
                   bool macrocells, uint32_t threads, struct brick_error *err);
/* log_scale: the histogram's bars. */
void inventory_print_text(const struct inventory *inventory, bool bricks, bool log_scale);
/* Exit code. */
int inventory_print_json(const struct inventory *inventory, bool bricks);

#endif
