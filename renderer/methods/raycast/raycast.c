/* The raycaster's host side: a program that models only what the scene needs, its uniforms, and the picture
 * in parts no larger than a target. */
#include "raycast.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "program.h"
#include "shaders.h"
#include "target.h"
#include "transfer_table.h"

#define TARGET_EDGE 1024
/* What a ray does in one pass, bounded so that 16 rays at once stay below the 65535 turns of loops that
 * llvmpipe allows: 2 loops of samples and leaps, halvings at a hit, leaps to look ahead. */
#define STEPS_A_PASS     1500
#define MAX_REFINEMENTS  96 /* bits of a ray's path; see raycast.glsl */
#define LOOK_AHEAD_TURNS 256
#define MAX_LOOK_AHEAD   64
/* Samples a ray: they are counted in 32 bits. */
#define MAX_SAMPLES 2147483648.0

enum { UNIT_ATLAS, UNIT_PAGES, UNIT_MACROCELLS, UNIT_PIECES, UNIT_BINS };
enum { IMAGE_STATE, IMAGE_PROGRESS, IMAGE_FEEDBACK };

static int get_program(struct vr_raycast *r, struct vr_context *context, const struct brick_volume *volume,
                       enum brick_mode mode, bool skip, uint32_t search_steps, GLuint *out,
                       struct brick_error *err)
{
    static const char *const modes[] = {"MODE_DVR", "MODE_SHADED", "MODE_ISO", "MODE_MIP"};
    static const char *const samplers[BRICK_TYPE_STORED_COUNT] = {
        [BRICK_U8] = "usampler3D",  [BRICK_I8] = "isampler3D", [BRICK_U16] = "usampler3D",
        [BRICK_I16] = "isampler3D", [BRICK_F32] = "sampler3D",
    };
    static const struct vr_shader_part parts[] = {
        {"exponential.glsl", vr_shader_exponential},
        {"fixed.glsl", vr_shader_fixed},
        {"ray.glsl", vr_shader_ray},
        {"field.glsl", vr_shader_field},
        {"transfer.glsl", vr_shader_transfer},
        {"shading.glsl", vr_shader_shading},
        {"feedback.glsl", vr_shader_feedback},
        {"raycast.glsl", vr_shader_raycast},
    };
    char defines[512];
    GLuint *program = &r->programs[mode][skip].name;
    *out = *program;
    if (*program && r->programs[mode][skip].search_steps == search_steps)
        return BRICK_OK;
    if (*program)
        context->gl.DeleteProgram(*program);
    snprintf(defines, sizeof defines,
             "#define MODE_DVR 0\n#define MODE_SHADED 1\n#define MODE_ISO 2\n#define MODE_MIP 3\n"
             "#define MODE %s\n#define VOXEL_SAMPLER %s\n#define SEARCH_STEPS %u\n#define STEPS_A_PASS %d\n"
             "#define LOOK_AHEAD_TURNS %d\n#define TILE_EDGE %d\n%s%s",
             modes[mode], samplers[brick_volume_grid(volume)->type], search_steps, STEPS_A_PASS,
             LOOK_AHEAD_TURNS, VR_TARGET_TILE, skip ? "#define SKIP\n" : "",
             brick_volume_stats(volume)->nonfinite ? "#define NONFINITE\n" : "");
    int result =
        vr_program_create(context, defines, parts, (int)(sizeof parts / sizeof *parts), program, err);
    *out = *program;
    r->programs[mode][skip].search_steps = search_steps;
    return result;
}

void vr_raycast_finish(struct vr_raycast *raycast, struct vr_context *context)
{
    for (int m = 0; m < 4; m++)
        for (int s = 0; s < 2; s++)
            if (raycast->programs[m][s].name)
                context->gl.DeleteProgram(raycast->programs[m][s].name);
    vr_buffer_finish(&raycast->pieces, context);
    vr_buffer_finish(&raycast->bins, context);
    vr_feedback_finish(&raycast->feedback, context);
    *raycast = (struct vr_raycast){0};
}

/* Uniforms by name; those a program does not use have location -1, which OpenGL ignores. */
struct setter {
    const struct vr_gl *gl;
    GLuint program;
};

static GLint at(const struct setter *s, const char *name)
{
    return s->gl->GetUniformLocation(s->program, name);
}

static void set_dvec3(const struct setter *s, const char *name, const double v[3])
{
    s->gl->Uniform3dv(at(s, name), 1, v);
}

static void set_ivec3(const struct setter *s, const char *name, const int v[3])
{
    s->gl->Uniform3iv(at(s, name), 1, v);
}

static void set_float(const struct setter *s, const char *name, double v)
{
    s->gl->Uniform1f(at(s, name), (float)v);
}

static int log2_of(uint32_t power)
{
    int n = 0;
    while (power > 1)
        power >>= 1, n++;
    return n;
}

static void set_rays(const struct setter *s, const struct brick_grid *grid, const struct brick_level *level,
                     const struct brick_view *view, double step_mm)
{
    double box_high[3];
    for (int a = 0; a < 3; a++)
        box_high[a] = (double)grid->dims[a] - 0.5;
    set_dvec3(s, "origin", view->origin);
    set_dvec3(s, "origin_u", view->origin_u);
    set_dvec3(s, "origin_v", view->origin_v);
    set_dvec3(s, "dir", view->dir);
    set_dvec3(s, "dir_u", view->dir_u);
    set_dvec3(s, "dir_v", view->dir_v);
    s->gl->UniformMatrix3dv(at(s, "linear"), 1, GL_TRUE, &view->linear[0][0]);
    set_dvec3(s, "box_high", box_high);
    set_dvec3(s, "level_scale", level->scale);
    set_dvec3(s, "level_offset", level->offset);
    s->gl->Uniform1d(at(s, "step_mm"), step_mm);
}

static void set_field(const struct setter *s, const struct brick_grid *grid, const struct brick_level *level,
                      const struct vr_residency *residency)
{
    const struct vr_atlas *atlas = vr_residency_atlas(residency);
    const struct vr_macrocells *macrocells = vr_residency_macrocells(residency);
    int last[3], bricks[3];
    for (int a = 0; a < 3; a++) {
        last[a] = (int)level->dims[a] - 1;
        bricks[a] = (int)level->bricks[a];
    }
    set_ivec3(s, "level_last", last);
    set_ivec3(s, "level_bricks", bricks);
    set_ivec3(s, "slots", atlas->slots);
    set_ivec3(s, "slot_size", atlas->slot_size);
    set_ivec3(s, "slot_cells", macrocells->cells);
    s->gl->Uniform1i(at(s, "plane_words"), macrocells->plane_words);
    s->gl->Uniform1i(at(s, "brick_shift"), log2_of(grid->edge));
    s->gl->Uniform1i(at(s, "macro_shift"), log2_of(grid->macrocell));
    s->gl->Uniform1i(at(s, "border"), (int)grid->border);
    s->gl->Uniform1i(at(s, "atlas"), UNIT_ATLAS);
    s->gl->Uniform1i(at(s, "pages"), UNIT_PAGES);
    s->gl->Uniform1i(at(s, "macrocells"), UNIT_MACROCELLS);
    set_float(s, "value_sign", grid->slope < 0.0 ? -1.0 : 1.0);
}

/* Gradient in the level's index space to world: the inverse of (affine's linear part x level scale),
 * transposed. */
static void set_shading(const struct setter *s, const struct brick_grid *grid,
                        const struct brick_level *level, const struct vr_scene *scene)
{
    double inverse[3][4];
    float matrix[9], material[4] = {(float)scene->ambient, (float)scene->diffuse, (float)scene->specular,
                                    (float)scene->shininess};
    double largest = 0.0;
    brick_affine_invert(grid->affine, inverse);
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs(inverse[i / 3][i % 3] / level->scale[i / 3]));
    /* Row i of the inverse is column i of its transpose, which is what column-major order wants. Only the
     * direction counts, so the largest entry is made 1. */
    for (int i = 0; i < 9; i++)
        matrix[i] = (float)(inverse[i / 3][i % 3] / level->scale[i / 3] / largest);
    s->gl->UniformMatrix3fv(at(s, "normal_matrix"), 1, GL_FALSE, matrix);
    s->gl->Uniform4fv(at(s, "material"), 1, material);
}

static int set_transfer(struct vr_raycast *r, struct vr_context *context, const struct setter *s,
                        const struct vr_transfer_table *table, struct brick_error *err)
{
    int result;
    if ((result = vr_buffer_write(&r->pieces, context, GL_RGBA32F, table->pieces,
                                  table->count * sizeof *table->pieces, "transfer function", err)) ||
        (result = vr_buffer_write(&r->bins, context, GL_RG32UI, table->bins,
                                  table->bin_count * sizeof *table->bins, "transfer function", err)))
        return result;
    vr_buffer_use(&r->pieces, context, UNIT_PIECES);
    vr_buffer_use(&r->bins, context, UNIT_BINS);
    s->gl->Uniform1i(at(s, "pieces"), UNIT_PIECES);
    s->gl->Uniform1i(at(s, "bins"), UNIT_BINS);
    set_float(s, "bin_origin", table->bin_origin);
    set_float(s, "bin_scale", table->bin_scale);
    set_float(s, "bin_last", table->bin_count - 1.0);
    return BRICK_OK;
}

static void set_surface(const struct setter *s, const struct brick_grid *grid, const struct vr_scene *scene,
                        const struct vr_quality *quality)
{
    double rgb[3] = {scene->iso_rgb[0], scene->iso_rgb[1], scene->iso_rgb[2]}, sigma;
    uint32_t refinements = quality->refinements < 64 ? quality->refinements : 64;
    if (scene->transfer)
        brick_transfer_eval(scene->transfer, scene->isovalue, rgb, &sigma);
    float colour[3] = {(float)rgb[0], (float)rgb[1], (float)rgb[2]};
    /* Samples further apart than a voxel are brought into cells that touch, whatever the refinement. */
    for (double step = quality->step_vox; step > 1.0; step /= 2.0)
        refinements++;
    if (refinements > MAX_REFINEMENTS)
        refinements = MAX_REFINEMENTS;
    s->gl->Uniform3fv(at(s, "surface"), 1, colour);
    s->gl->Uniform1ui(at(s, "refinements"), refinements);
    s->gl->Uniform1f(at(s, "isovalue"), vr_stored_threshold(grid, scene->isovalue));
}

/* Can samples and voxels be counted? */
static int check_counts(const struct brick_grid *grid, const struct brick_level *level, double step_mm,
                        struct brick_error *err)
{
    double spacing[3], longest = 0.0;
    brick_grid_spacing_mm(grid, spacing);
    for (int a = 0; a < 3; a++) {
        longest += spacing[a] * (double)grid->dims[a];
        if (level->dims[a] > INT32_MAX - 1024)
            return brick_fail(
                err, BRICK_ERR_UNSUPPORTED,
                "the level has %llu voxels on an axis, more than a shader can count: use a coarser level",
                (unsigned long long)level->dims[a]);
    }
    if (ceil(longest / step_mm) + 1.0 > MAX_SAMPLES)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "a step of %g mm makes more than 2^31 samples a ray",
                          step_mm);
    return BRICK_OK;
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

/* One part of the picture, pass after pass, until all its rays have ended. */
static int draw_part(struct vr_raycast *r, struct vr_context *context, const struct setter *s,
                     const struct vr_target *target, struct vr_residency *residency, int width, int height,
                     struct vr_report *report, struct brick_error *err)
{
    struct vr_feedback *feedback = &r->feedback;
    const int across = TARGET_EDGE / VR_TARGET_TILE;
    uint64_t wanted, slots = vr_residency_atlas(residency)->count;
    bool unfinished = true;
    int ahead = 1;
    for (uint32_t t = 0; t < feedback->tiles; t++)
        feedback->words[t] = 1;
    s->gl->Uniform1i(at(s, "resume"), GL_FALSE);
    for (;;) {
        s->gl->Uniform1i(at(s, "look_ahead"), ahead);
        vr_atlas_use(vr_residency_atlas(residency), context, UNIT_ATLAS);
        vr_feedback_clear(feedback, context);
        vr_target_draw(target, context, width, height, feedback->words, across);
        vr_feedback_read(feedback, context);
        report->passes++;
        int result = vr_context_check(context, "raycasting", err);
        if (result)
            return result;
        unfinished = false;
        for (uint32_t t = 0; t < feedback->tiles && !unfinished; t++)
            unfinished = feedback->words[t] != 0;
        if (!unfinished)
            return BRICK_OK;
        if ((result = vr_residency_bring(residency, feedback, &wanted, err)))
            return result;
        s->gl->Uniform1i(at(s, "resume"), GL_TRUE);
        ahead = choose_ahead(ahead, wanted, slots);
    }
}

/* The picture part by part through one target. */
static int draw_parts(struct vr_raycast *r, struct vr_context *context, const struct setter *s,
                      struct vr_residency *residency, struct brick_image *image, struct vr_report *report,
                      struct brick_error *err)
{
    struct vr_target target = {0};
    int width = (int)image->width, height = (int)image->height;
    int tw = width < TARGET_EDGE ? width : TARGET_EDGE, th = height < TARGET_EDGE ? height : TARGET_EDGE;
    uint32_t *progress = malloc((size_t)tw * (size_t)th * 2 * sizeof *progress);
    int result = progress ? vr_target_init(&target, context, tw, th, err)
                          : brick_fail(err, BRICK_ERR_MEMORY, "no memory for a picture of %d x %d", tw, th);
    s->gl->Uniform1i(at(s, "state_image"), IMAGE_STATE);
    s->gl->Uniform1i(at(s, "progress_image"), IMAGE_PROGRESS);
    s->gl->Uniform1i(at(s, "feedback"), IMAGE_FEEDBACK);
    s->gl->Uniform1i(at(s, "tiles_across"), TARGET_EDGE / VR_TARGET_TILE);
    s->gl->Uniform1i(at(s, "tiles"), (GLint)r->feedback.tiles);
    if (!result) {
        vr_target_use(&target, context, IMAGE_STATE, IMAGE_PROGRESS);
        vr_buffer_use_image(&r->feedback.buffer, context, IMAGE_FEEDBACK);
    }
    for (int y = 0; !result && y < height; y += th)
        for (int x = 0; !result && x < width; x += tw) {
            int w = width - x < tw ? width - x : tw, h = height - y < th ? height - y : th;
            s->gl->Uniform2i(at(s, "tile_origin"), x, y);
            if ((result = draw_part(r, context, s, &target, residency, w, h, report, err)))
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

int vr_raycast_draw(struct vr_raycast *r, struct vr_context *context, const struct brick_volume *volume,
                    struct vr_residency *residency, const struct vr_scene *scene,
                    const struct vr_quality *quality, struct brick_image *image, struct vr_report *report,
                    struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_level *level = &grid->level[scene->level];
    const struct vr_gl *gl = &context->gl;
    double step_mm = quality->step_vox * brick_grid_min_spacing_mm(grid);
    struct setter setter = {.gl = gl};
    struct vr_transfer_table table = {.search_steps = 1};
    struct brick_view view;
    int result;

    if ((result = check_counts(grid, level, step_mm, err)) ||
        (result = brick_view_init(&view, &scene->camera, grid, scene->width, scene->height, err)))
        return result;
    if (scene->mode != BRICK_MODE_ISO &&
        (result = vr_transfer_table_init(&table, scene->transfer, grid, err)))
        return result;
    if ((result = vr_feedback_resize(&r->feedback, context,
                                     (TARGET_EDGE / VR_TARGET_TILE) * (TARGET_EDGE / VR_TARGET_TILE),
                                     level->bricks[0] * level->bricks[1] * level->bricks[2], err)) ||
        (result = get_program(r, context, volume, scene->mode, quality->skip, table.search_steps,
                              &setter.program, err)))
        goto done;
    gl->UseProgram(setter.program);
    set_rays(&setter, grid, level, &view, step_mm);
    set_field(&setter, grid, level, residency);
    set_shading(&setter, grid, level, scene);
    if (scene->mode == BRICK_MODE_ISO)
        set_surface(&setter, grid, scene, quality);
    else if ((result = set_transfer(r, context, &setter, &table, err)))
        goto done;
    if (scene->mode == BRICK_MODE_MIP)
        set_float(&setter, "unit_mm", scene->transfer->unit_mm);
    /* A ray ends where exp(-depth) falls below the threshold. */
    set_float(&setter, "depth_end", quality->termination > 0.0 ? -log(quality->termination) : FLT_MAX);
    vr_buffer_use(vr_residency_pages(residency), context, UNIT_PAGES);
    vr_buffer_use(&vr_residency_macrocells(residency)->buffer, context, UNIT_MACROCELLS);
    result = draw_parts(r, context, &setter, residency, image, report, err);
done:
    gl->UseProgram(0);
    vr_transfer_table_finish(&table);
    return result;
}
