/* Levels, brick places, axes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include <brick/grid.h>

static struct brick_geometry cube(uint64_t nx, uint64_t ny, uint64_t nz, double sx, double sy, double sz)
{
    return (struct brick_geometry){
        .dims = {nx, ny, nz}, .affine = {{sx}, {0, sy}, {0, 0, sz}}, .slope = 1.0, .intercept = 0.0};
}

static void bricks_tile_every_level(void **state)
{
    (void)state;
    struct brick_geometry g = cube(100, 33, 64, 1, 1, 2.5);
    struct brick_grid grid;
    struct brick_error err;
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 2, 8, &err), 0);
    uint64_t id = 0;
    for (uint32_t l = 0; l < grid.levels; l++) {
        uint64_t voxels = 0;
        const struct brick_level *level = &grid.level[l];
        for (uint64_t z = 0; z < level->bricks[2]; z++)
            for (uint64_t y = 0; y < level->bricks[1]; y++)
                for (uint64_t x = 0; x < level->bricks[0]; x++, id++) {
                    struct brick_place p;
                    assert_int_equal(brick_grid_id(&grid, l, x, y, z), id);
                    brick_grid_place(&grid, id, &p);
                    assert_true(p.level == l && p.at[0] == x && p.at[1] == y && p.at[2] == z);
                    assert_int_equal(p.lo[0], (int64_t)x * 32 - 2);
                    assert_int_equal(p.stored[1], p.core[1] + 4);
                    voxels += (uint64_t)p.core[0] * p.core[1] * p.core[2];
                    assert_true(brick_place_payload_bytes(&grid, &p) <= brick_grid_max_payload_bytes(&grid));
                }
        assert_int_equal(voxels, level->dims[0] * level->dims[1] * level->dims[2]);
    }
    assert_int_equal(id, grid.bricks);
}

/* A level's voxel centres and the volume's own: the means of both are one point on even axes. */
static void levels_do_not_shift(void **state)
{
    (void)state;
    struct brick_geometry g = cube(256, 128, 64, 0.5, 1, 3);
    struct brick_grid grid;
    struct brick_error err;
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 16, 2, 8, &err), 0);
    assert_true(grid.levels > 3);
    for (uint32_t l = 1; l < grid.levels; l++)
        for (int a = 0; a < 3; a++) {
            const struct brick_level *level = &grid.level[l];
            double centre = level->scale[a] * 0.5 * (double)(level->dims[a] - 1) + level->offset[a];
            assert_true(centre == 0.5 * (double)(g.dims[a] - 1));
            /* the finest axis is always halved, others only below twice its spacing */
            assert_true(level->scale[a] == 1.0 || level->scale[a] >= 2.0);
        }
}

static void thin_volumes_end_in_one_brick(void **state)
{
    (void)state;
    struct brick_geometry g = cube(1, 1, 1000000, 1, 1, 1);
    struct brick_grid grid;
    struct brick_error err;
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 2, 8, &err), 0);
    assert_true(grid.level[grid.levels - 1].dims[2] <= 32 && grid.level[grid.levels - 1].dims[0] == 1);
    g = cube(UINT64_C(1) << 40, 1, 1, 1, 1, 1);
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 2, 8, &err), 0);
    assert_int_equal(grid.levels, 36);
}

static void absurd_grids_are_refused(void **state)
{
    (void)state;
    struct brick_grid grid;
    struct brick_error err;
    struct brick_geometry g = cube(0, 5, 5, 1, 1, 1);
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 2, 8, &err), BRICK_ERR_ARGUMENT);
    g = cube(UINT64_C(1) << 40, UINT64_C(1) << 40, 1, 1, 1, 1);
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 2, 8, &err), BRICK_ERR_ARGUMENT);
    g = cube(UINT64_MAX, 1, 1, 1, 1, 1);
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 2, 8, &err), BRICK_ERR_ARGUMENT);
    const double spacings[] = {0.0, NAN, INFINITY, 1e-40};
    for (int i = 0; i < 4; i++) {
        g = cube(5, 5, 5, 1, spacings[i], 1);
        assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 2, 8, &err), BRICK_ERR_ARGUMENT);
    }
    g = cube(5, 5, 5, 1, 1, 1);
    g.affine[1][0] = 1.0; /* columns 0 and 1 in one plane with 2 */
    g.affine[0][0] = 0.0;
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 2, 8, &err), BRICK_ERR_ARGUMENT);
    g = cube(5, 5, 5, 1, 1, 1);
    g.slope = 0.0;
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 2, 8, &err), BRICK_ERR_ARGUMENT);
    g.slope = 1.0;
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 33, 2, 8, &err), BRICK_ERR_ARGUMENT);
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &g, 32, 1, 8, &err), BRICK_ERR_ARGUMENT);
    assert_int_equal(brick_grid_init(&grid, BRICK_F64, &g, 32, 2, 8, &err), BRICK_ERR_ARGUMENT);
    assert_int_equal(brick_grid_init(&grid, BRICK_F32, &g, 32, 2, 8, &err), 0);
}

static void axes_and_inverse(void **state)
{
    (void)state;
    struct brick_error err;
    const char *codes[] = {"LPS", "RAS", "SPL", "PIR", "ALI"};
    for (int i = 0; i < 5; i++) {
        double m[3][4], inverse[3][4];
        char back[4];
        assert_int_equal(
            brick_affine_from_axes(codes[i], (double[]){1, 2, 3}, (double[]){10, -20, 30}, m, &err), 0);
        brick_affine_axes(m, back);
        assert_string_equal(back, codes[i]);
        m[0][1] += 0.3; /* oblique */
        m[2][0] -= 0.2;
        brick_affine_invert(m, inverse);
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 4; c++) {
                double v = inverse[r][0] * m[0][c] + inverse[r][1] * m[1][c] + inverse[r][2] * m[2][c] +
                           (c == 3 ? inverse[r][3] : 0.0);
                assert_true(fabs(v - (r == c ? 1.0 : 0.0)) < 1e-13);
            }
    }
    double m[3][4];
    const char *bad[] = {"", "LP", "LLS", "LRS", "XYZ", "LPSX"};
    for (int i = 0; i < 6; i++)
        assert_int_equal(brick_affine_from_axes(bad[i], (double[]){1, 1, 1}, (double[]){0, 0, 0}, m, &err),
                         BRICK_ERR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bricks_tile_every_level),
        cmocka_unit_test(levels_do_not_shift),
        cmocka_unit_test(thin_volumes_end_in_one_brick),
        cmocka_unit_test(absurd_grids_are_refused),
        cmocka_unit_test(axes_and_inverse),
    };
    return cmocka_run_group_tests_name("grid", tests, NULL, NULL);
}
