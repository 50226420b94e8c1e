/* The convex hull of what the two planes leave of the box: its corners between them, and where its edges pass
 * through them. In perspective a part of a box before the eye stays convex in the picture. */
#include "outline.h"

#include <string.h>

/* From left to right, then upwards; by insertion, as there are few. */
static void sort(double (*point)[2], int n)
{
    for (int i = 1; i < n; i++) {
        const double x = point[i][0], y = point[i][1];
        int j = i;
        for (; j > 0 && (point[j - 1][0] > x || (point[j - 1][0] == x && point[j - 1][1] > y)); j--)
            memcpy(point[j], point[j - 1], sizeof *point);
        point[j][0] = x;
        point[j][1] = y;
    }
}

/* Does a, b, c turn to the left? */
static bool turns_left(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
}

/* Andrew's monotone chain: the lower side from left to right, then the upper one back. */
static int hull(double (*point)[2], int n, double (*out)[2])
{
    int count = 0;
    sort(point, n);
    for (int i = 0; i < n; i++) {
        while (count >= 2 && !turns_left(out[count - 2], out[count - 1], point[i]))
            count--;
        memcpy(out[count++], point[i], sizeof *point);
    }
    for (int i = n - 2, lower = count + 1; i >= 0; i--) {
        while (count >= lower && !turns_left(out[count - 2], out[count - 1], point[i]))
            count--;
        memcpy(out[count++], point[i], sizeof *point);
    }
    return count - 1; /* the first point is there twice */
}

/* Keep what has sign * coordinate[axis] <= sign * limit (Sutherland and Hodgman). */
static int cut(double (*in)[2], int n, int axis, double sign, double limit, double (*out)[2])
{
    int count = 0;
    for (int i = 0; i < n; i++) {
        const double *a = in[i], *b = in[(i + 1) % n];
        double inside_a = sign * (limit - a[axis]), inside_b = sign * (limit - b[axis]);
        if (inside_a >= 0.0)
            memcpy(out[count++], a, sizeof *out);
        if ((inside_a < 0.0) != (inside_b < 0.0)) {
            double s = inside_a / (inside_a - inside_b);
            out[count][axis] = limit;
            out[count][1 - axis] = a[1 - axis] + s * (b[1 - axis] - a[1 - axis]);
            count++;
        }
    }
    return count;
}

static void add(double (*point)[2], int *n, bool perspective, double depth, double x, double y)
{
    point[*n][0] = perspective ? x / depth : x;
    point[*n][1] = perspective ? y / depth : y;
    (*n)++;
}

static void add_crossing(double (*point)[2], int *n, bool perspective, const struct vr_corner *a,
                         const struct vr_corner *b, double depth)
{
    if ((a->depth < depth) == (b->depth < depth))
        return;
    double s = (depth - a->depth) / (b->depth - a->depth);
    add(point, n, perspective, depth, a->x + s * (b->x - a->x), a->y + s * (b->y - a->y));
}

int vr_outline(const struct vr_corner c[8], bool perspective, double near, double far,
               const struct vr_window *window, double polygon[VR_OUTLINE_MAX][2])
{
    double point[VR_OUTLINE_MAX][2], other[2 * VR_OUTLINE_MAX][2];
    int n = 0;
    for (int i = 0; i < 8; i++)
        if (c[i].depth >= near && c[i].depth <= far)
            add(point, &n, perspective, c[i].depth, c[i].x, c[i].y);
    for (int i = 0; i < 8; i++)
        for (int axis = 1; axis < 8; axis *= 2) {
            if (i & axis)
                continue;
            add_crossing(point, &n, perspective, &c[i], &c[i | axis], near);
            if (far > near)
                add_crossing(point, &n, perspective, &c[i], &c[i | axis], far);
        }
    if (n < 3)
        return 0;
    n = hull(point, n, other);
    n = cut(other, n, 0, 1.0, window->high[0], polygon);
    n = cut(polygon, n, 0, -1.0, window->low[0], other);
    n = cut(other, n, 1, 1.0, window->high[1], polygon);
    n = cut(polygon, n, 1, -1.0, window->low[1], other);
    memcpy(polygon, other, (size_t)n * sizeof *polygon);
    return n < 3 ? 0 : n;
}
