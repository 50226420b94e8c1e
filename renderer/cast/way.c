/* Ways. Invariant: which brick a sample belongs to is found from its own position. */
#include "way.h"

#include <math.h>

/* How many samples, from one at `at` on, lie in the block of 2^shift voxels around `home`: at least 1, and
 * never too many: the way to the exit, in steps, is shortened by more than its rounding error. */
static uint32_t leap(const struct vr_cast_ray *ray, const struct vr_fixed at[3], const int64_t home[3],
                     uint32_t shift)
{
    float way = INFINITY;
    for (int a = 0; a < 3; a++) {
        const int64_t low = home[a] >> shift << shift;
        const float f = (float)(uint32_t)(at[a].fraction >> 32) * 0x1p-24f;
        const float room = ray->forward[a] ? (float)(low + (INT64_C(1) << shift) - at[a].cell) - f
                                           : (float)(at[a].cell - low) + f;
        const float out = (room - 1.0e-6f) * ray->pace[a] + ray->never[a];
        way = out < way ? out : way;
    }
    way = way * 0.99999f + 0.9999f;
    return way >= 16777216.0f ? 16777216u : way > 1.0f ? (uint32_t)way : 1u;
}

bool vr_cast_go_on(const struct vr_cast_frame *frame, const struct vr_cast_ray *ray,
                   struct vr_cast_wait *wait)
{
    const struct brick_level *level = frame->set.level;
    const uint32_t edge_shift = (uint32_t)__builtin_ctz(frame->set.grid->edge),
                   shift = edge_shift < 7 ? edge_shift : 7;
    const int64_t border = frame->set.grid->border;
    while (wait->k < ray->count) {
        struct vr_fixed at[3];
        int64_t home[3];
        for (int a = 0; a < 3; a++) {
            const int64_t last = (int64_t)level->dims[a] - 1;
            at[a] = vr_cast_ray_sample(&frame->set, ray, a, wait->k);
            home[a] = at[a].cell < 0 ? 0 : at[a].cell > last ? last : at[a].cell;
        }
        wait->brick =
            ((uint64_t)(home[2] >> edge_shift) * level->bricks[1] + (uint64_t)(home[1] >> edge_shift)) *
                level->bricks[0] +
            (uint64_t)(home[0] >> edge_shift);
        /* The last sample is not where steps lead, so it has a run of its own. */
        const uint32_t before_last = ray->count - 1 - wait->k, left = before_last ? before_last : 1,
                       run = leap(ray, at, home, shift);
        wait->run = run < left ? run : left;
        if (frame->activity->state[wait->brick] >= BRICK_STATE_ACTIVE) {
            for (int a = 0; a < 3; a++)
                wait->place[a] = (home[a] >> shift << shift) - border;
            return true;
        }
        wait->k += wait->run;
    }
    return false;
}
