/* The rays of a tile go through the nearest brick that one of them waits for, all that wait for it together.
 * Invariant: one brick is pinned at a time. */
#include "tile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "through.h"

struct vr_cast_tile {
    struct vr_cast_rays rays;
    struct vr_cast_samples samples;
    size_t pixel[VR_CAST_RAYS];
    uint32_t count;
    /* Of those that wait, nearer or further: number, and how far the eye is. */
    uint32_t order[VR_CAST_RAYS], waiting;
    float way[VR_CAST_RAYS];
    /* Of all pixels, row by row: where the nearest mesh is, and its colour. */
    double mesh_mm[VR_CAST_RAYS], mesh_rgb[VR_CAST_RAYS][3];
    uint32_t bits[]; /* of a brick */
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

/* Put a ray that has gone on in place `at` of those that wait. */
static void await(struct vr_cast_tile *t, uint32_t r, uint32_t at)
{
    t->order[at] = r;
    t->way[at] = (float)(t->rays.ray[r].enter_mm + t->rays.wait[r].k * (double)t->rays.ray[r].length_mm);
}

/* A tile's pixels: columns [x, end_x), rows [y, end_y). */
struct part {
    uint32_t x, y, end_x, end_y;
};

static struct part part_at(const struct brick_image *image, uint32_t x, uint32_t y)
{
    return (struct part){x, y, x + VR_CAST_TILE < image->width ? x + VR_CAST_TILE : image->width,
                         y + VR_CAST_TILE < image->height ? y + VR_CAST_TILE : image->height};
}

static void clear(struct brick_image *image, struct part p)
{
    for (uint32_t y = p.y; y < p.end_y; y++) {
        float *row = image->rgba + 4 * (size_t)y * image->width;
        memset(row + 4 * p.x, 0, 4 * (p.end_x - p.x) * sizeof *row);
    }
}

static void meet_meshes(struct vr_cast_tile *t, const struct vr_mesh_view *meshes, struct part p)
{
    uint32_t i = 0;
    for (uint32_t y = p.y; y < p.end_y; y++)
        for (uint32_t x = p.x; x < p.end_x; x++, i++)
            t->mesh_mm[i] = vr_mesh_view_pixel(meshes, x, y, t->mesh_rgb[i]);
}

/* Meshes behind what is there. */
static void add_meshes(const struct vr_cast_tile *t, struct brick_image *image, struct part p)
{
    uint32_t i = 0;
    for (uint32_t y = p.y; y < p.end_y; y++)
        for (uint32_t x = p.x; x < p.end_x; x++, i++) {
            float *rgba = image->rgba + 4 * ((size_t)y * image->width + x);
            const float rest = 1.0f - rgba[3];
            for (int c = 0; c < 3 && t->mesh_mm[i] < INFINITY; c++)
                rgba[c] += rest * (float)t->mesh_rgb[i][c];
            rgba[3] += t->mesh_mm[i] < INFINITY ? rest : 0.0f;
        }
}

static void start(struct vr_cast_tile *t, const struct vr_cast_frame *frame, struct part p)
{
    const bool meshes = frame->meshes->any;
    uint32_t i = 0;
    t->count = t->waiting = 0;
    for (uint32_t y = p.y; y < p.end_y; y++)
        for (uint32_t x = p.x; x < p.end_x; x++, i++) {
            const uint32_t r = t->count;
            t->pixel[r] = (size_t)y * frame->image->width + x;
            if (!vr_cast_ray_init(&frame->set, x, y, meshes ? t->mesh_mm[i] : INFINITY, &t->rays.ray[r]))
                continue;
            t->rays.state[r] = (struct vr_cast_state){0};
            t->rays.wait[r].k = 0;
            if (!vr_cast_go_on(frame, &t->rays.ray[r], &t->rays.wait[r]))
                continue;
            for (int a = 0; a < 3; a++)
                t->rays.view[a][r] = t->rays.ray[r].view[a];
            await(t, r, t->waiting++);
            t->count++;
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
    const unsigned kept = vr_cast_flush();
    vr_cast_through(&t->rays, &t->samples, frame, &brick, place.lo, waiting, n, samples);
    vr_cast_restore(kept);
    brick_cache_unpin(frame->cache, id);
    return BRICK_OK;
}

/* The rays' colours into the picture; of those with something a lane each. */
static void finish(struct vr_cast_tile *t, const struct vr_cast_frame *frame)
{
    const bool mip = frame->scene->mode == BRICK_MODE_MIP;
    struct vr_cast_seen *seen = &t->samples.seen;
    seen->count = t->count;
    for (uint32_t r = 0; r < t->count; r++) {
        seen->value[r] = t->rays.state[r].rgb[0];
        seen->length_mm[r] = frame->unit_mm;
        seen->depth[r] = t->rays.state[r].depth;
    }
    if (mip)
        frame->kernels->classify(seen, &frame->pieces);
    else
        frame->kernels->opacities(seen);
    for (uint32_t r = 0; r < t->count; r++) {
        float *rgba = frame->image->rgba + 4 * t->pixel[r];
        const float alpha = seen->alpha[r];
        if (mip && t->rays.state[r].depth == 0.0f)
            continue;
        for (int c = 0; c < 3; c++)
            rgba[c] = mip ? alpha * seen->rgb[c][r] : t->rays.state[r].rgb[c];
        rgba[3] = alpha;
    }
}

/* All rays to their ends. */
static int go(struct vr_cast_tile *t, const struct vr_cast_frame *frame, uint64_t *samples,
              struct brick_error *err)
{
    uint32_t through[VR_CAST_RAYS];
    while (t->waiting) {
        uint32_t nearest = 0, n = 0, stay = 0;
        for (uint32_t i = 1; i < t->waiting; i++)
            nearest = t->way[i] < t->way[nearest] ? i : nearest;
        const uint64_t brick = t->rays.wait[t->order[nearest]].brick;
        for (uint32_t i = 0; i < t->waiting; i++) {
            const uint32_t r = t->order[i];
            if (t->rays.wait[r].brick == brick) {
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
            if (!t->rays.state[through[i]].done &&
                vr_cast_go_on(frame, &t->rays.ray[through[i]], &t->rays.wait[through[i]]))
                await(t, through[i], stay++);
        t->waiting = stay;
    }
    return BRICK_OK;
}

int vr_cast_tile_draw(struct vr_cast_tile *t, const struct vr_cast_frame *frame, uint32_t x, uint32_t y,
                      bool shows, uint64_t *samples, struct brick_error *err)
{
    const struct part part = part_at(frame->image, x, y);
    int code = BRICK_OK;
    clear(frame->image, part);
    if (frame->meshes->any)
        meet_meshes(t, frame->meshes, part);
    if (shows) {
        start(t, frame, part);
        code = go(t, frame, samples, err);
        const unsigned kept = vr_cast_flush();
        finish(t, frame);
        vr_cast_restore(kept);
    }
    if (frame->meshes->any)
        add_meshes(t, frame->image, part);
    return code;
}
