/* Ways. Invariant: which brick a sample belongs to is found from its own position. */
#include "way.h"

#include <math.h>

/* How many samples, from one at `at` on, lie in the cube of `edge` voxels from `low` on: at least 1, and
 * never too many: the way to the exit, in steps, is shortened by more than its rounding error. */
static uint32_t leap(const struct vr_cast_ray *ray, const struct vr_fixed at[3], const int64_t low[3],
                     int64_t edge)
{
    float way = INFINITY;
    for (int a = 0; a < 3; a++) {
        const float f = (float)(uint32_t)(at[a].fraction >> 32) * 0x1p-24f;
        const float room =
            ray->forward[a] ? (float)(low[a] + edge - at[a].cell) - f : (float)(at[a].cell - low[a]) + f;
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
        int64_t home[3], low[3];
        for (int a = 0; a < 3; a++) {
            const int64_t last = (int64_t)level->dims[a] - 1;
            at[a] = vr_cast_ray_sample(&frame->set, ray, a, wait->k);
            home[a] = at[a].cell < 0 ? 0 : at[a].cell > last ? last : at[a].cell;
        }
        wait->brick =
            ((uint64_t)(home[2] >> edge_shift) * level->bricks[1] + (uint64_t)(home[1] >> edge_shift)) *
                level->bricks[0] +
            (uint64_t)(home[0] >> edge_shift);
        const uint8_t away = frame->activity->away[wait->brick];
        /* To leave the block, or all inactive bricks around. */
        const int64_t around = away ? (int64_t)(away - 1) << edge_shift : 0;
        const uint32_t block = away ? edge_shift : shift;
        for (int a = 0; a < 3; a++)
            low[a] = (home[a] >> block << block) - around;
        /* The last sample is not where steps lead, so it has a run of its own. */
        const uint32_t before_last = ray->count - 1 - wait->k, left = before_last ? before_last : 1,
                       run = leap(ray, at, low, (INT64_C(1) << block) + 2 * around);
        wait->run = run < left ? run : left;
        if (!away) {
            for (int a = 0; a < 3; a++)
                wait->place[a] = low[a] - border;
            return true;
        }
        wait->k += wait->run;
    }
    return false;
}
