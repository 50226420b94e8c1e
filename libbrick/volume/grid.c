/* Levels and bricks from sizes. Everything here is pure arithmetic on checked numbers: once brick_grid_init
 * has succeeded, no product of sizes below can overflow 64 bits. */
#include <brick/grid.h>

#include <math.h>
#include <string.h>

#include <brick/checked.h>

static bool power_of_two(uint32_t v)
{
    return v && !(v & (v - 1));
}

static int check_layout(uint32_t edge, uint32_t border, uint32_t macrocell, struct brick_error *err)
{
    if (!power_of_two(edge) || edge < 8 || edge > 256)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "brick edge %u is not one of 8, 16, 32, 64, 128, 256",
                          edge);
    if (border < 2 || border > 8)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "border %u is not in 2..8", border);
    if (!power_of_two(macrocell) || macrocell < 4 || macrocell > 16 || macrocell > edge)
        return brick_fail(err, BRICK_ERR_ARGUMENT,
                          "macrocell edge %u is not one of 4, 8, 16 up to the brick's", macrocell);
    return BRICK_OK;
}

static int check_geometry(const struct brick_geometry *g, struct brick_error *err)
{
    static const char axis_name[3] = {'x', 'y', 'z'};
    uint64_t voxels;
    for (int a = 0; a < 3; a++)
        if (g->dims[a] == 0 || g->dims[a] > BRICK_MAX_DIM)
            return brick_fail(err, BRICK_ERR_ARGUMENT, "size %llu on axis %c is not in 1..2^40",
                              (unsigned long long)g->dims[a], axis_name[a]);
    if (!brick_mul3_u64(g->dims[0], g->dims[1], g->dims[2], &voxels) || voxels > UINT64_C(1) << 58)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%llu x %llu x %llu voxels are more than 2^58",
                          (unsigned long long)g->dims[0], (unsigned long long)g->dims[1],
                          (unsigned long long)g->dims[2]);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            if (!isfinite(g->affine[r][c]))
                return brick_fail(err, BRICK_ERR_ARGUMENT, "the affine holds a number that is not finite");
    /* Singular relative to its own columns: a spacing of 1e-9 mm is legal, three parallel axes are not. */
    double norms = 1.0;
    for (int c = 0; c < 3; c++) {
        double n = sqrt(g->affine[0][c] * g->affine[0][c] + g->affine[1][c] * g->affine[1][c] +
                        g->affine[2][c] * g->affine[2][c]);
        if (!(n > 1e-30) || !(n < 1e30))
            return brick_fail(err, BRICK_ERR_ARGUMENT, "voxel spacing %g mm on axis %c is not in 1e-30..1e30",
                              n, axis_name[c]);
        norms *= n;
    }
    if (!(fabs(brick_affine_determinant(g->affine)) > 1e-9 * norms))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the affine is singular: its axes do not span space");
    if (!isfinite(g->slope) || !isfinite(g->intercept) || g->slope == 0.0)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "slope %g and intercept %g do not make physical values",
                          g->slope, g->intercept);
    return BRICK_OK;
}

int brick_grid_init(struct brick_grid *grid, enum brick_type type, const struct brick_geometry *geometry,
                    uint32_t edge, uint32_t border, uint32_t macrocell, struct brick_error *err)
{
    int code = check_layout(edge, border, macrocell, err);
    if (code || (code = check_geometry(geometry, err)))
        return code;
    if ((unsigned)type >= BRICK_TYPE_STORED_COUNT)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "type %d cannot be stored", (int)type);

    memset(grid, 0, sizeof *grid);
    grid->type = type;
    memcpy(grid->dims, geometry->dims, sizeof grid->dims);
    memcpy(grid->affine, geometry->affine, sizeof grid->affine);
    grid->slope = geometry->slope;
    grid->intercept = geometry->intercept;
    grid->edge = edge;
    grid->border = border;
    grid->macrocell = macrocell;

    double spacing[3];
    brick_grid_spacing_mm(grid, spacing);
    struct brick_level level = {.scale = {1, 1, 1}};
    memcpy(level.dims, geometry->dims, sizeof level.dims);
    for (;;) {
        uint64_t n = 1;
        for (int a = 0; a < 3; a++) {
            level.bricks[a] = (level.dims[a] + edge - 1) / edge;
            if (!brick_mul_u64(n, level.bricks[a], &n) || n > BRICK_MAX_BRICKS)
                return brick_fail(err, BRICK_ERR_ARGUMENT, "more than 2^36 bricks: choose a larger brick");
        }
        level.first_brick = grid->bricks;
        grid->level[grid->levels++] = level;
        grid->bricks += n;
        if (n == 1)
            return BRICK_OK;
        double finest = INFINITY;
        for (int a = 0; a < 3; a++)
            if (level.dims[a] > 1 && spacing[a] < finest)
                finest = spacing[a];
        for (int a = 0; a < 3; a++)
            if (level.dims[a] > 1 && spacing[a] < 2.0 * finest) {
                level.dims[a] = (level.dims[a] + 1) / 2;
                spacing[a] *= 2.0;
                level.offset[a] += 0.5 * level.scale[a];
                level.scale[a] *= 2.0;
            }
        /* A volume with one coarse axis takes some levels on the finer ones first; 3 x 40 halvings are
         * possible only with absurd spacing ratios, so the limit is a matter of refusing those. */
        if (grid->levels == BRICK_MAX_LEVELS)
            return brick_fail(err, BRICK_ERR_ARGUMENT, "more than %d levels: the spacings differ too much",
                              BRICK_MAX_LEVELS);
    }
}

void brick_grid_place(const struct brick_grid *grid, uint64_t id, struct brick_place *place)
{
    uint32_t l = 0;
    while (l + 1 < grid->levels && id >= grid->level[l + 1].first_brick)
        l++;
    const struct brick_level *level = &grid->level[l];
    uint64_t i = id - level->first_brick;
    place->level = l;
    place->at[0] = i % level->bricks[0];
    place->at[1] = i / level->bricks[0] % level->bricks[1];
    place->at[2] = i / level->bricks[0] / level->bricks[1];
    for (int a = 0; a < 3; a++) {
        uint64_t start = place->at[a] * grid->edge, left = level->dims[a] - start;
        place->lo[a] = (int64_t)start - (int64_t)grid->border;
        place->core[a] = left < grid->edge ? (uint32_t)left : grid->edge;
        place->stored[a] = place->core[a] + 2 * grid->border;
        place->macrocells[a] = (place->core[a] + grid->macrocell - 1) / grid->macrocell;
    }
}

uint64_t brick_grid_id(const struct brick_grid *grid, uint32_t level, uint64_t bx, uint64_t by, uint64_t bz)
{
    const struct brick_level *l = &grid->level[level];
    return l->first_brick + (bz * l->bricks[1] + by) * l->bricks[0] + bx;
}

size_t brick_place_voxel_bytes(const struct brick_grid *grid, const struct brick_place *place)
{
    return (size_t)place->stored[0] * place->stored[1] * place->stored[2] * brick_type_bytes(grid->type);
}

size_t brick_place_payload_bytes(const struct brick_grid *grid, const struct brick_place *place)
{
    return brick_place_voxel_bytes(grid, place) + (size_t)2 * place->macrocells[0] * place->macrocells[1] *
                                                      place->macrocells[2] * brick_type_bytes(grid->type);
}

size_t brick_grid_max_payload_bytes(const struct brick_grid *grid)
{
    /* The first brick of level 0 is as large as any: other bricks and levels only lose voxels at their ends.
     */
    struct brick_place place;
    brick_grid_place(grid, 0, &place);
    return brick_place_payload_bytes(grid, &place);
}
