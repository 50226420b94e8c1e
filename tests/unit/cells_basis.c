/* The basis hexahedron against rays that are cut by the planes of its tetrahedra, one by one; and the
 * traversal of cells. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "basis.h"
#include "memory_source.h"
#include "walk.h"

static double uniform(uint64_t seed, uint64_t i)
{
    return (double)(noise64(seed, i) >> 11) * 0x1p-53;
}

/* A grid whose voxels are sheared boxes, of nx x ny x nz. */
static void make_grid(struct brick_grid *grid, uint64_t nx, uint64_t ny, uint64_t nz)
{
    static const double affine[3][4] = {{0.9, 0.1, 0.0, 5}, {-0.1, 0.8, 0.05, -3}, {0.0, 0.1, -1.4, 100}};
    struct brick_geometry g = {.dims = {nx, ny, nz}, .slope = 1.0};
    memcpy(g.affine, affine, sizeof affine);
    assert_int_equal(brick_grid_init(grid, BRICK_U8, &g, 16, 2, 4, NULL), 0);
}

/* Into a picture so small that nothing of a cell is narrower than 1/64 of its pixels, unless it has no width.
 */
static void look_along(struct vr_lattice *lattice, const struct brick_grid *grid, const double direction[3])
{
    struct brick_camera camera = {.eye_mm = {3, 1, -2}, .up = {0.3, -0.2, 0.7}, .ortho_height_mm = 1e-6};
    struct brick_view view;
    for (int i = 0; i < 3; i++) {
        camera.look_mm[i] = camera.eye_mm[i];
        for (int j = 0; j < 3; j++)
            camera.look_mm[i] += grid->affine[i][j] * direction[j];
    }
    assert_int_equal(brick_view_init(&view, &camera, grid, 64, 48, NULL), 0);
    vr_lattice_init(lattice, &view, &grid->level[0]);
}

static void corner_of(int corner, const int side[3], double p[3])
{
    for (int a = 0; a < 3; a++) {
        p[a] = corner >> a & 1;
        if ((p[a] == 0.0 && side[a] < 0) || (p[a] == 1.0 && side[a] > 0))
            p[a] = 0.5;
    }
}

static double orient(const double a[3], const double b[3], const double c[3], const double d[3])
{
    double m[3][3];
    for (int i = 0; i < 3; i++)
        m[0][i] = b[i] - a[i], m[1][i] = c[i] - a[i], m[2][i] = d[i] - a[i];
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* Barycentric coordinates of p. */
static void coordinates(const double v[4][3], const double p[3], double out[4])
{
    double all = orient(v[0], v[1], v[2], v[3]);
    out[0] = orient(p, v[1], v[2], v[3]) / all;
    out[1] = orient(v[0], p, v[2], v[3]) / all;
    out[2] = orient(v[0], v[1], p, v[3]) / all;
    out[3] = orient(v[0], v[1], v[2], p) / all;
}

/* The ray's way through the tetrahedron: t of its ends, and coordinates there; false: it passes by. */
static bool clip_ray(const double v[4][3], const double origin[3], const double direction[3], double t[2],
                     double front[4], double back[4])
{
    double at0[4], at1[4], ahead[3];
    t[0] = -1e9, t[1] = 1e9;
    for (int i = 0; i < 3; i++)
        ahead[i] = origin[i] + direction[i];
    coordinates(v, origin, at0);
    coordinates(v, ahead, at1);
    for (int k = 0; k < 4; k++) {
        double rate = at1[k] - at0[k];
        if (fabs(rate) < 1e-8) {
            if (at0[k] < 0.0)
                return false;
        } else if (rate > 0.0) {
            t[0] = fmax(t[0], -at0[k] / rate);
        } else {
            t[1] = fmin(t[1], -at0[k] / rate);
        }
    }
    for (int k = 0; k < 4; k++) {
        front[k] = at0[k] + t[0] * (at1[k] - at0[k]);
        back[k] = at0[k] + t[1] * (at1[k] - at0[k]);
    }
    return t[1] > t[0];
}

/* What a fan says at a point of the picture: length, depth of entry, mixtures; false: outside. */
static bool read_fan(const struct vr_lattice *q, const struct vr_basis_tetrahedron *t, const double v[4][3],
                     const double at[2], double *length, double *entry, double front[4], double back[4])
{
    double place[5][3], mix[2][5][4] = {{{0}}}, way[5] = {0};
    const double *const rows[3] = {q->column, q->row, q->depth};
    for (int k = 0; k < 4; k++) {
        mix[0][k][k] = mix[1][k][k] = 1.0;
        for (int r = 0; r < 3; r++)
            place[k][r] = rows[r][0] * v[k][0] + rows[r][1] * v[k][1] + rows[r][2] * v[k][2] + rows[r][3];
    }
    for (int r = 0; r < 3; r++)
        place[4][r] = place[t->anchor][r] + t->offset[r];
    memcpy(mix[0][4], t->front, sizeof t->front);
    memcpy(mix[1][4], t->back, sizeof t->back);
    way[4] = t->length_mm;
    *length = *entry = 0.0;
    memset(front, 0, 4 * sizeof *front);
    memset(back, 0, 4 * sizeof *back);
    for (int i = 0; i < t->triangles; i++) {
        const int corner[3] = {VR_BASIS_THICK, t->around[i], t->around[(i + 1) % 4]};
        double w[3], all = 0.0;
        for (int k = 0; k < 3; k++) {
            const double *a = place[corner[(k + 1) % 3]], *b = place[corner[(k + 2) % 3]];
            w[k] = (a[0] - at[0]) * (b[1] - at[1]) - (a[1] - at[1]) * (b[0] - at[0]);
            all += w[k];
        }
        if (!(w[0] / all >= 0.0 && w[1] / all >= 0.0 && w[2] / all >= 0.0))
            continue;
        for (int k = 0; k < 3; k++) {
            *length += w[k] / all * way[corner[k]];
            *entry += w[k] / all * place[corner[k]][2];
            for (int j = 0; j < 4; j++) {
                front[j] += w[k] / all * mix[0][corner[k]][j];
                back[j] += w[k] / all * mix[1][corner[k]][j];
            }
        }
        return true;
    }
    return false;
}

/* One kind of cell from one direction. seen: classes that occurred. */
static void check_cell(const struct vr_lattice *q, const int side[3], int odd, uint64_t seed, int seen[5])
{
    struct vr_basis_cell cell;
    double v[6][4][3], volume = 0.0, whole = 1.0;
    int outside = 0;
    vr_basis_cell(q, side, odd, &cell);
    for (int a = 0; a < 3; a++) {
        outside += side[a] != 0;
        whole *= side[a] ? 0.5 : 1.0;
    }
    assert_int_equal(cell.count, outside == 1 ? 6 : 5);
    for (int i = 0; i < cell.count; i++) {
        for (int k = 0; k < 4; k++)
            corner_of(cell.tetrahedron[i].corner[k], side, v[i][k]);
        volume += fabs(orient(v[i][0], v[i][1], v[i][2], v[i][3])) / 6.0;
        seen[cell.tetrahedron[i].projection_class]++;
    }
    assert_true(fabs(volume - whole) < 1e-12);
    for (int trial = 0; trial < 60; trial++) {
        double p[3], at[2], last = 1e9, sum = 0.0, enter = 1e9, leave = -1e9;
        for (int a = 0; a < 3; a++) /* inside, and a little around */
            p[a] = -0.2 + 1.4 * uniform(seed, (uint64_t)(3 * trial + a));
        at[0] = q->column[0] * p[0] + q->column[1] * p[1] + q->column[2] * p[2] + q->column[3];
        at[1] = q->row[0] * p[0] + q->row[1] * p[1] + q->row[2] * p[2] + q->row[3];
        double depth = q->depth[0] * p[0] + q->depth[1] * p[1] + q->depth[2] * p[2] + q->depth[3];
        for (int i = 0; i < cell.count; i++) {
            double t[2], front[4], back[4], f[4], b[4], length, entry;
            bool hit = clip_ray(v[i], p, q->direction, t, front, back);
            bool fan = read_fan(q, &cell.tetrahedron[i], v[i], at, &length, &entry, f, b);
            if (!hit || t[1] - t[0] < 1e-7) { /* an edge is either's */
                if (fan)
                    assert_true(length < 2e-7);
                continue;
            }
            assert_true(fan);
            assert_true(fabs(length - (t[1] - t[0])) < 1e-8);
            assert_true(fabs(entry - (depth + t[0])) < 1e-8);
            for (int k = 0; k < 4; k++)
                assert_true(fabs(f[k] - front[k]) < 1e-7 && fabs(b[k] - back[k]) < 1e-7);
            /* Farthest first. */
            assert_true(t[1] < last + 1e-8);
            last = t[0];
            sum += t[1] - t[0];
            enter = fmin(enter, t[0]);
            leave = fmax(leave, t[1]);
        }
        /* No gap between, and no place twice. */
        if (sum > 0.0)
            assert_true(fabs(sum - (leave - enter)) < 1e-6);
    }
}

static void test_projection(void **state)
{
    static const double special[][3] = {{1, 0, 0},     {0, -1, 0},      {0, 0, 1},    {1, 1, 0},  {-1, 0, 1},
                                        {0, 1, -1},    {1, 1, 1},       {1, -1, 1},   {-1, 1, 1}, {1, 2, 0},
                                        {1, 1e-11, 0}, {1, 1e-6, 1e-7}, {1, 1, 1e-5}, {2, 1, 1}};
    const int specials = sizeof special / sizeof *special;
    struct brick_grid grid;
    int seen[5] = {0};
    (void)state;
    make_grid(&grid, 20, 30, 40);
    for (int view = 0; view < 60; view++) {
        struct vr_lattice q;
        double direction[3];
        for (int a = 0; a < 3; a++)
            direction[a] = view < specials ? special[view][a] : uniform(5, (uint64_t)(3 * view + a)) - 0.5;
        look_along(&q, &grid, direction);
        for (int s = 0; s < 27; s++)
            for (int odd = 0; odd < 2; odd++)
                check_cell(&q, (const int[]){s % 3 - 1, s / 3 % 3 - 1, s / 9 - 1}, odd,
                           (uint64_t)(view * 54 + s * 2 + odd), seen);
    }
    print_message("tetrahedra of classes 1 to 4: %d, %d, %d, %d\n", seen[1], seen[2], seen[3], seen[4]);
    for (int c = 1; c <= 4; c++)
        assert_true(seen[c] > 0);
}

/* Along an axis a cell is a square: the middle tetrahedron's edges cross in it, and each of the others is a
 * triangle. Along a diagonal of a face there are classes 3. */
static void test_classes(void **state)
{
    struct brick_grid grid;
    struct vr_lattice q;
    struct vr_basis_cell cell;
    int count[5] = {0}, triangles[VR_BASIS_SLOTS];
    static float table[VR_BASIS_TABLE_FLOATS];
    (void)state;
    make_grid(&grid, 20, 30, 40);
    look_along(&q, &grid, (const double[]){0, 0, 1});
    vr_basis_cell(&q, (const int[]){0, 0, 0}, 0, &cell);
    for (int i = 0; i < 5; i++)
        count[cell.tetrahedron[i].projection_class]++;
    assert_int_equal(count[2], 1);
    assert_int_equal(count[4], 4);
    vr_basis_table(&q, table, triangles);
    int sum = 0;
    for (int s = 0; s < VR_BASIS_SLOTS; s++)
        sum += triangles[s];
    assert_true(sum < 5 * 4); /* parallel views have fewer triangles (section 6) */
}

/* Two cells that share a face lay the same diagonal through it: the one between voxels of even sums. */
static void test_faces_match(void **state)
{
    struct brick_grid grid;
    struct vr_lattice q;
    (void)state;
    make_grid(&grid, 20, 30, 40);
    look_along(&q, &grid, (const double[]){0.3, 0.2, 1});
    for (int s = 0; s < 27; s++)
        for (int odd = 0; odd < 2; odd++) {
            const int side[3] = {s % 3 - 1, s / 3 % 3 - 1, s / 9 - 1};
            int outside = (side[0] != 0) + (side[1] != 0) + (side[2] != 0);
            struct vr_basis_cell cell;
            vr_basis_cell(&q, side, odd, &cell);
            for (int i = 0; i < cell.count && outside <= 1; i++)
                for (int a = 0; a < 4; a++)
                    for (int b = 0; b < a; b++) {
                        int from = cell.tetrahedron[i].corner[a], to = cell.tetrahedron[i].corner[b];
                        int across = from ^ to, in_face = 0;
                        for (int axis = 0; axis < 3; axis++) { /* of the faces that lie inside the volume */
                            bool low = !(from >> axis & 1);
                            if (!(across >> axis & 1) && side[axis] != (low ? -1 : 1) &&
                                outside == (side[axis] != 0))
                                in_face = 1;
                        }
                        if (__builtin_popcount((unsigned)across) == 2 && in_face)
                            assert_int_equal((__builtin_popcount((unsigned)from) + odd) % 2, 0);
                    }
        }
}

static bool everything(const void *context, const double low[3], const double high[3])
{
    (void)context;
    for (int a = 0; a < 3; a++)
        assert_true(low[a] < high[a]);
    return true;
}

/* Every cell once, from far to near on every axis; together all tetrahedra of the level. */
static void check_walk(const uint64_t n[3], const double eye[3], bool whole)
{
    struct brick_grid grid;
    make_grid(&grid, n[0], n[1], n[2]);
    uint64_t tetrahedra = 0,
             bricks = grid.level[0].bricks[0] * grid.level[0].bricks[1] * grid.level[0].bricks[2];
    uint32_t *visited = calloc((n[0] + 1) * (n[1] + 1) * (n[2] + 1), sizeof *visited), turn = 0;
    for (uint64_t b = 0; b < bricks; b++) {
        struct vr_cell_walk walk = {.whole = whole, .visible = everything};
        struct brick_place place;
        memcpy(walk.eye, eye, sizeof walk.eye);
        brick_grid_place(&grid, b, &place);
        vr_cell_walk_init(&walk, &grid, &place);
        uint32_t *entries = malloc(vr_cell_walk_most(&walk) * sizeof *entries);
        for (uint32_t m = 0; m < walk.macrocells[0] * walk.macrocells[1] * walk.macrocells[2]; m++) {
            size_t count = vr_cell_walk_macrocell(&walk, m, entries);
            assert_true(count <= vr_cell_walk_most(&walk));
            for (size_t i = 0; i < count; i++) {
                uint64_t at[3];
                for (int a = 0; a < 3; a++)
                    at[a] = (uint64_t)walk.first[a] + (entries[i] >> 9 * a & 511);
                uint32_t *cell = &visited[(at[2] * (n[1] + 1) + at[1]) * (n[0] + 1) + at[0]];
                uint32_t number = entries[i] >> VR_CELL_PIECE_BIT;
                bool second = number && !whole;
                tetrahedra += second ? 1 : 5 + number;
                if (second)
                    assert_int_equal(*cell, turn);
                else
                    assert_int_equal(*cell, 0);
                *cell = second ? turn : ++turn;
            }
        }
        free(entries);
    }
    assert_int_equal(tetrahedra, vr_cell_tetrahedra(&grid.level[0]));
    assert_int_equal(turn, (n[0] + 1) * (n[1] + 1) * (n[2] + 1));
    for (uint64_t z = 0; z <= n[2]; z++)
        for (uint64_t y = 0; y <= n[1]; y++)
            for (uint64_t x = 0; x <= n[0]; x++) {
                const uint64_t at[3] = {x, y, z};
                const size_t stride[3] = {1, n[0] + 1, (n[0] + 1) * (n[1] + 1)};
                size_t here = x + y * stride[1] + z * stride[2];
                assert_true(visited[here] != 0);
                for (int a = 0; a < 3; a++) {
                    /* Cell at - 1 on this axis, which begins there; bricks begin at multiples of 16, their
                     * order is not the walk's. */
                    if (at[a] == 0 || (at[a] > 1 && (at[a] - 1) % 16 == 0))
                        continue;
                    uint32_t before = visited[here - stride[a]];
                    assert_true(eye[a] >= (double)at[a] - 1.0 ? before < visited[here]
                                                              : before > visited[here]);
                }
            }
    free(visited);
}

static void test_walk(void **state)
{
    static const uint64_t sizes[][3] = {{21, 16, 33}, {1, 5, 9}, {1, 1, 1}, {17, 1, 40}};
    static const double eyes[][3] = {{-INFINITY, INFINITY, -INFINITY}, /* parallel rays */
                                     {4.5, 3.2, 22.9},
                                     {16.1, 15.8, 0.3},
                                     {-0.3, -0.7, 1e9},
                                     {20.4, 7.6, 32.2}};
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (size_t e = 0; e < sizeof eyes / sizeof *eyes; e++)
            check_walk(sizes[i], eyes[e], e > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_projection),
        cmocka_unit_test(test_classes),
        cmocka_unit_test(test_faces_match),
        cmocka_unit_test(test_walk),
    };
    return cmocka_run_group_tests_name("cells_basis", tests, NULL, NULL);
}
