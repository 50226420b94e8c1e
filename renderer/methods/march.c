/* Passes and parts. All that a pass leaves is in the target's words, so nothing here knows what a method does
 * in one. */
#include "march.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define TARGET_EDGE      1024
#define MAX_REFINEMENTS  96 /* bits of a ray's path; see state.glsl */
#define CUBIC_HALVINGS   24 /* at most, until both ends are in one cell */
#define LOOK_AHEAD_TURNS 256
#define MAX_LOOK_AHEAD   64

enum { IMAGE_STATE, IMAGE_PROGRESS, IMAGE_FEEDBACK };

struct round {
    const struct vr_march_pass *passes;
    struct vr_uniforms programs[VR_MARCH_MAX_PASSES];
    size_t count;
};

static bool has_bounds(const struct vr_frame *frame)
{
    return frame->quality->setup == VR_SETUP_GEOMETRY;
}

static int use_program(const struct vr_frame *frame, const struct vr_march_pass *pass,
                       struct vr_uniforms *uniforms, struct brick_error *err)
{
    char defines[VR_FRAME_DEFINES_BYTES + 256];
    size_t n = vr_frame_defines(frame, defines);
    snprintf(defines + n, sizeof defines - n, "#define LOOK_AHEAD_TURNS %d\n#define TILE_EDGE %d\n%s%s%s%s",
             LOOK_AHEAD_TURNS, VR_TARGET_TILE, has_bounds(frame) ? "#define BOUNDS\n" : "",
             frame->quality->cubic ? "#define CUBIC\n" : "",
             frame->quality->distances ? "#define DISTANCES\n" : "", pass->defines);
    uniforms->gl = &frame->context->gl;
    int result = vr_programs_get(&frame->store->programs, frame->context, pass->source, defines,
                                 &uniforms->program, err);
    if (!result)
        uniforms->gl->UseProgram(uniforms->program);
    return result;
}

static void set_surface(const struct vr_frame *frame, const struct vr_uniforms *u)
{
    const struct vr_scene *scene = frame->scene;
    const struct vr_quality *quality = frame->quality;
    double rgb[3] = {scene->iso_rgb[0], scene->iso_rgb[1], scene->iso_rgb[2]}, sigma;
    uint32_t refinements = quality->cubic              ? CUBIC_HALVINGS
                           : quality->refinements < 64 ? quality->refinements
                                                       : 64;
    if (scene->transfer)
        brick_transfer_eval(scene->transfer, scene->isovalue, rgb, &sigma);
    /* Samples further apart than a voxel are brought into cells that touch, whatever the refinement. */
    for (double step = quality->step_vox; step > 1.0; step /= 2.0)
        refinements++;
    if (refinements > MAX_REFINEMENTS)
        refinements = MAX_REFINEMENTS;
    vr_set_vec3(u, "surface", rgb);
    vr_set_int(u, "refinements", (int)refinements);
    vr_set_float(u, "isovalue", vr_stored_threshold(frame->grid, scene->isovalue));
}

/* How many bricks a waiting ray may ask for beyond the one it needs. While what rays want fills less than
 * half the cache the number doubles, so that a cache with room costs a number of passes that grows with the
 * logarithm of the bricks along a ray; and since a ray has passed as many bricks as it may ask for, at most
 * about half of what is read can be hidden behind where rays end. When more is wanted than there are slots,
 * asking further gains nothing. A round that waited for nothing says nothing. */
static int choose_ahead(int ahead, uint64_t wanted, uint64_t slots)
{
    if (wanted && wanted <= slots / 2)
        return ahead < MAX_LOOK_AHEAD ? 2 * ahead : ahead;
    return wanted > slots && ahead > 1 ? ahead / 2 : ahead;
}

/* One part of the picture, round after round, until all its rays have ended. */
static int draw_part(struct vr_march *m, const struct vr_frame *frame, const struct round *round,
                     const struct vr_target *target, int width, int height, struct vr_report *report,
                     struct brick_error *err)
{
    struct vr_context *context = frame->context;
    struct vr_residency *residency = frame->residency;
    struct vr_feedback *feedback = &m->feedback;
    const int across = TARGET_EDGE / VR_TARGET_TILE;
    uint64_t wanted, slots = vr_residency_atlas(residency)->count;
    bool unfinished = true, resume = false;
    int ahead = 1;
    for (uint32_t t = 0; t < feedback->tiles; t++)
        feedback->words[t] = 1;
    for (;;) {
        vr_atlas_use(vr_residency_atlas(residency), context, VR_UNIT_ATLAS);
        vr_feedback_clear(feedback, context);
        for (size_t p = 0; p < round->count; p++) {
            const struct vr_uniforms *u = &round->programs[p];
            u->gl->UseProgram(u->program);
            vr_set_int(u, "resume", resume);
            vr_set_int(u, "look_ahead", ahead);
            vr_target_draw(target, context, width, height, feedback->words, across, round->passes[p].depth);
            resume = true;
            report->passes++;
        }
        vr_feedback_read(feedback, context);
        int result = vr_context_check(context, "marching rays", err);
        if (result)
            return result;
        unfinished = false;
        for (uint32_t t = 0; t < feedback->tiles && !unfinished; t++)
            unfinished = feedback->words[t] != 0;
        if (!unfinished)
            return BRICK_OK;
        if ((result = vr_residency_bring(residency, feedback, &wanted, err)))
            return result;
        ahead = choose_ahead(ahead, wanted, slots);
    }
}

static bool uses_depth(const struct round *round)
{
    for (size_t p = 0; p < round->count; p++)
        if (round->passes[p].depth != VR_TARGET_DEPTH_OFF)
            return true;
    return false;
}

/* For each pass's program what it needs of the part at x, y: meshes and bounding geometry, where there are
 * any. */
static int set_part(const struct vr_march *m, const struct vr_frame *frame, const struct round *round, int x,
                    int y, struct brick_error *err)
{
    int result = frame->scene->mesh_count ? vr_meshes_draw(frame, x, y, err) : BRICK_OK;
    if (!result && has_bounds(frame))
        result = vr_bounds_draw(&m->bounds, frame, x, y, err);
    for (size_t p = 0; p < round->count && !result; p++) {
        const struct vr_uniforms *u = &round->programs[p];
        u->gl->UseProgram(u->program);
        vr_set_ivec2(u, "tile_origin", x, y);
        if (frame->scene->mesh_count)
            vr_meshes_use(frame, u);
        if (has_bounds(frame))
            vr_bounds_use(&m->bounds, u);
    }
    return result;
}

/* The picture part by part through one target. */
static int draw_parts(struct vr_march *m, const struct vr_frame *frame, const struct round *round,
                      struct brick_image *image, struct vr_report *report, struct brick_error *err)
{
    struct vr_context *context = frame->context;
    struct vr_target target = {0};
    int width = (int)image->width, height = (int)image->height;
    int tw = width < TARGET_EDGE ? width : TARGET_EDGE, th = height < TARGET_EDGE ? height : TARGET_EDGE;
    uint32_t *progress = malloc((size_t)tw * (size_t)th * 2 * sizeof *progress);
    int result = progress ? vr_target_init(&target, context, tw, th, uses_depth(round), err)
                          : brick_fail(err, BRICK_ERR_MEMORY, "no memory for a picture of %d x %d", tw, th);
    if (!result && frame->scene->mesh_count)
        result = vr_meshes_begin(frame, tw, th, err);
    if (!result && has_bounds(frame))
        result = vr_bounds_begin(&m->bounds, frame, tw, th, err);
    if (!result) {
        vr_target_use(&target, context, IMAGE_STATE, IMAGE_PROGRESS);
        vr_buffer_use_image(&m->feedback.buffer, context, IMAGE_FEEDBACK);
    }
    for (int y = 0; !result && y < height; y += th)
        for (int x = 0; !result && x < width; x += tw) {
            int w = width - x < tw ? width - x : tw, h = height - y < th ? height - y : th;
            if ((result = set_part(m, frame, round, x, y, err)) ||
                (result = draw_part(m, frame, round, &target, w, h, report, err)))
                break;
            vr_target_read(&target, context, w, h, image->rgba + 4 * ((size_t)y * image->width + (size_t)x),
                           width, progress);
            for (size_t i = 0; i < (size_t)w * (size_t)h; i++)
                report->samples += progress[2 * i + 1];
            result = vr_context_check(context, "reading the picture", err);
        }
    vr_target_finish(&target, context);
    free(progress);
    return result;
}

static int set_uniforms(const struct vr_march *m, const struct vr_frame *frame, const struct vr_uniforms *u,
                        struct brick_error *err)
{
    const double termination = frame->quality->termination;
    int result = BRICK_OK;
    vr_frame_set_rays(frame, u);
    vr_frame_set_field(frame, u);
    vr_frame_set_shading(frame, u);
    if (frame->scene->mode == BRICK_MODE_ISO)
        set_surface(frame, u);
    else
        result = vr_frame_set_transfer(frame, u, err);
    if (frame->scene->mode == BRICK_MODE_MIP)
        vr_set_float(u, "unit_mm", frame->scene->transfer->unit_mm);
    /* A ray ends where exp(-depth) falls below the threshold. */
    vr_set_float(u, "depth_end", termination > 0.0 ? -log(termination) : FLT_MAX);
    vr_set_int(u, "state_image", IMAGE_STATE);
    vr_set_int(u, "progress_image", IMAGE_PROGRESS);
    vr_set_int(u, "feedback", IMAGE_FEEDBACK);
    vr_set_int(u, "tiles_across", TARGET_EDGE / VR_TARGET_TILE);
    vr_set_int(u, "tiles", (int)m->feedback.tiles);
    return result;
}

int vr_march_draw(struct vr_march *m, const struct vr_frame *frame, const struct vr_march_pass *passes,
                  size_t count, struct brick_image *image, struct vr_report *report, struct brick_error *err)
{
    const struct brick_level *level = frame->level;
    struct round round = {.passes = passes, .count = count};
    int result = vr_feedback_resize(&m->feedback, frame->context,
                                    (TARGET_EDGE / VR_TARGET_TILE) * (TARGET_EDGE / VR_TARGET_TILE),
                                    level->bricks[0] * level->bricks[1] * level->bricks[2], err);
    for (size_t p = 0; p < count && !result; p++)
        if (!(result = use_program(frame, &passes[p], &round.programs[p], err)))
            result = set_uniforms(m, frame, &round.programs[p], err);
    if (!result)
        result = draw_parts(m, frame, &round, image, report, err);
    frame->context->gl.UseProgram(0);
    return result;
}

void vr_march_finish(struct vr_march *m, struct vr_context *context)
{
    vr_feedback_finish(&m->feedback, context);
    vr_bounds_finish(&m->bounds, context);
}
