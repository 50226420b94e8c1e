/* Where bricks are seen: no ray that meets an active brick has its pixel in a tile that is not marked, from
 * outside and inside, perspective and parallel, for parts of pictures; and tiles far from all bricks are not
 * marked. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include <brick/active.h>

#include "footprint.h"

enum { WIDTH = 150, HEIGHT = 110, EDGE = 16, ACROSS = 12, TILES = ACROSS * 8 };

static uint32_t state = 7;

static double random_in(double low, double high)
{
    state = state * 1664525u + 1013904223u;
    return low + (high - low) * (double)(state >> 8) / 16777216.0;
}

static bool meets(const struct brick_ray *ray, const double low[3], const double high[3])
{
    double enter = 0.0, leave = INFINITY;
    for (int a = 0; a < 3; a++) {
        double p = (low[a] - ray->origin[a]) / ray->direction[a],
               q = (high[a] - ray->origin[a]) / ray->direction[a];
        enter = fmax(enter, fmin(p, q));
        leave = fmin(leave, fmax(p, q));
    }
    return enter < leave;
}

/* Does a ray of the tile meet the place where brick b's cells are? */
static bool seen(const struct brick_view *view, const struct brick_grid *grid, const uint8_t *states,
                 uint32_t x, uint32_t y)
{
    const struct brick_level *l = &grid->level[0];
    struct brick_ray ray;
    brick_view_ray(view, x, y, &ray);
    for (uint64_t b = 0; b < l->bricks[0] * l->bricks[1] * l->bricks[2]; b++) {
        const uint64_t at[3] = {b % l->bricks[0], b / l->bricks[0] % l->bricks[1],
                                b / l->bricks[0] / l->bricks[1]};
        double low[3], high[3];
        for (int a = 0; a < 3; a++) {
            low[a] = at[a] ? (double)(at[a] * grid->edge) : -0.5;
            high[a] =
                at[a] + 1 < l->bricks[a] ? (double)((at[a] + 1) * grid->edge) : (double)grid->dims[a] - 0.5;
        }
        if (states[b] >= BRICK_STATE_ACTIVE && meets(&ray, low, high))
            return true;
    }
    return false;
}

static void test_rays(void **unused)
{
    (void)unused;
    const struct brick_geometry geometry = {
        .dims = {70, 50, 37}, .affine = {{0.8, 0.1, 0, -3}, {0, -1.1, 0.2, 5}, {0, 0, 1.5, 9}}, .slope = 1.0};
    const struct vr_tiles parts[] = {{0, 0, WIDTH, HEIGHT, EDGE, ACROSS}, {37, 21, 60, 50, EDGE, ACROSS}};
    struct brick_grid grid;
    uint8_t states[5 * 4 * 3];
    int marked = 0, tiles = 0, hits = 0;
    assert_int_equal(brick_grid_init(&grid, BRICK_U8, &geometry, 16, 2, 4, NULL), 0);
    for (int n = 0; n < 60; n++) {
        const bool inside = n % 3 == 0;
        struct brick_camera camera = {.up = {0.1, 0.2, 1}, .fov_deg = random_in(20, 90)};
        struct brick_view view;
        for (int a = 0; a < 3; a++) {
            const double centre = (double[]){25, -20, 35}[a];
            camera.look_mm[a] = centre + random_in(-20, 20);
            camera.eye_mm[a] = centre + random_in(-1, 1) * (inside ? 10 : 150);
        }
        if (n % 4 == 1)
            camera.ortho_height_mm = random_in(20, 200);
        for (size_t b = 0; b < sizeof states; b++)
            states[b] = random_in(0, 1) < 0.1 ? BRICK_STATE_ACTIVE : BRICK_STATE_ABOVE;
        assert_int_equal(brick_view_init(&view, &camera, &grid, WIDTH, HEIGHT, NULL), 0);
        for (size_t p = 0; p < sizeof parts / sizeof *parts; p++) {
            uint32_t flags[TILES];
            memset(flags, 0xff, sizeof flags);
            vr_footprint(&view, &grid, 0, states, &parts[p], flags);
            for (int y = 0; y < parts[p].height; y++)
                for (int x = 0; x < parts[p].width; x++) {
                    uint32_t flag = flags[y / EDGE * ACROSS + x / EDGE];
                    assert_true(flag <= 1);
                    if (seen(&view, &grid, states, (uint32_t)(parts[p].x + x), (uint32_t)(parts[p].y + y))) {
                        assert_int_equal(flag, 1);
                        hits++;
                    }
                    marked += flag == 1;
                    tiles++;
                }
        }
    }
    /* It tells something: much is met, and not much more is marked. */
    assert_true(hits > tiles / 10);
    assert_true(marked < tiles * 3 / 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_rays)};
    return cmocka_run_group_tests_name("footprint", tests, NULL, NULL);
}
