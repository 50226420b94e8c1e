/* A row of bricks (all of one bz) is worked on in tiles: runs of bricks that follow each other in the file,
 * so either whole lines of bricks along x, or part of one line. */
#ifndef BRICK_BUILD_TILE_H
#define BRICK_BUILD_TILE_H

#include <stdbool.h>

#include <brick/grid.h>

struct tile {
    uint32_t level;
    uint64_t row;            /* bz */
    uint64_t from[2], to[2]; /* bricks [from, to) along x and y */
};

/* A box of voxels [lo, hi). */
struct box {
    uint64_t lo[3], hi[3];
};

/* The row's first tile; shape: bricks along x and y, shape[1] > 1 only with whole lines. */
struct tile tile_first(const struct brick_grid *grid, const uint64_t shape[2], uint32_t level, uint64_t row);
/* The row's next tile; false after its last. */
bool tile_next(const struct brick_grid *grid, const uint64_t shape[2], struct tile *tile);
uint64_t tile_first_brick(const struct brick_grid *grid, const struct tile *tile);
uint64_t tile_bricks(const struct tile *tile);
/* The voxels of its bricks' cores, and with their borders inside the volume. */
struct box tile_core(const struct brick_grid *grid, const struct tile *tile);
struct box tile_stored(const struct brick_grid *grid, const struct tile *tile);
/* The next level's voxels that its core makes; halved: which axes were. */
struct box tile_coarse(const struct brick_grid *grid, const struct tile *tile, bool halved[3]);

#endif
