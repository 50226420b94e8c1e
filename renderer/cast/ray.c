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

bool vr_cast_ray_init(const struct vr_cast_set *set, uint32_t column, uint32_t row, double end_mm,
                      struct vr_cast_ray *ray)
{
    struct brick_ray whole;
    double enter, leave;
    brick_view_ray(&set->view, column, row, &whole);
    if (!brick_ray_span(&whole, set->grid, &enter, &leave))
        return false;
    leave = end_mm < leave ? end_mm : leave;
    double from = enter;
    if (!vr_clip_span(&set->clip, &whole, &from, &leave))
        return false;
    const double grid = set->interleaved ? enter - offset_of(column, row) * set->step_mm : enter;
    const double begin = (from - grid) / set->step_mm, steps = (leave - grid) / set->step_mm,
                 skipped = floor(begin);
    const double pieces = ceil(steps) - skipped;
    if (!(steps > begin) || !(pieces > 0.0))
        return false;

    /* In steps of the division. */
    const double last_whole = skipped + pieces - 1.0;
    const double rest = steps - (last_whole > begin ? last_whole : begin), piece = skipped + 1.0 - begin;
    ray->cut = begin + 0.5 * piece;
    ray->last = steps - 0.5 * rest;
    ray->count = (uint32_t)pieces;
    for (int i = 0; i < 3; i++) {
        const double start =
            (whole.origin[i] + grid * whole.direction[i] - set->level->offset[i]) * set->per_voxel[i];
        const double step = whole.direction[i] * set->step_mm * set->per_voxel[i];
        ray->start[i] = start;
        ray->stride[i] = step;
        ray->step[i] = vr_fixed_from(step);
        ray->first[i] = vr_fixed_after(vr_fixed_from(start + 0.5 * step), ray->step[i], (uint32_t)skipped);
        const float stride = (float)step;
        const bool moves = fabsf(stride) > 1.0e-30f;
        ray->pace[i] = moves ? 1.0f / fabsf(stride) : 0.0f;
        ray->never[i] = moves ? 0.0f : 1.0e30f;
        ray->forward[i] = stride > 0.0f;
        const double *linear = set->view.linear[i], *d = whole.direction;
        ray->view[i] = (float)(linear[0] * d[0] + linear[1] * d[1] + linear[2] * d[2]);
    }
    ray->length_mm = (float)set->step_mm;
    ray->begin_length_mm = (float)(piece * set->step_mm);
    ray->last_length_mm = (float)(rest * set->step_mm);
    ray->enter_mm = enter;
    return true;
}
