/* What is drawn of a box between two planes against brute force, and boxes of macrocells against the bits
 * they come from. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "boxes.h"
#include "outline.h"

static uint64_t seed = 1;

static double uniform(double low, double high)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(seed >> 11) * 0x1p-53;
}

/* A box of random edges, sheared, and how deep and where its points are seen. */
struct sight {
    bool perspective;
    double origin[3], edge[3][3]; /* in (depth, x, y) */
    struct vr_corner corners[8];
};

static void point_of(const struct sight *s, const double at[3], double q[3])
{
    for (int i = 0; i < 3; i++)
        q[i] = s->origin[i] + at[0] * s->edge[0][i] + at[1] * s->edge[1][i] + at[2] * s->edge[2][i];
}

/* Six times the volume of three edges. */
static double volume_of(const double e[3][3])
{
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
           e[1][0] * (e[0][1] * e[2][2] - e[0][2] * e[2][1]) +
           e[2][0] * (e[0][1] * e[1][2] - e[0][2] * e[1][1]);
}

static void random_sight(struct sight *s)
{
    s->perspective = uniform(0, 1) < 0.5;
    s->origin[0] = uniform(20, 60);
    for (int i = 1; i < 3; i++)
        s->origin[i] = uniform(-40, 40) * (s->perspective ? s->origin[0] : 1.0);
    do
        for (int e = 0; e < 3; e++)
            for (int i = 0; i < 3; i++) /* now and then along the view, or in the planes */
                s->edge[e][i] =
                    uniform(0, 1) < 0.2 ? 0.0 : uniform(-6, 6) * (s->perspective && i ? 40.0 : 1.0);
    while (fabs(volume_of(s->edge)) < 1.0); /* no box is flat */
    for (int c = 0; c < 8; c++) {
        double q[3];
        point_of(s, (const double[3]){c & 1, c >> 1 & 1, c >> 2}, q);
        s->corners[c] = (struct vr_corner){q[0], q[1], q[2]};
    }
}

/* How far the point is inside the polygon; below 0: outside. Either way round. */
static double inside(double (*polygon)[2], int n, double x, double y)
{
    double least = INFINITY, area = 0.0;
    for (int i = 0; i < n; i++) {
        const double *a = polygon[i], *b = polygon[(i + 1) % n];
        area += a[0] * b[1] - a[1] * b[0];
    }
    for (int i = 0; i < n; i++) {
        const double *a = polygon[i], *b = polygon[(i + 1) % n];
        double length = hypot(b[0] - a[0], b[1] - a[1]);
        double cross = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
        if (length > 1e-9)
            least = fmin(least, (area > 0.0 ? cross : -cross) / length);
    }
    return least;
}

/* Points of the box between the planes and in the window are seen in the polygon. */
static void points_are_covered(void **state)
{
    unsigned covered = 0, between = 0;
    (void)state;
    for (int round = 0; round < 4000; round++) {
        struct sight s;
        double polygon[VR_OUTLINE_MAX][2], near, far;
        random_sight(&s);
        near = s.origin[0] + uniform(-12, 12);
        far = uniform(0, 1) < 0.3 ? near : near + uniform(0, 4);
        const struct vr_window window = {{uniform(-60, 0), uniform(-60, 0)},
                                         {uniform(0, 60), uniform(0, 60)}};
        int n = vr_outline(s.corners, s.perspective, near, far, &window, polygon);
        assert_true(n == 0 || (n >= 3 && n <= VR_OUTLINE_MAX));
        for (int i = 0; i < 100; i++) {
            double at[3] = {uniform(0, 1), uniform(0, 1), uniform(0, 1)}, q[3], x, y;
            point_of(&s, at, q);
            if (near == far && s.edge[0][0] != 0.0) { /* move it onto the plane */
                at[0] += (near - q[0]) / s.edge[0][0];
                point_of(&s, at, q);
                if (at[0] < 0.0 || at[0] > 1.0)
                    continue;
            } else if (q[0] < near || q[0] > far) {
                continue;
            }
            x = s.perspective ? q[1] / q[0] : q[1];
            y = s.perspective ? q[2] / q[0] : q[2];
            if (x < window.low[0] || x > window.high[0] || y < window.low[1] || y > window.high[1])
                continue;
            between++;
            covered += n >= 3 && inside(polygon, n, x, y) >= -1e-6;
        }
    }
    print_message("%u points\n", between);
    assert_true(between > 5000);
    assert_int_equal(covered, between);
}

/* Where the ray through a point of the picture is inside the box, as depths; false: nowhere. */
static bool span_of(const struct sight *s, double x, double y, double *enter, double *leave)
{
    /* depth * d + o in box coordinates, by Cramer's rule on the edges */
    const double(*e)[3] = s->edge;
    const double det = volume_of(e);
    *enter = -INFINITY, *leave = INFINITY;
    for (int a = 0; a < 3; a++) {
        const double *p = e[(a + 1) % 3], *r = e[(a + 2) % 3];
        const double normal[3] = {(p[1] * r[2] - p[2] * r[1]) / det, (p[2] * r[0] - p[0] * r[2]) / det,
                                  (p[0] * r[1] - p[1] * r[0]) / det};
        double slope = normal[0], start = -normal[0] * s->origin[0];
        for (int i = 1; i < 3; i++) {
            double at = i == 1 ? x : y;
            slope += s->perspective ? normal[i] * at : 0.0;
            start += normal[i] * ((s->perspective ? 0.0 : at) - s->origin[i]);
        }
        if (slope == 0.0) {
            if (start < 0.0 || start > 1.0)
                return false;
            continue;
        }
        double u = -start / slope, v = (1.0 - start) / slope;
        *enter = fmax(*enter, fmin(u, v));
        *leave = fmin(*leave, fmax(u, v));
    }
    return *enter < *leave;
}

/* And a ray through the polygon's inside meets the box between the planes. */
static void nothing_else_is_covered(void **state)
{
    unsigned met = 0;
    (void)state;
    for (int round = 0; round < 4000; round++) {
        struct sight s;
        double polygon[VR_OUTLINE_MAX][2];
        random_sight(&s);
        double near = s.origin[0] + uniform(-12, 12), far = near + (round % 3 ? uniform(0, 4) : 0.0);
        const struct vr_window window = {{-1e5, -1e5}, {1e5, 1e5}};
        int n = vr_outline(s.corners, s.perspective, near, far, &window, polygon);
        if (n < 3)
            continue;
        for (int i = 0; i < 20; i++) {
            double x = 0.0, y = 0.0, sum = 0.0, enter, leave;
            for (int v = 0; v < n; v++) {
                double w = uniform(0, 1);
                x += w * polygon[v][0], y += w * polygon[v][1], sum += w;
            }
            x /= sum, y /= sum;
            if (inside(polygon, n, x, y) < 1e-3 || !span_of(&s, x, y, &enter, &leave))
                continue;
            met++;
            assert_true(enter <= far + 1e-6 && leave >= near - 1e-6);
        }
    }
    assert_true(met > 5000);
}

static void boxes_hold_what_is_active(void **state)
{
    (void)state;
    for (int round = 0; round < 500; round++) {
        const int cells[3] = {1 + (int)uniform(0, 8), 1 + (int)uniform(0, 8), 1 + (int)uniform(0, 8)};
        const int count = cells[0] * cells[1] * cells[2];
        const double share = uniform(0, 1);
        uint32_t bits[16] = {0};
        int in[512] = {0}, active = 0, drawn = 0;
        struct vr_cell_box boxes[512];
        for (int c = 0; c < count; c++)
            if (uniform(0, 1) < share * share)
                bits[c / 32] |= UINT32_C(1) << c % 32, active++;
        size_t n = vr_boxes_of(bits, cells, boxes);
        assert_true(n <= (size_t)active);
        for (size_t b = 0; b < n; b++)
            for (int z = boxes[b].low[2]; z < boxes[b].high[2]; z++)
                for (int y = boxes[b].low[1]; y < boxes[b].high[1]; y++)
                    for (int x = boxes[b].low[0]; x < boxes[b].high[0]; x++)
                        in[(z * cells[1] + y) * cells[0] + x]++, drawn++;
        for (int c = 0; c < count; c++)
            assert_true(in[c] <= 1 && in[c] >= (int)(bits[c / 32] >> c % 32 & 1));
        assert_true(drawn <= 2 * active);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_covered),
        cmocka_unit_test(nothing_else_is_covered),
        cmocka_unit_test(boxes_hold_what_is_active),
    };
    return cmocka_run_group_tests_name("slices_outline", tests, NULL, NULL);
}
