/* The stack of slices. A slice's samples lie on its plane, but where a ray's span begins or ends in the
 * slice: there they lie in the middle of what is left, anywhere between the slice's faces. So boxes near
 * where spans may end are drawn by the outline of the slice, all others by that of its plane alone. Slabs are
 * drawn by the outline of the slice everywhere. */
#include "stack.h"

#include <math.h>
#include <string.h>

#include "scene.h"
#include "vector.h"

#define MAX_SLICES 1073741824.0
/* Boxes grow by this part of a pixel on all sides: rasterisation rounds corners to 1/256 of a pixel. */
#define MARGIN_PIXELS (1.0 / 64.0)
#define MARGIN_VOXELS 1e-6 /* and by this, for the rounding of doubles */
#define SLACK         1e-9 /* for the same, of a step of one voxel */

/* Index steps of level 0 to mm, their length. */
static double length_mm(const struct brick_view *view, const double d[3])
{
    double mm[3];
    for (int i = 0; i < 3; i++)
        mm[i] = vr_dot(view->linear[i], d);
    return sqrt(vr_dot(mm, mm));
}

/* The longest way between corners of level 0's box, and the depth of its centre. */
static void measure(const struct vr_stack *stack, const struct vr_frame *frame, double *diagonal_mm,
                    double *centre_mm)
{
    *diagonal_mm = 0.0;
    *centre_mm = stack->seen[0][3];
    for (int i = 0; i < 4; i++) {
        double across[3];
        for (int a = 0; a < 3; a++)
            across[a] = (double)frame->grid->dims[a] * (i >> a & 1 ? -1.0 : 1.0);
        *diagonal_mm = fmax(*diagonal_mm, length_mm(&frame->view, across));
    }
    for (int a = 0; a < 3; a++)
        *centre_mm += stack->seen[0][a] * 0.5 * (stack->low[a] + stack->high[a]);
}

/* How index space is seen: the inverse of position(depth, x, y). */
static void set_seen(struct vr_stack *stack, const struct vr_frame *frame)
{
    const struct brick_view *v = &frame->view;
    const struct brick_level *level = frame->level;
    double position[3][4], inverse[3][4], rows[3][4];
    for (int a = 0; a < 3; a++) {
        position[a][0] = stack->dir[a] = v->dir[a] / level->scale[a];
        position[a][1] = (stack->perspective ? v->dir_u : v->origin_u)[a] / level->scale[a];
        position[a][2] = (stack->perspective ? v->dir_v : v->origin_v)[a] / level->scale[a];
        position[a][3] = stack->eye[a] = (v->origin[a] - level->offset[a]) / level->scale[a];
    }
    brick_affine_invert(position, stack->seen);
    brick_affine_invert(frame->grid->affine, inverse);
    for (int a = 0; a < 3; a++) {
        for (int i = 0; i < 3; i++)
            rows[a][i] = inverse[a][i] / level->scale[a];
        stack->mm[a] = sqrt(vr_dot(rows[a], rows[a]));
    }
}

/* The longest direction of a depth of 1 that the picture's corners have, and a pixel's edge. */
static void set_pixels(struct vr_stack *stack, const struct vr_frame *frame)
{
    const struct brick_view *v = &frame->view;
    stack->pixel_mm = length_mm(v, stack->perspective ? v->dir_u : v->origin_u);
    stack->reach_mm = 1.0;
    for (int i = 0; stack->perspective && i < 4; i++) {
        double d[3], u = i & 1 ? frame->scene->width : 0.0, w = i & 2 ? frame->scene->height : 0.0;
        for (int a = 0; a < 3; a++)
            d[a] = v->dir[a] + u * v->dir_u[a] + w * v->dir_v[a];
        stack->reach_mm = fmax(stack->reach_mm, length_mm(v, d));
    }
    /* A box that does not hold the eye, enlarged by at least the margin, has a point at a depth of near only
     * beside the picture, or at the eye. */
    double smallest = INFINITY;
    for (int a = 0; a < 3; a++)
        smallest = fmin(smallest, MARGIN_VOXELS / stack->mm[a]);
    stack->near_mm = stack->perspective ? 0.25 * smallest / stack->reach_mm : 0.0;
}

static void set_clip(struct vr_stack *stack, const struct vr_frame *frame)
{
    stack->clip_count = (int)frame->scene->clip_count;
    for (uint32_t i = 0; i < frame->scene->clip_count; i++)
        vr_scene_level_plane(frame->scene, frame->grid, frame->level, i, stack->clip[i]);
}

/* The most cells that a ray passes along an axis, a mm of depth. */
static double cells_a_mm(const struct vr_stack *stack)
{
    return stack->reach_mm * fmax(stack->mm[0], fmax(stack->mm[1], stack->mm[2]));
}

int vr_stack_init(struct vr_stack *stack, const struct vr_frame *frame, uint32_t planes,
                  struct brick_error *err)
{
    const struct brick_level *level = frame->level;
    double diagonal_mm, centre_mm, count = planes;
    *stack = (struct vr_stack){.perspective = !(frame->scene->camera.ortho_height_mm > 0.0),
                               .slabs = frame->prefixes};
    for (int a = 0; a < 3; a++) {
        stack->low[a] = (-0.5 - level->offset[a]) / level->scale[a];
        stack->high[a] = ((double)frame->grid->dims[a] - 0.5 - level->offset[a]) / level->scale[a];
    }
    set_seen(stack, frame);
    set_clip(stack, frame);
    set_pixels(stack, frame);
    measure(stack, frame, &diagonal_mm, &centre_mm);
    const double least = stack->slabs ? ceil(diagonal_mm * cells_a_mm(stack) - SLACK) : 1.0;
    stack->spacing_mm = frame->step_mm;
    if (planes == VR_PLANES_PAPER)
        count = fmax(least, floor(diagonal_mm / brick_grid_min_spacing_mm(frame->grid)));
    if (planes)
        stack->spacing_mm = diagonal_mm / count;
    else
        count = ceil(diagonal_mm / stack->spacing_mm);
    if (!(count <= MAX_SLICES))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%g slices are more than can be counted", count);
    if (planes && count < least)
        return brick_fail(
            err, BRICK_ERR_ARGUMENT,
            "pre-integrated classification takes at least %.0f planes here, not %.0f: a ray may "
            "not pass over a cell between two",
            least, count);
    if (stack->slabs && stack->spacing_mm * cells_a_mm(stack) > 1.0 + SLACK)
        return brick_fail(
            err, BRICK_ERR_ARGUMENT,
            "pre-integrated classification takes steps of up to %.4g voxel edges here, not %g: a "
            "ray may not pass over a cell between two planes",
            frame->quality->step_vox / (stack->spacing_mm * cells_a_mm(stack)), frame->quality->step_vox);
    stack->count = (int)count;
    stack->first_mm = centre_mm - 0.5 * diagonal_mm;
    stack->reach_mm *= stack->spacing_mm;
    return BRICK_OK;
}

/* May a ray's span begin or end within reach of the box? False in *shown when clip planes hide all of it. */
static bool near_an_end(const struct vr_stack *stack, const double low[3], const double high[3], bool *shown)
{
    bool ends = false;
    *shown = true;
    for (int a = 0; a < 3; a++) {
        double reach = stack->reach_mm * stack->mm[a];
        ends = ends || low[a] - reach <= stack->low[a] || high[a] + reach >= stack->high[a];
    }
    for (int i = 0; i < stack->clip_count; i++) {
        const double *n = stack->clip[i];
        double least = n[3], most = n[3], reach = 0.0;
        for (int a = 0; a < 3; a++) {
            least += n[a] * (n[a] > 0.0 ? low : high)[a];
            most += n[a] * (n[a] > 0.0 ? high : low)[a] + MARGIN_VOXELS * fabs(n[a]);
            reach += fabs(n[a]) * stack->reach_mm * stack->mm[a];
        }
        *shown = *shown && most >= 0.0;
        ends = ends || least - reach <= 0.0;
    }
    return ends;
}

void vr_stack_place(const struct vr_stack *stack, const double low[3], const double high[3],
                    struct vr_stack_box *box)
{
    double grown[2][3], farthest = -INFINITY, nearest = INFINITY, margin_mm;
    bool shown;
    for (int i = 0; i < 8; i++) {
        double depth = stack->seen[0][3];
        for (int a = 0; a < 3; a++)
            depth += stack->seen[0][a] * (i >> a & 1 ? high : low)[a];
        farthest = fmax(farthest, depth);
    }
    margin_mm = MARGIN_PIXELS * stack->pixel_mm * (stack->perspective ? fmax(farthest, 0.0) : 1.0);
    box->around_eye = stack->perspective;
    for (int a = 0; a < 3; a++) {
        double margin = margin_mm * stack->mm[a] + MARGIN_VOXELS;
        grown[0][a] = low[a] - margin;
        grown[1][a] = high[a] + margin;
        box->around_eye = box->around_eye && stack->eye[a] >= grown[0][a] && stack->eye[a] <= grown[1][a];
    }
    for (int i = 0; i < 8; i++) {
        double q[3];
        for (int j = 0; j < 3; j++) {
            q[j] = stack->seen[j][3];
            for (int a = 0; a < 3; a++)
                q[j] += stack->seen[j][a] * grown[i >> a & 1][a];
        }
        box->corners[i] = (struct vr_corner){q[0], q[1], q[2]};
        nearest = fmin(nearest, q[0]);
        farthest = fmax(farthest, q[0]);
    }
    box->whole = !near_an_end(stack, low, high, &shown) && !stack->slabs;
    nearest = fmax(nearest, 0.0);
    double first = floor((nearest - stack->first_mm) / stack->spacing_mm);
    double last = floor((farthest - stack->first_mm) / stack->spacing_mm);
    box->first = first > 0.0 ? (int)first : 0;
    box->last = shown && farthest >= 0.0 ? (int)fmin(last, stack->count - 1.0) : -1;
}

int vr_stack_outline(const struct vr_stack *stack, const struct vr_stack_box *box, int k,
                     const struct vr_window *window, double polygon[VR_OUTLINE_MAX][2])
{
    double near = stack->first_mm + k * stack->spacing_mm, far = near + stack->spacing_mm;
    if (box->whole && near > 0.0) {
        near = far = near + 0.5 * stack->spacing_mm;
    } else if (near < stack->near_mm) {
        if (box->around_eye && far > 0.0) {
            const double corner[4][2] = {{window->low[0], window->low[1]},
                                         {window->high[0], window->low[1]},
                                         {window->high[0], window->high[1]},
                                         {window->low[0], window->high[1]}};
            memcpy(polygon, corner, sizeof corner);
            return 4;
        }
        near = stack->near_mm;
    }
    return far < near ? 0 : vr_outline(box->corners, stack->perspective, near, far, window, polygon);
}
