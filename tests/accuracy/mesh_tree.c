/* The nearest triangle on a ray: against trying all of them, against closed forms, and no ray slips out
 * of a closed mesh, through its vertices and edges included. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "mesh_tree.h"

static uint64_t seed = 1;

static double uniform(void)
{
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(seed >> 11) * 0x1p-53;
}

static void add(struct brick_mesh *mesh, double x, double y, double z)
{
    assert_int_equal(brick_mesh_add_vertex(mesh, (const double[]){x, y, z}, NULL, NULL, NULL), 0);
}

static struct vr_mesh_tree *tree_of(const struct vr_mesh *meshes, uint32_t count)
{
    struct vr_mesh_tree *tree = NULL;
    assert_int_equal(vr_mesh_tree_create(&tree, meshes, count, NULL), 0);
    return tree;
}

/* Towards a point. */
static struct brick_ray ray_to(const double from[3], const double to[3])
{
    struct brick_ray ray;
    double length = 0.0;
    for (int i = 0; i < 3; i++) {
        ray.origin[i] = from[i];
        ray.direction[i] = to[i] - from[i];
        length = hypot(length, ray.direction[i]);
    }
    for (int i = 0; i < 3; i++)
        ray.direction[i] /= length;
    return ray;
}

/* Any number of triangles of any shape, in several meshes; each alone is a tree of one. */
static void nearest_of_all(void **state)
{
    (void)state;
    for (int count = 1; count < 60; count += count < 12 ? 1 : 7) {
        struct brick_mesh mesh[60] = {{0}};
        struct vr_mesh item[60];
        int hits = 0;
        for (int m = 0; m < count; m++) {
            for (int k = 0; k < 3; k++) /* some flat, some large */
                add(&mesh[m], 10 * uniform(), 10 * uniform(), m % 3 ? 10 * uniform() : 5.0 + m / 64.0);
            assert_int_equal(brick_mesh_add_polygon(&mesh[m], (const uint64_t[]){0, 1, 2}, 3, NULL), 0);
            item[m] = (struct vr_mesh){&mesh[m], {m / 64.0, 0.5, 0.25}};
        }
        struct vr_mesh_tree *all = tree_of(item, (uint32_t)count);
        for (int r = 0; r < 400; r++) {
            const double from[3] = {20 * uniform() - 5, 20 * uniform() - 5, 20 * uniform() - 5};
            double to[3] = {10 * uniform(), 10 * uniform(), 10 * uniform()};
            if (r % 4 == 0)
                memcpy(to, from, sizeof to), to[r / 4 % 3] += r % 8 ? 1 : -1; /* along an axis */
            struct brick_ray ray = ray_to(from, to);
            struct vr_mesh_hit best = {.t_mm = INFINITY}, got;
            for (int m = 0; m < count; m++) {
                struct vr_mesh_tree *one = tree_of(&item[m], 1);
                struct vr_mesh_hit hit;
                if (vr_mesh_tree_first(one, &ray, &hit) && hit.t_mm < best.t_mm)
                    best = hit;
                vr_mesh_tree_destroy(&one);
            }
            assert_int_equal(vr_mesh_tree_first(all, &ray, &got), best.t_mm < INFINITY);
            if (best.t_mm < INFINITY) {
                hits++;
                assert_true(got.t_mm == best.t_mm);
                assert_memory_equal(got.rgb, best.rgb, sizeof got.rgb);
                assert_memory_equal(got.normal, best.normal, sizeof got.normal);
            }
        }
        assert_true(count < 4 || hits > 20);
        vr_mesh_tree_destroy(&all);
        for (int m = 0; m < count; m++)
            brick_mesh_finish(&mesh[m]);
    }
}

/* A bumpy closed body around the origin: from inside every ray meets it, at a vertex, on an edge, anywhere.
 */
static void nothing_slips_out(void **state)
{
    enum { N = 20 };
    struct brick_mesh mesh = {0};
    (void)state;
    for (int i = 0; i <= N; i++)
        for (int j = 0; j < 2 * N; j++) {
            double a = M_PI * i / N, b = M_PI * j / N, r = 5.0 + 3.0 * uniform();
            if (i == 0 || i == N) { /* one point, not nearly one */
                add(&mesh, 0, 0, i ? -7 : 7);
                continue;
            }
            add(&mesh, r * sin(a) * cos(b), r * sin(a) * sin(b), r * cos(a));
        }
    for (int i = 0; i < N; i++)
        for (int j = 0; j < 2 * N; j++) {
            const uint64_t p = (uint64_t)(i * 2 * N + j), q = (uint64_t)(i * 2 * N + (j + 1) % (2 * N));
            const uint64_t low[3] = {p + 2 * N, q + 2 * N, q}, high[3] = {p, p + 2 * N, q};
            assert_int_equal(brick_mesh_add_polygon(&mesh, low, 3, NULL), 0);
            assert_int_equal(brick_mesh_add_polygon(&mesh, high, 3, NULL), 0);
        }
    const struct vr_mesh item = {&mesh, {1, 1, 1}};
    struct vr_mesh_tree *tree = tree_of(&item, 1);
    for (uint64_t r = 0; r < 60000; r++) {
        const uint32_t *corner = mesh.triangle[r / 3 % mesh.triangles];
        const double *p = mesh.position_mm[corner[0]], *q = mesh.position_mm[corner[1]];
        double from[3] = {0}, to[3], share = uniform();
        for (int i = 0; i < 3; i++) {
            from[i] = r % 2 ? 0.0 : uniform() - 0.5;
            to[i] = r % 3 == 0 ? p[i] : r % 3 == 1 ? p[i] + share * (q[i] - p[i]) : uniform() - 0.5;
        }
        struct brick_ray ray = ray_to(from, to);
        struct vr_mesh_hit hit;
        if (!vr_mesh_tree_first(tree, &ray, &hit))
            fail_msg("ray %llu slips out", (unsigned long long)r);
        assert_true(hit.t_mm > 1.0 && hit.t_mm < 10.0);
    }
    vr_mesh_tree_destroy(&tree);
    brick_mesh_finish(&mesh);
}

/* The plane x + 2 y + 3 z = 60: t, colours and normals between the corners; nothing behind the eye, and
 * nothing of a triangle seen edge on. */
static void values_on_a_plane(void **state)
{
    static const double corner[3][3] = {{60, 0, 0}, {0, 30, 0}, {0, 0, 20}};
    struct brick_mesh mesh = {0};
    struct vr_mesh_hit hit;
    int hits = 0;
    (void)state;
    for (int k = 0; k < 3; k++) {
        double unit[3] = {0};
        unit[k] = 1.0;
        assert_int_equal(brick_mesh_add_vertex(&mesh, corner[k], unit, unit, NULL), 0);
    }
    assert_int_equal(brick_mesh_add_polygon(&mesh, (const uint64_t[]){2, 0, 1}, 3, NULL), 0);
    const struct vr_mesh item = {&mesh, {0}};
    struct vr_mesh_tree *tree = tree_of(&item, 1);
    for (int r = 0; r < 2000; r++) {
        const double from[3] = {-30 + 20 * uniform(), -10, -20 * uniform()};
        const double to[3] = {40 * uniform(), 20 * uniform(), 14 * uniform()};
        struct brick_ray ray = ray_to(from, to);
        double far = 60.0, pace = 0.0, p[3];
        for (int i = 0; i < 3; i++) {
            far -= (i + 1) * ray.origin[i];
            pace += (i + 1) * ray.direction[i];
        }
        bool inside = true;
        for (int i = 0; i < 3; i++) {
            p[i] = ray.origin[i] + far / pace * ray.direction[i];
            inside = inside && p[i] > 0.0;
        }
        assert_int_equal(vr_mesh_tree_first(tree, &ray, &hit), inside);
        if (inside) {
            hits++;
            assert_true(fabs(hit.t_mm - far / pace) < 1e-12);
            for (int k = 0; k < 3; k++) { /* the weight of a corner is its coordinate's share */
                assert_true(fabs(hit.rgb[k] - p[k] / corner[k][k]) < 1e-12);
                assert_true(fabs(hit.normal[k] - p[k] / corner[k][k]) < 1e-12);
            }
        }
        for (int i = 0; i < 3; i++)
            ray.direction[i] = -ray.direction[i];
        assert_false(vr_mesh_tree_first(tree, &ray, &hit));
    }
    assert_true(hits > 500);
    struct brick_ray along = ray_to((const double[]){60, 0, 0}, (const double[]){0, 20, 20.0 / 3});
    assert_false(vr_mesh_tree_first(tree, &along, &hit) && !(hit.t_mm >= 0.0 && hit.t_mm <= 70.0));
    vr_mesh_tree_destroy(&tree);
    brick_mesh_finish(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_of_all),
        cmocka_unit_test(nothing_slips_out),
        cmocka_unit_test(values_on_a_plane),
    };
    return cmocka_run_group_tests_name("mesh_tree", tests, NULL, NULL);
}
