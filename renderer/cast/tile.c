/* The rays of a tile go through the nearest brick that one of them waits for, all that wait for it together,
 * in rounds of so many samples each: a round's samples are queued, looked at and taken before the next
 * begins, so that a ray that has ended costs no more than its round. Invariants: one brick is pinned at a
 * time; a ray's samples are taken in their order; which brick a sample belongs to is found from its own
 * position. */
#include "tile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a ray has gathered. */
struct state {
    float rgb[3], depth; /* mip: rgb[0] is the largest value */
    bool any;            /* mip: there is one */
    bool done;
};

/* Where a ray waits: `run` samples from k on lie in the brick. */
struct wait {
    uint64_t brick; /* of the level */
    uint32_t k, run;
    int64_t place[3]; /* a voxel before them, which 8.56 positions count from */
};

struct vr_cast_tile {
    struct vr_cast_ray ray[VR_CAST_RAYS];
    struct state state[VR_CAST_RAYS];
    struct wait wait[VR_CAST_RAYS];
    float view[3][VR_CAST_RAYS];
    size_t pixel[VR_CAST_RAYS];
    uint32_t rays;
    /* Of those that wait, nearer or further: number, and how far the eye is. */
    uint32_t order[VR_CAST_RAYS], waiting;
    float way[VR_CAST_RAYS];
    struct vr_cast_queue queue;
    struct vr_cast_seen seen;
    _Alignas(64) float before[VR_CAST_ROOM]; /* optical depth before a sample */
    uint32_t bits[];                         /* of a brick */
};

struct vr_cast_tile *vr_cast_tile_create(const struct vr_cast_activity *activity)
{
    size_t bytes = sizeof(struct vr_cast_tile) + activity->words * sizeof(uint32_t);
    bytes = (bytes + 63) / 64 * 64;
    struct vr_cast_tile *tile = aligned_alloc(64, bytes);
    if (tile)
        memset(tile, 0, bytes);
    return tile;
}

void vr_cast_tile_destroy(struct vr_cast_tile *tile)
{
    free(tile);
}

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

/* On from sample k to the next in an active brick; false when there is none. */
static bool go_on(const struct vr_cast_frame *frame, const struct vr_cast_ray *ray, struct wait *wait)
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

/* Put a ray that has gone on in place `at` of those that wait. */
static void await(struct vr_cast_tile *t, uint32_t r, uint32_t at)
{
    t->order[at] = r;
    t->way[at] = (float)(t->ray[r].enter_mm + t->wait[r].k * (double)t->ray[r].length_mm);
}

/* The tile's pixels: columns [x, end[0]), rows [y, end[1]). */
static void tile_end(const struct brick_image *image, uint32_t x, uint32_t y, uint32_t end[2])
{
    end[0] = x + VR_CAST_TILE < image->width ? x + VR_CAST_TILE : image->width;
    end[1] = y + VR_CAST_TILE < image->height ? y + VR_CAST_TILE : image->height;
}

void vr_cast_tile_clear(const struct vr_cast_frame *frame, uint32_t x, uint32_t y)
{
    const struct brick_image *image = frame->image;
    uint32_t end[2];
    tile_end(image, x, y, end);
    for (; y < end[1]; y++) {
        float *row = image->rgba + 4 * (size_t)y * image->width;
        memset(row + 4 * x, 0, 4 * (end[0] - x) * sizeof *row);
    }
}

static void start(struct vr_cast_tile *t, const struct vr_cast_frame *frame, uint32_t x0, uint32_t y0)
{
    uint32_t end[2];
    tile_end(frame->image, x0, y0, end);
    t->rays = t->waiting = 0;
    for (uint32_t y = y0; y < end[1]; y++)
        for (uint32_t x = x0; x < end[0]; x++) {
            const uint32_t r = t->rays;
            t->pixel[r] = (size_t)y * frame->image->width + x;
            if (!vr_cast_ray_init(&frame->set, x, y, &t->ray[r]))
                continue;
            t->state[r] = (struct state){0};
            t->wait[r].k = 0;
            if (!go_on(frame, &t->ray[r], &t->wait[r]))
                continue;
            for (int a = 0; a < 3; a++)
                t->view[a][r] = t->ray[r].view[a];
            await(t, r, t->waiting++);
            t->rays++;
        }
}

/* Of the samples seen each ray's largest. */
static void take_largest(struct vr_cast_tile *t)
{
    for (uint32_t i = 0; i < t->seen.count; i++) {
        struct state *s = &t->state[t->seen.ray[i]];
        if (!s->any || t->seen.value[i] > s->rgb[0])
            s->rgb[0] = t->seen.value[i];
        s->any = true;
    }
}

/* Optical depth before each sample seen, in the order of the rays' samples; those after a ray's end count
 * nothing. Depth rather than transmittance is summed, which loses nothing however thin. */
static void sum_depth(struct vr_cast_tile *t, float depth_end)
{
    struct vr_cast_seen *seen = &t->seen;
    for (uint32_t i = 0; i < seen->count;) {
        const uint32_t ray = seen->ray[i];
        struct state *s = &t->state[ray];
        float depth = s->depth;
        bool done = s->done;
        for (; i < seen->count && seen->ray[i] == ray; i++) {
            t->before[i] = depth;
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

static void sum_colour(struct vr_cast_tile *t)
{
    const struct vr_cast_seen *seen = &t->seen;
    for (uint32_t i = 0; i < seen->count;) {
        const uint32_t ray = seen->ray[i];
        float *rgb = t->state[ray].rgb, r = rgb[0], g = rgb[1], b = rgb[2];
        for (; i < seen->count && seen->ray[i] == ray; i++) {
            r += seen->alpha[i] * seen->rgb[0][i];
            g += seen->alpha[i] * seen->rgb[1][i];
            b += seen->alpha[i] * seen->rgb[2][i];
        }
        rgb[0] = r, rgb[1] = g, rgb[2] = b;
    }
}

/* Look at what is queued. */
static void look(struct vr_cast_tile *t, const struct vr_cast_frame *frame, const struct vr_cast_brick *brick)
{
    const enum brick_mode mode = frame->scene->mode;
    const struct vr_cast_typed *typed = &frame->kernels->typed[frame->set.grid->type];
    if (!t->queue.count)
        return;
    typed->look(&t->seen, &t->queue, brick, &frame->field, mode == BRICK_MODE_SHADED);
    t->queue.count = 0;
    if (!t->seen.count)
        return;
    if (mode == BRICK_MODE_MIP) {
        take_largest(t);
        return;
    }
    frame->kernels->classify(&t->seen, &frame->pieces);
    if (mode == BRICK_MODE_SHADED) {
        struct vr_cast_light light = frame->light;
        for (int a = 0; a < 3; a++)
            light.view[a] = t->view[a];
        typed->shade(&t->seen, brick, &light, frame->field.nonfinite);
    }
    sum_depth(t, frame->depth_end);
    frame->kernels->dim(&t->seen, t->before);
    sum_colour(t);
}

/* Part of a ray's samples in the brick into the queue: those that are where steps lead together, others
 * alone. */
static void queue_run(struct vr_cast_tile *t, const struct vr_cast_frame *frame,
                      const struct vr_cast_brick *brick, const int64_t lo[3], uint32_t r)
{
    const struct vr_cast_ray *ray = &t->ray[r];
    struct wait *wait = &t->wait[r];
    struct vr_cast_run run = {.ray = r, .count = 1};
    if (!vr_cast_ray_is_end(&frame->set, ray, wait->k)) {
        const uint32_t before_last = ray->count - 1 - wait->k;
        run.count = wait->run < before_last ? wait->run : before_last;
    }
    run.length_mm = vr_cast_ray_length(&frame->set, ray, wait->k);
    for (int a = 0; a < 3; a++) {
        run.at[a] = vr_fixed_near(vr_cast_ray_sample(&frame->set, ray, a, wait->k), wait->place[a]);
        run.step[a] = vr_fixed_near(ray->step[a], 0);
        run.offset[a] = (int32_t)(wait->place[a] - lo[a]);
    }
    const uint32_t count = run.count;
    frame->kernels->scan(&t->queue, brick, &run);
    wait->k += count - run.count;
    wait->run -= count - run.count;
}

/* All rays that wait for the brick through it. */
static void go_through(struct vr_cast_tile *t, const struct vr_cast_frame *frame,
                       const struct vr_cast_brick *brick, const int64_t lo[3], const uint32_t *waiting,
                       uint32_t n, uint64_t *samples)
{
    bool on = true;
    while (on) {
        on = false;
        for (uint32_t i = 0; i < n; i++) {
            const uint32_t r = waiting[i];
            if (t->state[r].done || !t->wait[r].run)
                continue;
            queue_run(t, frame, brick, lo, r);
            on = on || t->wait[r].run;
            if (t->queue.count >= VR_CAST_QUEUE) {
                *samples += t->queue.count;
                look(t, frame, brick);
            }
        }
        *samples += t->queue.count;
        look(t, frame, brick);
    }
}

static int visit(struct vr_cast_tile *t, const struct vr_cast_frame *frame, uint64_t index,
                 const uint32_t *waiting, uint32_t n, uint64_t *samples, struct brick_error *err)
{
    const struct brick_grid *grid = frame->set.grid;
    const uint64_t id = frame->set.level->first_brick + index;
    struct vr_cast_activity *activity = frame->activity;
    struct brick_place place;
    struct vr_cast_brick brick;
    int code = brick_cache_pin(frame->cache, id, &brick.voxels, err);
    if (code)
        return code;
    brick_grid_place(grid, id, &place);
    brick.row = (int32_t)place.stored[0];
    brick.slice = (int32_t)(place.stored[0] * place.stored[1]);
    brick.border = (int32_t)grid->border;
    brick.bits = NULL;
    brick.words = activity->words;
    brick.bit_row = (int32_t)activity->across;
    brick.bit_slice = (int32_t)(activity->across * activity->across);
    brick.macro_shift = (int32_t)activity->shift;
    if (activity->state[index] != BRICK_STATE_WHOLE)
        brick.bits = vr_cast_activity_bits(
            activity, index, (const char *)brick.voxels + brick_place_voxel_bytes(grid, &place), t->bits);
    go_through(t, frame, &brick, place.lo, waiting, n, samples);
    brick_cache_unpin(frame->cache, id);
    return BRICK_OK;
}

/* The rays' colours into the picture; of those with something a lane each. */
static void finish(struct vr_cast_tile *t, const struct vr_cast_frame *frame)
{
    const bool mip = frame->scene->mode == BRICK_MODE_MIP;
    struct vr_cast_seen *seen = &t->seen;
    seen->count = t->rays;
    for (uint32_t r = 0; r < t->rays; r++) {
        seen->value[r] = t->state[r].rgb[0];
        seen->length_mm[r] = frame->unit_mm;
        seen->depth[r] = t->state[r].depth;
    }
    if (mip)
        frame->kernels->classify(seen, &frame->pieces);
    else
        frame->kernels->opacities(seen);
    for (uint32_t r = 0; r < t->rays; r++) {
        float *rgba = frame->image->rgba + 4 * t->pixel[r];
        const float alpha = seen->alpha[r];
        if (mip && !t->state[r].any)
            continue;
        for (int c = 0; c < 3; c++)
            rgba[c] = mip ? alpha * seen->rgb[c][r] : t->state[r].rgb[c];
        rgba[3] = alpha;
    }
}

int vr_cast_tile_draw(struct vr_cast_tile *t, const struct vr_cast_frame *frame, uint32_t x, uint32_t y,
                      uint64_t *samples, struct brick_error *err)
{
    uint32_t through[VR_CAST_RAYS];
    vr_cast_tile_clear(frame, x, y);
    start(t, frame, x, y);
    while (t->waiting) {
        uint32_t nearest = 0, n = 0, stay = 0;
        for (uint32_t i = 1; i < t->waiting; i++)
            nearest = t->way[i] < t->way[nearest] ? i : nearest;
        const uint64_t brick = t->wait[t->order[nearest]].brick;
        for (uint32_t i = 0; i < t->waiting; i++) {
            const uint32_t r = t->order[i];
            if (t->wait[r].brick == brick) {
                through[n++] = r;
                continue;
            }
            t->order[stay] = r;
            t->way[stay++] = t->way[i];
        }
        int code = visit(t, frame, brick, through, n, samples, err);
        if (code)
            return code;
        for (uint32_t i = 0; i < n; i++)
            if (!t->state[through[i]].done && go_on(frame, &t->ray[through[i]], &t->wait[through[i]]))
                await(t, through[i], stay++);
        t->waiting = stay;
    }
    finish(t, frame);
    return BRICK_OK;
}
