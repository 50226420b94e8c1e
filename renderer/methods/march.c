/* Passes and parts. All that a pass leaves is in the target's words, so nothing here knows what a method does
 * in one. */
#include "march.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <brick/threads.h>

#include "footprint.h"
#include "shaders.h"

#define TARGET_EDGE      1024
#define CUBIC_HALVINGS   24 /* at most, until both ends are in one cell */
#define MAX_REFINEMENTS  96 /* bits of a ray's path; see state.glsl */
#define LOOK_AHEAD_TURNS 256
#define MAX_LOOK_AHEAD   64
#define TILES_ACROSS     (TARGET_EDGE / VR_TARGET_TILE)
#define TILES            (TILES_ACROSS * TILES_ACROSS)

enum { IMAGE_STATE, IMAGE_PROGRESS, IMAGE_FEEDBACK };

/* A round's programs. */
struct round {
    const struct vr_march_pass *passes;
    struct vr_uniforms programs[VR_MARCH_MAX_PASSES];
    size_t count;
};

static const struct vr_shader_part far_parts[] = {VR_MARCH_PARTS, {"raycast.glsl", vr_shader_raycast}};
static const struct vr_program_source far_source = {.fragment = far_parts,
                                                    .fragment_count = sizeof far_parts / sizeof *far_parts};
/* What a ray does in one pass is bounded so that 16 rays at once stay below the 65535 turns of loops that
 * llvmpipe allows: at most 5 turns a sample or leap, if rays wait for each other all the time, and leaps to
 * look ahead. */
const struct vr_march_pass vr_march_far = {&far_source, "#define STEPS_A_PASS 750\n", VR_TARGET_DEPTH_OFF};

static bool has_bounds(const struct vr_frame *frame)
{
    return frame->quality->setup == VR_SETUP_GEOMETRY;
}

static int use_program(const struct vr_frame *frame, const struct vr_march_pass *pass, bool stand_in,
                       struct vr_uniforms *uniforms, struct brick_error *err)
{
    char defines[VR_FRAME_DEFINES_BYTES + 256], levels[64] = "";
    size_t n = vr_frame_defines(frame, defines);
    if (stand_in)
        snprintf(levels, sizeof levels, "#define STAND_IN %d\n#undef PREINTEGRATED\n", BRICK_MAX_LEVELS);
    snprintf(defines + n, sizeof defines - n, "#define LOOK_AHEAD_TURNS %d\n#define TILE_EDGE %d\n%s%s%s%s%s",
             LOOK_AHEAD_TURNS, VR_TARGET_TILE, has_bounds(frame) ? "#define BOUNDS\n" : "",
             frame->quality->cubic && !stand_in ? "#define CUBIC\n" : "",
             frame->quality->distances ? "#define DISTANCES\n" : "", levels, pass->defines);
    return vr_frame_use_program(frame, pass->source, defines, uniforms, err);
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

/* A piece of the picture no larger than a target. */
struct part {
    int x, y, width, height;
};

static struct part part_of(const struct brick_image *image, int index)
{
    const int width = (int)image->width, height = (int)image->height;
    const int across = (width + TARGET_EDGE - 1) / TARGET_EDGE;
    struct part part = {.x = index % across * TARGET_EDGE, .y = index / across * TARGET_EDGE};
    part.width = width - part.x < TARGET_EDGE ? width - part.x : TARGET_EDGE;
    part.height = height - part.y < TARGET_EDGE ? height - part.y : TARGET_EDGE;
    return part;
}

static int part_count(const struct brick_image *image)
{
    return (int)((image->width + TARGET_EDGE - 1) / TARGET_EDGE *
                 ((image->height + TARGET_EDGE - 1) / TARGET_EDGE));
}

static int rays_resize(struct vr_march_rays *rays, struct vr_context *context,
                       const struct brick_image *image, bool depth, uint64_t bricks, struct brick_error *err)
{
    const struct part first = part_of(image, 0);
    if (rays->target.width != first.width || rays->target.height != first.height) {
        vr_target_finish(&rays->target, context);
        int result = vr_target_init(&rays->target, context, first.width, first.height, depth, err);
        if (result)
            return result;
    }
    return vr_feedback_resize(&rays->feedback, context, TILES, bricks, err);
}

static void rays_finish(struct vr_march_rays *rays, struct vr_context *context)
{
    vr_target_finish(&rays->target, context);
    vr_feedback_finish(&rays->feedback, context);
}

static bool uses_depth(const struct round *round)
{
    for (size_t p = 0; p < round->count; p++)
        if (round->passes[p].depth != VR_TARGET_DEPTH_OFF)
            return true;
    return false;
}

/* A part's rays begin: in all tiles or, where only active bricks can show, in those that can show one; the
 * others' pixels are empty. */
static void begin_tiles(struct vr_march_rays *rays, const struct vr_frame *frame, const struct part *part)
{
    const struct vr_tiles tiles = {part->x, part->y, part->width, part->height, VR_TARGET_TILE, TILES_ACROSS};
    for (uint32_t t = 0; t < TILES; t++)
        rays->feedback.words[t] = 1;
    if (!frame->quality->skip || frame->scene->mesh_count)
        return;
    vr_footprint(&frame->view, frame->grid, frame->scene->level, vr_residency_states(frame->residency),
                 &tiles, rays->feedback.words);
    vr_target_clear(&rays->target, frame->context);
}

static int set_scene(const struct vr_frame *frame, const struct vr_uniforms *u, struct brick_error *err)
{
    const double termination = frame->quality->termination;
    int result;
    vr_frame_set_rays(frame, u);
    vr_frame_set_field(frame, u);
    vr_frame_set_shading(frame, u);
    if (frame->scene->mode == BRICK_MODE_ISO)
        set_surface(frame, u);
    else if ((result = vr_frame_set_transfer(frame, u, err)))
        return result;
    if (frame->scene->mode == BRICK_MODE_MIP)
        vr_set_float(u, "unit_mm", frame->scene->transfer->unit_mm);
    /* A ray ends where exp(-depth) falls below the threshold. */
    vr_set_float(u, "depth_end", termination > 0.0 ? -log(termination) : FLT_MAX);
    vr_set_int(u, "state_image", IMAGE_STATE);
    vr_set_int(u, "progress_image", IMAGE_PROGRESS);
    vr_set_int(u, "feedback", IMAGE_FEEDBACK);
    vr_set_int(u, "tiles_across", TILES_ACROSS);
    vr_set_int(u, "tiles", TILES);
    return BRICK_OK;
}

/* Programs and images of the rays, and room for what is drawn before them. */
static int begin_round(struct vr_march *m, const struct vr_frame *frame, const struct vr_march_rays *rays,
                       bool stand_in, struct round *round, struct brick_error *err)
{
    const int width = rays->target.width, height = rays->target.height;
    int result = frame->scene->mesh_count ? vr_meshes_begin(frame, width, height, err) : BRICK_OK;
    if (!result && has_bounds(frame))
        result = vr_bounds_begin(&m->bounds, frame, width, height, err);
    for (size_t p = 0; p < round->count && !result; p++)
        if (!(result = use_program(frame, &round->passes[p], stand_in, &round->programs[p], err)))
            result = set_scene(frame, &round->programs[p], err);
    vr_target_use(&rays->target, frame->context, IMAGE_STATE, IMAGE_PROGRESS);
    vr_buffer_use_image(&rays->feedback.buffer, frame->context, IMAGE_FEEDBACK);
    return result;
}

/* For each program what it needs of the part: its place, meshes and bounding geometry, where there are any.
 */
static int begin_part(const struct vr_march *m, const struct vr_frame *frame, const struct round *round,
                      const struct part *part, struct brick_error *err)
{
    int result = frame->scene->mesh_count ? vr_meshes_draw(frame, part->x, part->y, err) : BRICK_OK;
    if (!result && has_bounds(frame))
        result = vr_bounds_draw(&m->bounds, frame, part->x, part->y, err);
    for (size_t p = 0; p < round->count && !result; p++) {
        const struct vr_uniforms *u = &round->programs[p];
        u->gl->UseProgram(u->program);
        vr_set_ivec2(u, "tile_origin", part->x, part->y);
        if (frame->scene->mesh_count)
            vr_meshes_use(frame, u);
        if (has_bounds(frame))
            vr_bounds_use(&m->bounds, frame, u);
    }
    return result;
}

/* A round over all unfinished rays of a part. *unfinished: some still are. */
static int march_round(struct vr_march_rays *rays, const struct vr_frame *frame, const struct round *round,
                       const struct part *part, int ahead, bool resume, bool *unfinished,
                       struct brick_error *err)
{
    struct vr_feedback *feedback = &rays->feedback;
    vr_atlas_use(vr_residency_atlas(frame->residency), frame->context, VR_UNIT_ATLAS);
    vr_feedback_clear(feedback, frame->context);
    for (size_t p = 0; p < round->count; p++) {
        const struct vr_uniforms *u = &round->programs[p];
        u->gl->UseProgram(u->program);
        vr_set_int(u, "resume", resume || p > 0);
        vr_set_int(u, "look_ahead", ahead);
        vr_target_draw(&rays->target, frame->context, part->width, part->height, feedback->words,
                       TILES_ACROSS, round->passes[p].depth);
    }
    vr_feedback_read(feedback, frame->context);
    *unfinished = false;
    for (uint32_t t = 0; t < TILES && !*unfinished; t++)
        *unfinished = feedback->words[t] != 0;
    return vr_context_check(frame->context, "marching rays", err);
}

/* The part's colours into the picture; *samples grows by those that its rays took. */
static int read_part(const struct vr_march_rays *rays, const struct vr_frame *frame, const struct part *part,
                     struct brick_image *image, uint64_t *samples, struct brick_error *err)
{
    const size_t pixels = (size_t)part->width * (size_t)part->height;
    uint32_t *progress = malloc(pixels * 2 * sizeof *progress);
    if (!progress)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a picture of %d x %d", part->width,
                          part->height);
    vr_target_read(&rays->target, frame->context, part->width, part->height,
                   image->rgba + 4 * ((size_t)part->y * image->width + (size_t)part->x), (int)image->width,
                   progress);
    for (size_t i = 0; i < pixels; i++)
        *samples += progress[2 * i + 1];
    free(progress);
    return vr_context_check(frame->context, "reading the picture", err);
}

static uint64_t loaded_bytes(const struct vr_frame *frame)
{
    struct vr_residency_counters counters;
    vr_residency_count(frame->residency, &counters);
    return counters.bricks_loaded * vr_residency_atlas(frame->residency)->slot_bytes;
}

/* The part in work, round after round, until all its rays have ended or the budget is used up. before: bytes
 * loaded before this call. */
static int draw_part(struct vr_march *m, struct vr_frame *frame, const struct round *round, uint64_t before,
                     struct brick_image *image, struct vr_report *report, struct brick_error *err)
{
    const struct vr_atlas *atlas = vr_residency_atlas(frame->residency);
    const struct part part = part_of(image, m->part);
    if (!m->resume) {
        begin_tiles(&m->rays, frame, &part);
        m->ahead = 1;
    }
    int result = begin_part(m, frame, round, &part, err);
    while (!result) {
        bool unfinished;
        uint64_t wanted;
        result = march_round(&m->rays, frame, round, &part, m->ahead, m->resume, &unfinished, err);
        report->passes += round->count;
        if (result)
            return result;
        m->resume = unfinished;
        if (!unfinished)
            return read_part(&m->rays, frame, &part, image, &report->samples, err);
        const uint64_t room = (frame->upload_bytes - (loaded_bytes(frame) - before)) / atlas->slot_bytes;
        const struct vr_residency_limit limit = {room ? room : 1, frame->deadline_ns};
        if ((result = vr_residency_bring(frame->residency, &m->rays.feedback, &limit, &wanted, err)))
            return result;
        m->ahead = choose_ahead(m->ahead, wanted, atlas->count);
        const uint64_t spent = loaded_bytes(frame) - before;
        frame->final =
            (frame->deadline_ns == UINT64_MAX || brick_now_ns() + m->look_ns < frame->deadline_ns) &&
            (frame->upload_bytes == UINT64_MAX || spent + atlas->slot_bytes <= frame->upload_bytes);
        if (!frame->final)
            return BRICK_OK;
    }
    return result;
}

/* What is not final yet, as far as it can be seen by what is in the GPU cache. */
static int look(struct vr_march *m, const struct vr_frame *frame, struct brick_image *image,
                struct brick_error *err)
{
    const uint64_t start_ns = brick_now_ns();
    struct round round = {.passes = &vr_march_far, .count = 1};
    uint64_t samples = 0;
    int result = rays_resize(&m->look, frame->context, image, false, 0, err);
    if (result || (result = begin_round(m, frame, &m->look, true, &round, err)))
        return result;
    vr_frame_set_stand_ins(frame, &round.programs[0]);
    for (int p = m->part; p < part_count(image) && !result; p++) {
        const struct part part = part_of(image, p);
        bool resume = p == m->part && m->resume, unfinished = true;
        begin_tiles(&m->look, frame, &part);
        if (resume) {
            memcpy(m->look.feedback.words, m->rays.feedback.words, TILES * sizeof *m->look.feedback.words);
            vr_target_copy(&m->look.target, frame->context, &m->rays.target, part.width, part.height);
        }
        result = begin_part(m, frame, &round, &part, err);
        while (!result && unfinished) {
            result = march_round(&m->look, frame, &round, &part, 0, resume, &unfinished, err);
            resume = true;
        }
        if (!result)
            result = read_part(&m->look, frame, &part, image, &samples, err);
    }
    m->look_ns = brick_now_ns() - start_ns;
    return result;
}

/* Both ends of a step must lie in cells that touch, at the most: shaders/segments.glsl. */
static int check_step(const struct vr_frame *frame, struct brick_error *err)
{
    double inverse[3][4], longest = 0.0, step = frame->quality->step_vox;
    brick_affine_invert(frame->grid->affine, inverse);
    for (int a = 0; a < 3; a++)
        longest = fmax(longest, frame->step_mm *
                                    sqrt(inverse[a][0] * inverse[a][0] + inverse[a][1] * inverse[a][1] +
                                         inverse[a][2] * inverse[a][2]) /
                                    frame->level->scale[a]);
    if (longest > 1.0 + 1e-9)
        return brick_fail(
            err, BRICK_ERR_ARGUMENT,
            "pre-integrated classification takes steps of up to %.4g voxel edges here, not %g: a step "
            "may not pass over a cell",
            step / longest, step);
    return BRICK_OK;
}

int vr_march_draw(struct vr_march *m, struct vr_frame *frame, const struct vr_march_pass *passes,
                  size_t count, struct brick_image *image, struct vr_report *report, struct brick_error *err)
{
    const struct brick_level *level = frame->level;
    struct round round = {.passes = passes, .count = count};
    if (frame->quality->classification == VR_CLASSIFY_PRE)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "this method classifies values, not voxels");
    int result = frame->prefixes ? check_step(frame, err) : BRICK_OK;
    if (!result)
        result = rays_resize(&m->rays, frame->context, image, uses_depth(&round),
                             level->bricks[0] * level->bricks[1] * level->bricks[2], err);
    if (!result && (frame->deadline_ns != UINT64_MAX || frame->upload_bytes != UINT64_MAX))
        result = vr_residency_stand_in(frame->residency, err);
    if (!frame->begun) {
        m->part = 0;
        m->resume = false;
    }
    const uint64_t before = loaded_bytes(frame);
    if (!result)
        result = begin_round(m, frame, &m->rays, false, &round, err);
    while (!result && frame->final && m->part < part_count(image)) {
        result = draw_part(m, frame, &round, before, image, report, err);
        m->part += frame->final;
    }
    if (!result && !frame->final)
        result = look(m, frame, image, err);
    frame->context->gl.UseProgram(0);
    return result;
}

void vr_march_finish(struct vr_march *m, struct vr_context *context)
{
    rays_finish(&m->rays, context);
    rays_finish(&m->look, context);
    vr_bounds_finish(&m->bounds, context);
}
