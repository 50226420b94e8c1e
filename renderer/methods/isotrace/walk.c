/* From brick to brick along a ray (Amanatides and Woo's stepping, as in section 2.2), and the ray's set-up.
 *
 * Invariants: the cells that a ray visits, and the t at which it passes from one to the next, follow from the
 * ray alone: t of a plane is computed from the plane's integer, crossings are ordered by t and then by axis,
 * and every level of the hierarchy takes its subset of that one sequence. So neither the size of bricks and
 * parts nor skipping changes a bit of the picture, and cells are passed without gap or overlap. */
#include "walk.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "map.h"
#include "pins.h"

static void set_up(struct vr_iso_ray *r, const struct brick_level *level, const struct brick_ray *ray,
                   double enter_mm, double leave_mm)
{
    for (int i = 0; i < 3; i++) {
        const double per_voxel = 1.0 / level->scale[i]; /* exact: powers of 2 */
        r->origin[i] = (ray->origin[i] - level->offset[i]) * per_voxel;
        r->direction[i] = ray->direction[i] * per_voxel;
        r->pace[i] = 1.0 / r->direction[i];
        /* So slow that no plane is met within any distance that a double resolves: it runs along. */
        r->moves[i] = isfinite(r->pace[i]);
        r->up[i] = r->direction[i] > 0.0;
        r->from[i] = r->moves[i] ? r->origin[i] : -0x1p60;
        if (!r->moves[i]) {
            r->pace[i] = INFINITY;
            r->up[i] = true;
        }
    }
    r->enter = enter_mm;
    r->leave = leave_mm;
}

/* The brick's planes on an axis that the ray leaves by; at the volume's edge none. */
static double leaves(const struct vr_iso_frame *frame, const struct vr_iso_ray *r, int axis, int64_t brick)
{
    int64_t next = r->up[axis] ? brick + 1 : brick;
    if (next == 0 || next == (int64_t)frame->level->bricks[axis])
        return INFINITY;
    return vr_iso_meets(r, axis, next * (int64_t)frame->grid->edge);
}

/* To the next brick on the way, or the ray's end. */
static void next_brick(struct vr_iso_walk *w)
{
    const struct vr_iso_frame *frame = w->frame;
    const struct vr_iso_ray *r = &w->ray;
    int axis = vr_iso_first(w->next);
    w->axis = axis;
    w->t = w->next[axis];
    if (!(w->t < r->leave)) {
        w->done = true;
        return;
    }
    int64_t stride = axis == 0 ? 1 : (int64_t)frame->level->bricks[0];
    if (axis == 2)
        stride *= (int64_t)frame->level->bricks[1];
    w->at[axis] += r->up[axis] ? 1 : -1;
    w->index += r->up[axis] ? stride : -stride;
    w->next[axis] = leaves(frame, r, axis, w->at[axis]);
}

static void to_active_brick(struct vr_iso_walk *w)
{
    while (!w->done && !vr_iso_map_state(w->frame->map, (uint64_t)w->index))
        next_brick(w);
}

void vr_iso_start(struct vr_iso_walk *w, const struct brick_ray *ray, double enter_mm, double leave_mm)
{
    const struct vr_iso_frame *frame = w->frame;
    const struct brick_level *level = frame->level;
    w->hit_count = 0;
    w->transmittance = 1.0;
    w->done = false;
    w->t = enter_mm;
    w->axis = -1;
    w->index = 0;
    set_up(&w->ray, level, ray, enter_mm, leave_mm);
    if (frame->flat)
        return;
    for (int i = 2; i >= 0; i--) {
        int64_t cell = vr_iso_cell_on(&w->ray, i, w->t, -1);
        w->at[i] = cell < 0 ? 0 : cell >> frame->map->edge_shift;
        if (w->at[i] >= (int64_t)level->bricks[i])
            w->at[i] = (int64_t)level->bricks[i] - 1;
        w->next[i] = leaves(frame, &w->ray, i, w->at[i]);
        w->index = w->index * (int64_t)level->bricks[i] + w->at[i];
    }
    to_active_brick(w);
}

static int go_through(struct vr_iso_walk *w, const struct vr_iso_block *block,
                      const atomic_uint_least64_t *bits, struct brick_error *err)
{
    int code = w->frame->kernel->through(w, block, bits, w->t, w->axis, err);
    if (code < 0)
        return code;
    w->done = code > 0 || w->frame->flat;
    if (!w->done) {
        next_brick(w);
        to_active_brick(w);
    }
    return BRICK_OK;
}

/* A level as one block is one part. */
static const atomic_uint_least64_t flat_bits = 1;

int vr_iso_trace(struct vr_iso_walk *walks, size_t n, struct vr_iso_pin *pin, struct brick_error *err)
{
    struct vr_iso_walk *walk[VR_ISO_RAYS]; /* under way */
    double t[VR_ISO_RAYS];
    size_t waiting = 0;
    for (size_t i = 0; i < n; i++)
        if (!walks[i].done) {
            t[waiting] = walks[i].t;
            walk[waiting++] = &walks[i];
        }
    while (waiting) {
        size_t nearest = 0, left = 0;
        for (size_t i = 1; i < waiting; i++)
            nearest = t[i] < t[nearest] ? i : nearest;
        const struct vr_iso_frame *frame = walk[nearest]->frame;
        const struct vr_iso_block *block = frame->flat;
        const atomic_uint_least64_t *bits = &flat_bits;
        const int64_t index = walk[nearest]->index;
        if (!block) {
            int code = vr_iso_pin_get(pin, frame->level->first_brick + (uint64_t)index, &block, err);
            if (code)
                return code;
            bits = vr_iso_map_look(frame->map, frame, (uint64_t)index, block);
        }
        for (size_t i = 0; i < waiting; i++) {
            struct vr_iso_walk *w = walk[i];
            if (w->index == index) {
                int code = go_through(w, block, bits, err);
                if (code)
                    return code;
            }
            if (!w->done) {
                t[left] = w->t;
                walk[left++] = w;
            }
        }
        waiting = left;
    }
    return BRICK_OK;
}

void vr_iso_walk_finish(struct vr_iso_walk *walk)
{
    free(walk->hits);
    walk->hits = NULL;
}
