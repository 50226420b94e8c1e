/* The transfer function as rays read it (shaders/transfer.glsl, cast/): float32 pieces over stored values. */
#ifndef RENDERER_SCENE_TRANSFER_TABLE_H
#define RENDERER_SCENE_TRANSFER_TABLE_H

#include <brick/grid.h>
#include <brick/transfer.h>

struct vr_piece {
    float start;              /* a value belongs to the last piece that starts at or below it */
    float sigma, sigma_slope; /* at start, a unit of the value */
    float origin;             /* that the slopes count from: start, or 0 where nothing changes */
    float rgb[3], end;        /* end: where the next piece starts, FLT_MAX for the last */
    float rgb_slope[3], unused;
};

/* Pieces that values of a bin can belong to. */
struct vr_bin {
    uint32_t first, last;
};

struct vr_transfer_table {
    struct vr_piece *pieces;
    uint32_t count;
    struct vr_bin *bins;
    uint32_t bin_count;
    float bin_origin, bin_scale;
    float visible[2];      /* all values outside are transparent */
    uint32_t search_steps; /* halvings that leave one piece of any bin */
};

/* The smallest float f with |slope| f + intercept >= value, in double: comparing floats with it is comparing
 * their physical values with `value`, without rounding. +-FLT_MAX or infinite at the ends. */
float vr_stored_threshold(const struct brick_grid *grid, double value);

/* Stored values are taken times the sign of the slope, so that they ascend with the physical ones. A value
 * that is transparent in `transfer` is transparent in the table. */
int vr_transfer_table_init(struct vr_transfer_table *table, const struct brick_transfer *transfer,
                           const struct brick_grid *grid, struct brick_error *err);
void vr_transfer_table_finish(struct vr_transfer_table *table);

#endif
