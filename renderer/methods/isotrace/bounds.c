/* Boxes before a camera. Invariants: a box is seen as the box around it along the camera's axes, widened by
 * more than double and float round, so that no ray meets a surface outside of its reach, nor starts or ends
 * in a cell that has one: bounds change no bit. What a brick costs here is bounded by its size in the
 * picture: parts that are small there are taken together. */
#include "bounds.h"

#include <stdlib.h>

#include <brick/checked.h>

#include "vector.h"

/* No box needs to be smaller in the picture than this. */
#define PIXELS_MIN 3.0

/* A step of the picture, or a direction, in mm. */
static void to_mm(const struct brick_view *view, const double v[3], double mm[3])
{
    for (int i = 0; i < 3; i++)
        mm[i] = vr_dot(view->linear[i], v);
}

static void set_camera(struct vr_iso_bounds *b, const struct brick_view *view)
{
    const struct brick_level *level = b->frame->level;
    double axis[3][3], length[3], centre[3];
    to_mm(view, view->origin_u, axis[0]);
    b->parallel = vr_dot(axis[0], axis[0]) > 0.0;
    if (!b->parallel)
        to_mm(view, view->dir_u, axis[0]);
    to_mm(view, b->parallel ? view->origin_v : view->dir_v, axis[1]);
    for (int i = 0; i < 3; i++)
        axis[2][i] =
            axis[0][(i + 1) % 3] * axis[1][(i + 2) % 3] - axis[0][(i + 2) % 3] * axis[1][(i + 1) % 3];
    to_mm(view, view->dir, centre);
    for (int k = 0; k < 3; k++) {
        length[k] = sqrt(vr_dot(axis[k], axis[k]));
        if (k == 2 && vr_dot(axis[2], centre) < 0.0)
            length[k] = -length[k];
        for (int i = 0; i < 3; i++)
            axis[k][i] /= length[k];
    }
    for (int k = 0; k < 3; k++) {
        b->to_eye[k][3] = 0.0;
        for (int i = 0; i < 3; i++) {
            double mm = 0.0; /* a voxel of level 0 on this axis */
            for (int j = 0; j < 3; j++)
                mm += axis[k][j] * view->linear[j][i];
            b->to_eye[k][i] = mm * level->scale[i];
            b->to_eye[k][3] += mm * (level->offset[i] - view->origin[i]);
        }
    }
    for (int k = 0; k < 2;
         k++) { /* perspective: ray = dir + u dir_u + v dir_v, whose ratio to forward it is */
        b->scale[k] = (b->parallel ? 1.0 : vr_dot(axis[2], centre)) / length[k];
        b->shift[k] = b->parallel ? 0.0 : -vr_dot(axis[k], centre) / length[k];
    }
}

int vr_iso_bounds_begin(struct vr_iso_bounds *b, const struct vr_iso_frame *frame,
                        const struct brick_view *view, uint32_t width, uint32_t height, unsigned threads,
                        struct brick_error *err)
{
    const size_t blocks =
        (size_t)((width + VR_ISO_BLOCK - 1) / VR_ISO_BLOCK) * ((height + VR_ISO_BLOCK - 1) / VR_ISO_BLOCK);
    if (blocks > b->room || threads != b->threads) {
        vr_iso_bounds_finish(b);
        b->reach = calloc(threads, sizeof *b->reach);
        b->used = calloc(threads, sizeof *b->used);
        if (!b->reach || !b->used) {
            vr_iso_bounds_finish(b);
            return brick_fail(err, BRICK_ERR_MEMORY, "isotrace: no memory for %u threads", threads);
        }
        b->threads = threads;
        b->room = blocks;
    }
    b->frame = frame;
    b->blocks[0] = (int32_t)((width + VR_ISO_BLOCK - 1) / VR_ISO_BLOCK);
    b->blocks[1] = (int32_t)((height + VR_ISO_BLOCK - 1) / VR_ISO_BLOCK);
    for (unsigned i = 0; i < threads; i++)
        b->used[i] = false;
    set_camera(b, view);
    return BRICK_OK;
}

void vr_iso_bounds_finish(struct vr_iso_bounds *b)
{
    for (unsigned i = 0; i < b->threads; i++)
        free(b->reach[i]);
    free(b->reach);
    free(b->used);
    *b = (struct vr_iso_bounds){0};
}

/* A box in mm, right, up, forward: its middle and half its sides; and what it covers in pixels. */
struct seen {
    double middle[3], half[3], from[2], to[2];
};

/* False when it is behind the eye. */
static bool see(const struct vr_iso_bounds *b, const double lo[3], const double hi[3], struct seen *s)
{
    for (int k = 0; k < 3; k++) {
        const double *m = b->to_eye[k];
        s->middle[k] = m[3];
        s->half[k] = 0.0;
        for (int i = 0; i < 3; i++) {
            s->middle[k] += m[i] * 0.5 * (lo[i] + hi[i]);
            s->half[k] += fabs(m[i]) * 0.5 * (hi[i] - lo[i]);
        }
    }
    double margin = 1e-6 * (fabs(s->middle[0]) + fabs(s->middle[1]) + fabs(s->middle[2]));
    for (int k = 0; k < 3; k++)
        s->half[k] += 1e-5 * s->half[k] + margin;
    double near = s->middle[2] - s->half[2], far = s->middle[2] + s->half[2];
    if (far < 0.0)
        return false;
    for (int k = 0; k < 2; k++) {
        double from = s->middle[k] - s->half[k], to = s->middle[k] + s->half[k];
        if (!b->parallel && near > 0.0) {
            from /= from < 0.0 ? near : far;
            to /= to < 0.0 ? far : near;
        }
        if (b->parallel || near > 0.0) {
            s->from[k] = b->shift[k] + b->scale[k] * from;
            s->to[k] = b->shift[k] + b->scale[k] * to;
        } else { /* the eye is beside it or inside */
            s->from[k] = -INFINITY;
            s->to[k] = INFINITY;
        }
    }
    return true;
}

static struct vr_iso_reach reach_of(const struct vr_iso_bounds *b, const struct seen *s)
{
    double near = s->middle[2] - s->half[2], far = s->middle[2] + s->half[2];
    if (!b->parallel) {
        double near2 = near > 0.0 ? near * near : 0.0, far2 = far * far;
        for (int k = 0; k < 2; k++) {
            double to = fabs(s->middle[k]) + s->half[k], from = fabs(s->middle[k]) - s->half[k];
            near2 += from > 0.0 ? from * from : 0.0;
            far2 += to * to;
        }
        near = sqrt(near2);
        far = sqrt(far2);
    }
    return (struct vr_iso_reach){(float)near, (float)far};
}

/* The blocks of pixels whose centres are between two places; false when there are none. */
static bool blocks_of(double from, double to, int32_t blocks, int32_t *first, int32_t *last)
{
    double f = floor((from - 0.5) / VR_ISO_BLOCK), l = floor((to - 0.5) / VR_ISO_BLOCK);
    if (!(l >= 0.0) || !(f < blocks))
        return false;
    *first = f < 0.0 ? 0 : (int32_t)f;
    *last = l < blocks ? (int32_t)l : blocks - 1;
    return true;
}

static void cover(const struct vr_iso_bounds *b, const struct seen *s, struct vr_iso_reach *picture)
{
    int32_t x0, x1, y0, y1;
    if (!blocks_of(s->from[0], s->to[0], b->blocks[0], &x0, &x1) ||
        !blocks_of(s->from[1], s->to[1], b->blocks[1], &y0, &y1))
        return;
    const struct vr_iso_reach r = reach_of(b, s);
    for (int32_t y = y0; y <= y1; y++) {
        struct vr_iso_reach *row = picture + (size_t)y * (size_t)b->blocks[0];
        for (int32_t x = x0; x <= x1; x++) {
            row[x].near = r.near < row[x].near ? r.near : row[x].near;
            row[x].far = r.far > row[x].far ? r.far : row[x].far;
        }
    }
}

/* Cells [lo, lo + size) of a level; at the volume's edges half a cell more. */
static void box_of(const uint64_t at[3], uint32_t size, double lo[3], double hi[3])
{
    for (int i = 0; i < 3; i++) {
        lo[i] = (double)(at[i] * size) - (at[i] ? 0.0 : 0.5);
        hi[i] = (double)((at[i] + 1) * size);
    }
}

/* Is any of a brick's n x n x n parts from p on active? A row of them lies in one word. */
static bool any_active(const atomic_uint_least64_t *bits, const uint32_t p[3], uint32_t n, uint32_t across)
{
    const uint64_t row = n < 64 ? (UINT64_C(1) << n) - 1 : UINT64_MAX;
    for (uint32_t z = p[2]; z < p[2] + n; z++)
        for (uint32_t y = p[1]; y < p[1] + n; y++) {
            const uint32_t i = (z * across + y) * across + p[0];
            if (atomic_load_explicit(&bits[i / 64], memory_order_relaxed) >> i % 64 & row)
                return true;
        }
    return false;
}

static void add_brick(const struct vr_iso_bounds *b, const uint64_t at[3], uint64_t index,
                      struct vr_iso_reach *picture)
{
    const struct vr_iso_map *map = b->frame->map;
    const uint32_t edge = b->frame->grid->edge, across = edge / VR_ISO_PART;
    double lo[3], hi[3];
    struct seen s;
    box_of(at, edge, lo, hi);
    if (!see(b, lo, hi, &s))
        return;
    if (vr_iso_map_state(map, index) != VR_ISO_KNOWN) {
        cover(b, &s, picture);
        return;
    }
    uint32_t n = 1, p[3];
    while (n < across && (s.to[0] - s.from[0]) * n < PIXELS_MIN * across)
        n *= 2;
    for (p[2] = 0; p[2] < across; p[2] += n)
        for (p[1] = 0; p[1] < across; p[1] += n)
            for (p[0] = 0; p[0] < across; p[0] += n)
                if (any_active(vr_iso_map_bits(map, index), p, n, across)) {
                    const uint64_t part[3] = {(at[0] * across + p[0]) / n, (at[1] * across + p[1]) / n,
                                              (at[2] * across + p[2]) / n};
                    box_of(part, n * VR_ISO_PART, lo, hi);
                    if (see(b, lo, hi, &s))
                        cover(b, &s, picture);
                }
}

int vr_iso_bounds_add(struct vr_iso_bounds *b, unsigned thread, uint64_t first, uint64_t end,
                      struct brick_error *err)
{
    const uint64_t *bricks = b->frame->level->bricks;
    if (!b->used[thread]) {
        if (!b->reach[thread])
            b->reach[thread] = malloc(b->room * sizeof **b->reach);
        if (!b->reach[thread])
            return brick_fail(err, BRICK_ERR_MEMORY, "isotrace: no memory for the bounds of rays");
        for (size_t i = 0; i < (size_t)b->blocks[0] * (size_t)b->blocks[1]; i++)
            b->reach[thread][i] = (struct vr_iso_reach){INFINITY, -INFINITY};
        b->used[thread] = true;
    }
    for (uint64_t i = first; i < end; i++)
        if (vr_iso_map_state(b->frame->map, i) != VR_ISO_EMPTY) {
            const uint64_t at[3] = {i % bricks[0], i / bricks[0] % bricks[1], i / bricks[0] / bricks[1]};
            add_brick(b, at, i, b->reach[thread]);
        }
    return BRICK_OK;
}
