/* Ray set-up. Operations are those of ray.glsl in the same order, so that samples lie where the GPU has them.
 */
#include "ray.h"

#include <math.h>

/* In steps, [0,1): the ordered 4 x 4 pattern (Scharsach 2005, section 5). */
static double offset_of(uint32_t column, uint32_t row)
{
    const uint32_t a = column ^ row, b = row;
    return ((a & 1) << 3 | (b & 1) << 2 | (a & 2) | (b & 2) >> 1) / 16.0;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double least(double a, double b)
{
    return a < b ? a : b;
}

static double most(double a, double b)
{
    return a > b ? a : b;
}

/* Origin, direction a mm in index space, and in the world. */
static void aim(const struct brick_view *v, uint32_t column, uint32_t row, double o[3], double d[3],
                double world[3])
{
    const double x = column + 0.5, y = row + 0.5;
    for (int i = 0; i < 3; i++) {
        o[i] = v->origin[i] + x * v->origin_u[i] + y * v->origin_v[i];
        d[i] = v->dir[i] + x * v->dir_u[i] + y * v->dir_v[i];
    }
    for (int i = 0; i < 3; i++)
        world[i] = dot(v->linear[i], d);
    const double norm = sqrt(dot(world, world));
    for (int i = 0; i < 3; i++) {
        d[i] /= norm;
        world[i] /= norm;
    }
}

bool vr_cast_ray_init(const struct vr_cast_set *set, uint32_t column, uint32_t row, struct vr_cast_ray *ray)
{
    double o[3], d[3], world[3], enter = 0.0, leave = 1.0e300;
    aim(&set->view, column, row, o, d, world);
    for (int i = 0; i < 3; i++) {
        const double high = (double)set->grid->dims[i] - 0.5;
        if (d[i] == 0.0) {
            if (o[i] < -0.5 || o[i] > high)
                return false;
        } else {
            const double a = (-0.5 - o[i]) / d[i], b = (high - o[i]) / d[i];
            enter = most(enter, least(a, b));
            leave = least(leave, most(a, b));
        }
    }
    double from = enter;
    const struct brick_ray whole_ray = {{o[0], o[1], o[2]}, {d[0], d[1], d[2]}};
    if (!(enter < leave) || !vr_clip_span(&set->clip, &whole_ray, &from, &leave))
        return false;
    const double grid = set->interleaved ? enter - offset_of(column, row) * set->step_mm : enter;
    const double begin = (from - grid) / set->step_mm, steps = (leave - grid) / set->step_mm,
                 skipped = floor(begin);
    const double pieces = ceil(steps) - skipped;
    if (!(steps > begin) || !(pieces > 0.0))
        return false;

    /* In steps of the division. */
    const double whole = skipped + pieces - 1.0, rest = steps - most(whole, begin),
                 piece = skipped + 1.0 - begin;
    const double cut = begin + 0.5 * piece, last = steps - 0.5 * rest;
    ray->count = (uint32_t)pieces;
    for (int i = 0; i < 3; i++) {
        const double per_voxel = 1.0 / set->level->scale[i]; /* exact: powers of 2 */
        const double start = (o[i] + grid * d[i] - set->level->offset[i]) * per_voxel;
        const double step = d[i] * set->step_mm * per_voxel;
        ray->step[i] = vr_fixed_from(step);
        ray->first[i] = vr_fixed_after(vr_fixed_from(start + 0.5 * step), ray->step[i], (uint32_t)skipped);
        ray->last[i] = vr_fixed_from(start + last * step);
        ray->begin[i] = set->cut ? vr_fixed_from(start + cut * step) : ray->first[i];
        const float stride = (float)step;
        const bool moves = fabsf(stride) > 1.0e-30f;
        ray->pace[i] = moves ? 1.0f / fabsf(stride) : 0.0f;
        ray->never[i] = moves ? 0.0f : 1.0e30f;
        ray->forward[i] = stride > 0.0f;
        ray->view[i] = (float)world[i];
    }
    ray->length_mm = (float)set->step_mm;
    ray->begin_length_mm = (float)(piece * set->step_mm);
    ray->last_length_mm = (float)(rest * set->step_mm);
    ray->enter_mm = enter;
    return true;
}
