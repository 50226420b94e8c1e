/* Where macrocells are inactive, samples of all rays in active ones are queued, looked at, and those that can
 * be visible taken: vectors are full however few of a ray's samples get there. Where none is, rays go side by
 * side, a lane each. Both in rounds of so many samples of each ray, so that one that has ended costs no more
 * than its round. Invariant: a ray's samples are taken in their order, by the same operations. */
#include "through.h"

#include <string.h>

/* The ray's next samples: those that are where steps lead together, others alone. */
static inline struct vr_cast_run next_run(const struct vr_cast_rays *rays, const struct vr_cast_set *set,
                                          const int64_t lo[3], uint32_t r)
{
    const struct vr_cast_ray *ray = &rays->ray[r];
    const struct vr_cast_wait *wait = &rays->wait[r];
    const uint32_t before_last = ray->count - 1 - wait->k;
    const bool alone = vr_cast_ray_is_end(set, ray, wait->k);
    struct vr_cast_run run;
    run.ray = r;
    run.count = alone ? 1 : wait->run < before_last ? wait->run : before_last;
    run.length_mm = vr_cast_ray_length(set, ray, wait->k);
    for (int a = 0; a < 3; a++) {
        run.step[a] = vr_fixed_near(ray->step[a], 0);
        run.at[a] = alone ? vr_fixed_near(vr_cast_ray_end(ray, a, wait->k), wait->place[a])
                          : vr_fixed_near(ray->first[a], wait->place[a]) + wait->k * run.step[a];
        run.offset[a] = (int32_t)(wait->place[a] - lo[a]);
    }
    return run;
}

static void took(struct vr_cast_wait *wait, uint32_t count)
{
    wait->k += count;
    wait->run -= count;
}

/* Depth, opacity and colour of what has been seen. */
static void colour(const struct vr_cast_rays *rays, struct vr_cast_seen *seen,
                   const struct vr_cast_frame *frame, const struct vr_cast_brick *brick)
{
    frame->kernels->classify(seen, &frame->pieces);
    if (frame->scene->mode != BRICK_MODE_SHADED)
        return;
    struct vr_cast_light light = frame->light;
    for (int a = 0; a < 3; a++)
        light.view[a] = rays->view[a];
    frame->kernels->typed[frame->set.grid->type].shade(seen, brick, &light, frame->field.nonfinite);
}

/* Of the samples seen each ray's largest. */
static void take_largest(struct vr_cast_rays *rays, const struct vr_cast_seen *seen)
{
    for (uint32_t i = 0; i < seen->count; i++) {
        struct vr_cast_state *s = &rays->state[seen->ray[i]];
        if (s->depth == 0.0f || seen->value[i] > s->rgb[0])
            s->rgb[0] = seen->value[i];
        s->depth = 1.0f;
    }
}

/* Optical depth before each sample seen, in the order of the rays' samples; those after a ray's end count
 * nothing. Depth rather than transmittance is summed, which loses nothing however thin. */
static void sum_depth(struct vr_cast_rays *rays, struct vr_cast_samples *samples, float depth_end)
{
    struct vr_cast_seen *seen = &samples->seen;
    for (uint32_t i = 0; i < seen->count;) {
        const uint32_t ray = seen->ray[i];
        struct vr_cast_state *s = &rays->state[ray];
        float depth = s->depth;
        bool done = s->done;
        for (; i < seen->count && seen->ray[i] == ray; i++) {
            samples->before[i] = depth;
            if (done)
                seen->alpha[i] = 0.0f;
            else
                depth += seen->depth[i];
            done = done || depth > depth_end;
        }
        s->depth = depth;
        s->done = done;
    }
}

static void sum_colour(struct vr_cast_rays *rays, const struct vr_cast_seen *seen)
{
    for (uint32_t i = 0; i < seen->count;) {
        const uint32_t ray = seen->ray[i];
        float *rgb = rays->state[ray].rgb, r = rgb[0], g = rgb[1], b = rgb[2];
        for (; i < seen->count && seen->ray[i] == ray; i++) {
            r += seen->alpha[i] * seen->rgb[0][i];
            g += seen->alpha[i] * seen->rgb[1][i];
            b += seen->alpha[i] * seen->rgb[2][i];
        }
        rgb[0] = r, rgb[1] = g, rgb[2] = b;
    }
}

static void look(struct vr_cast_rays *rays, struct vr_cast_samples *samples,
                 const struct vr_cast_frame *frame, const struct vr_cast_brick *brick, uint64_t *looked)
{
    const enum brick_mode mode = frame->scene->mode;
    struct vr_cast_seen *seen = &samples->seen;
    if (!samples->queue.count)
        return;
    frame->kernels->typed[frame->set.grid->type].look(seen, &samples->queue, brick, &frame->field,
                                                      mode == BRICK_MODE_SHADED);
    *looked += samples->queue.count;
    samples->queue.count = 0;
    if (mode == BRICK_MODE_MIP) {
        take_largest(rays, seen);
    } else if (seen->count) {
        colour(rays, seen, frame, brick);
        sum_depth(rays, samples, frame->depth_end);
        frame->kernels->dim(seen, samples->before);
        sum_colour(rays, seen);
    }
}

static void in_queues(struct vr_cast_rays *rays, struct vr_cast_samples *samples,
                      const struct vr_cast_frame *frame, const struct vr_cast_brick *brick,
                      const int64_t lo[3], const uint32_t *waiting, uint32_t n, uint64_t *looked)
{
    bool on = true;
    while (on) {
        on = false;
        for (uint32_t i = 0; i < n; i++) {
            const uint32_t r = waiting[i];
            struct vr_cast_wait *wait = &rays->wait[r];
            if (rays->state[r].done || !wait->run)
                continue;
            struct vr_cast_run run = next_run(rays, &frame->set, lo, r);
            const uint32_t count = run.count;
            frame->kernels->scan(&samples->queue, brick, &run);
            took(wait, count - run.count);
            on = on || wait->run;
            if (samples->queue.count >= VR_CAST_QUEUE)
                look(rays, samples, frame, brick, looked);
        }
        look(rays, samples, frame, brick, looked);
    }
}

static void into_packet(struct vr_cast_packet *p, const struct vr_cast_run *run,
                        const struct vr_cast_state *state, const struct vr_cast_brick *brick)
{
    const uint32_t i = p->on.count++;
    p->left[i] = run->count;
    p->length_mm[i] = run->length_mm;
    p->voxel[i] = run->offset[2] * brick->slice + run->offset[1] * brick->row + run->offset[0];
    for (int a = 0; a < 3; a++) {
        for (int w = 0; w < 2; w++) {
            p->at[a][w][i] = (uint32_t)(run->at[a] >> 32 * w);
            p->step[a][w][i] = (uint32_t)(run->step[a] >> 32 * w);
        }
        p->on.rgb[a][i] = state->rgb[a];
    }
    p->on.ray[i] = run->ray;
    p->on.depth[i] = state->depth;
}

static void side_by_side(struct vr_cast_rays *rays, struct vr_cast_samples *samples,
                         const struct vr_cast_frame *frame, const struct vr_cast_brick *brick,
                         const int64_t lo[3], const uint32_t *waiting, uint32_t n, uint64_t *looked)
{
    struct vr_cast_packet *p = &samples->packet;
    const struct vr_cast_kernels *kernels = frame->kernels;
    const enum brick_mode mode = frame->scene->mode;
    do {
        p->on.count = p->ended.count = 0;
        for (uint32_t i = 0; i < n; i++) {
            const uint32_t r = waiting[i];
            if (rays->state[r].done || !rays->wait[r].run)
                continue;
            const struct vr_cast_run run = next_run(rays, &frame->set, lo, r);
            into_packet(p, &run, &rays->state[r], brick);
            took(&rays->wait[r], run.count);
        }
        while (p->on.count) {
            const uint32_t before = p->on.count;
            memset(p->left + before, 0, kernels->lanes * sizeof *p->left);
            p->on.count = 0;
            for (uint32_t i = 0; i < before; i += kernels->lanes) {
                *looked += kernels->typed[frame->set.grid->type].march(
                    &samples->seen, p, i, brick, &frame->field, mode == BRICK_MODE_SHADED);
                if (mode == BRICK_MODE_MIP) {
                    kernels->largest(p, i, before, &samples->seen);
                } else {
                    colour(rays, &samples->seen, frame, brick);
                    kernels->sum(p, i, before, &samples->seen, frame->depth_end);
                }
            }
        }
        for (uint32_t i = 0; i < p->ended.count; i++) {
            struct vr_cast_state *s = &rays->state[p->ended.ray[i]];
            s->depth = p->ended.depth[i];
            s->done = s->depth > frame->depth_end;
            for (int a = 0; a < 3; a++)
                s->rgb[a] = p->ended.rgb[a][i];
        }
    } while (p->ended.count);
}

void vr_cast_through(struct vr_cast_rays *rays, struct vr_cast_samples *samples,
                     const struct vr_cast_frame *frame, const struct vr_cast_brick *brick,
                     const int64_t lo[3], const uint32_t *waiting, uint32_t n, uint64_t *looked)
{
    if (brick->bits)
        in_queues(rays, samples, frame, brick, lo, waiting, n, looked);
    else
        side_by_side(rays, samples, frame, brick, lo, waiting, n, looked);
}
