/* The transfer function as the shaders read it (shaders/transfer.glsl): float32 pieces over stored values. */
#ifndef RENDERER_METHODS_RAYCAST_TRANSFER_TABLE_H
#define RENDERER_METHODS_RAYCAST_TRANSFER_TABLE_H

#include <brick/grid.h>
#include <brick/transfer.h>

struct vr_piece {
    float start, end;           /* end exclusive; the last piece has none */
    float sigma, sigma_slope;   /* at start, a unit of the value */
    float rgb[4], rgb_slope[4]; /* 3 used */
};

struct vr_transfer_table {
    struct vr_piece *pieces;
    uint32_t count;
    uint32_t *first_piece; /* a bin's first candidate */
    uint32_t bins;
    float bin_origin, bin_scale;
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
