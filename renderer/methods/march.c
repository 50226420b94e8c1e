/* Passes and parts. All that a pass leaves is in the target's words, so nothing here knows what a method does
 * in one. */
#include "march.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <brick/threads.h>

#define TARGET_EDGE      1024
#define MAX_REFINEMENTS  96 /* bits of a ray's path; see state.glsl */
#define LOOK_AHEAD_TURNS 256
#define MAX_LOOK_AHEAD   64
#define TILES_ACROSS     (TARGET_EDGE / VR_TARGET_TILE)
#define TILES            (TILES_ACROSS * TILES_ACROSS)

enum { IMAGE_STATE, IMAGE_PROGRESS, IMAGE_FEEDBACK };

static int use_program(const struct vr_frame *frame, const struct vr_program_source *source, const char *own,
                       struct vr_uniforms *uniforms, struct brick_error *err)
{
    char defines[VR_FRAME_DEFINES_BYTES + 256];
    size_t n = vr_frame_defines(frame, defines);
    snprintf(defines + n, sizeof defines - n, "#define LOOK_AHEAD_TURNS %d\n#define TILE_EDGE %d\n%s",
             LOOK_AHEAD_TURNS, VR_TARGET_TILE, own);
    uniforms->gl = &frame->context->gl;
    int result =
        vr_programs_get(&frame->store->programs, frame->context, source, defines, &uniforms->program, err);
    if (!result)
        uniforms->gl->UseProgram(uniforms->program);
    return result;
}

static void set_surface(const struct vr_frame *frame, const struct vr_uniforms *u)
{
    const struct vr_scene *scene = frame->scene;
    const struct vr_quality *quality = frame->quality;
    double rgb[3] = {scene->iso_rgb[0], scene->iso_rgb[1], scene->iso_rgb[2]}, sigma;
    uint32_t refinements = quality->refinements < 64 ? quality->refinements : 64;
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
 * asking further gains nothing. */
static int choose_ahead(int ahead, uint64_t wanted, uint64_t slots)
{
    if (wanted <= slots / 2)
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
                       const struct brick_image *image, uint64_t bricks, struct brick_error *err)
{
    const struct part first = part_of(image, 0);
    if (rays->target.width != first.width || rays->target.height != first.height) {
        vr_target_finish(&rays->target, context);
        int result = vr_target_init(&rays->target, context, first.width, first.height, err);
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

static void all_unfinished(struct vr_march_rays *rays)
{
    for (uint32_t t = 0; t < TILES; t++)
        rays->feedback.words[t] = 1;
}

static int set_scene(const struct vr_frame *frame, const struct vr_march_rays *rays,
                     const struct vr_uniforms *u, struct brick_error *err)
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
    vr_target_use(&rays->target, frame->context, IMAGE_STATE, IMAGE_PROGRESS);
    vr_buffer_use_image(&rays->feedback.buffer, frame->context, IMAGE_FEEDBACK);
    return BRICK_OK;
}

/* All unfinished rays of a part once. *unfinished: some still are. */
static int pass(struct vr_march_rays *rays, const struct vr_frame *frame, const struct vr_uniforms *u,
                const struct part *part, bool resume, bool *unfinished, struct brick_error *err)
{
    struct vr_feedback *feedback = &rays->feedback;
    vr_set_ivec2(u, "tile_origin", part->x, part->y);
    vr_set_int(u, "resume", resume);
    vr_atlas_use(vr_residency_atlas(frame->residency), frame->context, VR_UNIT_ATLAS);
    vr_feedback_clear(feedback, frame->context);
    vr_target_draw(&rays->target, frame->context, part->width, part->height, feedback->words, TILES_ACROSS);
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

/* Meshes of a part, if there are any, before its rays; then back to the program of u. */
static int draw_meshes(const struct vr_frame *frame, const struct vr_uniforms *u, const struct part *part,
                       struct brick_error *err)
{
    if (!frame->scene->mesh_count)
        return BRICK_OK;
    int result = vr_meshes_draw(frame, part->x, part->y, err);
    u->gl->UseProgram(u->program);
    vr_meshes_use(frame, u);
    return result;
}

/* The part in work, pass after pass, until all its rays have ended or the budget is used up. before: bytes
 * loaded before this call. */
static int draw_part(struct vr_march *m, struct vr_frame *frame, const struct vr_uniforms *u, uint64_t before,
                     struct brick_image *image, struct vr_report *report, struct brick_error *err)
{
    const struct vr_atlas *atlas = vr_residency_atlas(frame->residency);
    const struct part part = part_of(image, m->part);
    if (!m->resume) {
        all_unfinished(&m->rays);
        m->ahead = 1;
    }
    int result = draw_meshes(frame, u, &part, err);
    if (result)
        return result;
    for (;;) {
        bool unfinished;
        uint64_t wanted;
        vr_set_int(u, "look_ahead", m->ahead);
        result = pass(&m->rays, frame, u, &part, m->resume, &unfinished, err);
        report->passes++;
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
}

/* What is not final yet, as far as it can be seen by what is in the GPU cache. */
static int look(struct vr_march *m, const struct vr_frame *frame, const struct vr_program_source *source,
                const char *defines, struct brick_image *image, struct brick_error *err)
{
    const uint64_t start_ns = brick_now_ns();
    struct vr_uniforms u;
    char stand_in[256];
    uint64_t samples = 0;
    snprintf(stand_in, sizeof stand_in, "#define STAND_IN %d\n#undef PREINTEGRATED\n%s", BRICK_MAX_LEVELS,
             defines);
    int result = rays_resize(&m->look, frame->context, image, 0, err);
    if (result || (result = use_program(frame, source, stand_in, &u, err)) ||
        (result = set_scene(frame, &m->look, &u, err)))
        return result;
    vr_frame_set_stand_ins(frame, &u);
    for (int p = m->part; p < part_count(image) && !result; p++) {
        const struct part part = part_of(image, p);
        bool resume = p == m->part && m->resume, unfinished = true;
        all_unfinished(&m->look);
        if (resume) {
            memcpy(m->look.feedback.words, m->rays.feedback.words, TILES * sizeof *m->look.feedback.words);
            vr_target_copy(&m->look.target, frame->context, &m->rays.target, part.width, part.height);
        }
        result = draw_meshes(frame, &u, &part, err);
        while (!result && unfinished) {
            result = pass(&m->look, frame, &u, &part, resume, &unfinished, err);
            resume = true;
        }
        if (!result)
            result = read_part(&m->look, frame, &part, image, &samples, err);
    }
    m->look_ns = brick_now_ns() - start_ns;
    return result;
}

int vr_march_draw(struct vr_march *m, struct vr_frame *frame, const struct vr_program_source *source,
                  const char *defines, struct brick_image *image, struct vr_report *report,
                  struct brick_error *err)
{
    const struct brick_level *level = frame->level;
    struct vr_uniforms u = {.gl = &frame->context->gl};
    int result = rays_resize(&m->rays, frame->context, image,
                             level->bricks[0] * level->bricks[1] * level->bricks[2], err);
    if (!result && (frame->deadline_ns != UINT64_MAX || frame->upload_bytes != UINT64_MAX))
        result = vr_residency_stand_in(frame->residency, err);
    if (!result && frame->scene->mesh_count)
        result = vr_meshes_begin(frame, m->rays.target.width, m->rays.target.height, err);
    if (!frame->begun) {
        m->part = 0;
        m->resume = false;
    }
    const uint64_t before = loaded_bytes(frame);
    if (!result && !(result = use_program(frame, source, defines, &u, err)))
        result = set_scene(frame, &m->rays, &u, err);
    while (!result && frame->final && m->part < part_count(image)) {
        result = draw_part(m, frame, &u, before, image, report, err);
        m->part += frame->final;
    }
    if (!result && !frame->final)
        result = look(m, frame, source, defines, image, err);
    u.gl->UseProgram(0);
    return result;
}

void vr_march_finish(struct vr_march *m, struct vr_context *context)
{
    rays_finish(&m->rays, context);
    rays_finish(&m->look, context);
}
