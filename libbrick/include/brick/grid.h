/* The grid: where voxels are, in the file and in the world, and how they are cut into levels and bricks.
 *
 * x varies fastest. Voxel (i,j,k) is a sample at integer index coordinates; the volume covers [-1/2, n-1/2]
 * on each axis; the field between samples is trilinear and beyond the outermost sample constant. World (mm,
 * patient axes LPS) = affine x index.
 *
 * Levels: from level to level an axis is halved when its size is above 1 and its spacing is below twice the
 * finest spacing among the axes longer than 1. Voxel i of a halved axis averages 2i and 2i+1 and sits at 2i +
 * 1/2, so index0 = scale * i + offset with scale = 2^h and offset = (2^h - 1) / 2 after h halvings. The last
 * level fits one brick.
 *
 * Bricks: core of edge^3 voxels, less where the volume ends, and `border` voxels on every side. Brick
 * (bx,by,bz) of a level covers voxels [b*edge, min((b+1)*edge, n)) and stores [b*edge - border,
 * min((b+1)*edge, n) + border), the volume's edge repeated outward. Brick numbers count x fastest, level 0
 * first. */
#ifndef BRICK_GRID_H
#define BRICK_GRID_H

#include <stdint.h>

#include <brick/error.h>
#include <brick/type.h>

#ifdef __cplusplus
extern "C" {
#endif

#define BRICK_MAX_LEVELS 48
#define BRICK_MAX_DIM    (UINT64_C(1) << 40) /* voxels an axis */
#define BRICK_MAX_BRICKS (UINT64_C(1) << 36)

struct brick_level {
    uint64_t dims[3];     /* voxels */
    uint64_t bricks[3];   /* bricks on each axis */
    uint64_t first_brick; /* number of the level's first brick */
    double scale[3];      /* index0 = scale * index + offset */
    double offset[3];
};

struct brick_grid {
    enum brick_type type; /* stored type */
    uint64_t dims[3];     /* level 0, 1..BRICK_MAX_DIM */
    double affine[3][4];  /* index0 -> mm, LPS; invertible */
    double slope;         /* physical = slope * stored + intercept; slope != 0 */
    double intercept;
    uint32_t edge;      /* core edge in voxels: 8, 16, ... 256 */
    uint32_t border;    /* 2..8 */
    uint32_t macrocell; /* edge of a macrocell in voxels: 4, 8 or 16, at most edge */
    uint32_t levels;
    uint64_t bricks; /* of all levels */
    struct brick_level level[BRICK_MAX_LEVELS];
};

/* Where a volume is and what its numbers mean: the part of a grid that a source knows. */
struct brick_geometry {
    uint64_t dims[3];
    double affine[3][4];
    double slope, intercept;
};

/* Derive levels and brick counts. BRICK_ERR_ARGUMENT for a zero or absurd size, a singular or non-finite
 * affine, slope 0, or a brick layout outside the ranges above. */
int brick_grid_init(struct brick_grid *grid, enum brick_type type, const struct brick_geometry *geometry,
                    uint32_t edge, uint32_t border, uint32_t macrocell, struct brick_error *err);

/* One brick's place. */
struct brick_place {
    uint32_t level;
    uint64_t at[3];     /* brick coordinates in its level */
    int64_t lo[3];      /* first stored voxel (core start - border, may be negative) */
    uint32_t core[3];   /* core voxels, 1..edge */
    uint32_t stored[3]; /* core + 2 * border */
    uint32_t macrocells[3];
};
/* id < grid->bricks. */
void brick_grid_place(const struct brick_grid *grid, uint64_t id, struct brick_place *place);
uint64_t brick_grid_id(const struct brick_grid *grid, uint32_t level, uint64_t bx, uint64_t by, uint64_t bz);
/* Bytes of a decoded brick: stored voxels, then (min,max) pairs of its macrocells, all of the stored type. */
size_t brick_place_voxel_bytes(const struct brick_grid *grid, const struct brick_place *place);
size_t brick_place_payload_bytes(const struct brick_grid *grid, const struct brick_place *place);
/* The largest payload of any brick in the grid. */
size_t brick_grid_max_payload_bytes(const struct brick_grid *grid);

/* Edge lengths of a voxel in mm: norms of the affine's columns. */
void brick_grid_spacing_mm(const struct brick_grid *grid, double spacing_mm[3]);
double brick_grid_min_spacing_mm(const struct brick_grid *grid);
/* Inverse of the affine: index0 = inverse x (mm, 1). */
void brick_affine_invert(const double affine[3][4], double inverse[3][4]);
double brick_affine_determinant(const double affine[3][4]);
/* Affine of axis-aligned voxels: index axes along patient axes named by a code such as "LPS" or "RAI"
 * (the direction in which x, y, z grow). BRICK_ERR_ARGUMENT for a code that is not one letter from each pair.
 */
int brick_affine_from_axes(const char *code, const double spacing_mm[3], const double origin_mm[3],
                           double affine[3][4], struct brick_error *err);
/* The code (4 bytes with the end) of the patient axis nearest to each index axis. */
void brick_affine_axes(const double affine[3][4], char code[4]);

#ifdef __cplusplus
}
#endif
#endif
