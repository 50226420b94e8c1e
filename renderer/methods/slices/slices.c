/* Direct volume rendering by slices (Wilson, Van Gelder and Wilhelms, "Direct Volume Rendering via 3D
 * Textures", 1994): planes of one depth each, spread over the volume's diagonal, each blended into the
 * picture with what the field within its thickness emits and absorbs.
 *
 * Bricks are drawn in depth order, each with its part of every slice, in batches that the atlas holds (the
 * paper's subvolumes, section 2.2.5). Of a pixel's samples that lie in a brick all come in one go, and one
 * after the other along the ray, so every pixel blends the same samples in the same order whatever the
 * bricks, boxes and batches: the picture has the same bytes for all sizes of them.
 *
 * Front to back, drawing pauses after every SLICES_A_STOP slices, counted from the front of the stack, and
 * pixels that have become opaque are taken out. Since it is counted in slices, and pixels are stopped nowhere
 * else, this, too, is the same for all sizes. What is hidden behind pixels that have been stopped is neither
 * loaded nor drawn. */
#include "method.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "palette.h"
#include "parts.h"
#include "picture.h"
#include "shaders.h"
#include "sheets.h"
#include "stack.h"

#define PART_EDGE       2048 /* of what is drawn in one go; a larger picture is drawn in parts */
#define SLICES_A_STOP   32
#define VERTICES_A_DRAW (1 << 18)

/* Kept from picture to picture. */
struct slices {
    struct vr_palette palette; /* of pre-classified voxels */
    struct vr_sheets sheets;
    struct vr_parts parts;
    struct brick_slices {
        int first, last;
    } * ranges;      /* of the bricks in order */
    uint32_t *shell; /* bricks that have a part in the slices at hand */
    size_t brick_room;
    GLuint query;
};

/* A part of the picture on its way. */
struct sweep {
    struct slices *s;
    struct vr_frame *frame;
    const struct vr_stack *stack;
    const struct vr_uniforms *uniforms;
    struct vr_picture *picture;
    struct vr_window window;
    const uint32_t *order;
    size_t bricks;
    bool far_first, stops; /* pixels are stopped on the way */
    bool begun;            /* and some may have been */
    struct vr_report *report;
};

static int reserve(struct slices *s, const struct vr_frame *frame, size_t bricks, struct brick_error *err)
{
    if (!s->query)
        frame->context->gl.GenQueries(1, &s->query);
    if (bricks > s->brick_room) {
        free(s->ranges);
        free(s->shell);
        s->ranges = malloc(bricks * sizeof *s->ranges);
        s->shell = malloc(bricks * sizeof *s->shell);
        s->brick_room = s->ranges && s->shell ? bricks : 0;
    }
    if (bricks > s->brick_room)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the slices of %zu bricks", bricks);
    return BRICK_OK;
}

/* Is anything of the brick to be seen between two slices, both included? */
static bool brick_shows(const struct sweep *w, uint32_t brick, int first, int last)
{
    struct vr_stack_box box;
    vr_parts_whole(w->frame, w->stack, brick, &box);
    if (box.around_eye)
        return true;
    double polygon[VR_OUTLINE_MAX][2], from[2] = {INFINITY, INFINITY}, to[2] = {-INFINITY, -INFINITY};
    const struct vr_stack *stack = w->stack;
    int n = vr_outline(box.corners, stack->perspective,
                       fmax(stack->first_mm + first * stack->spacing_mm, stack->near_mm),
                       stack->first_mm + (last + 1) * stack->spacing_mm, &w->window, polygon);
    for (int i = 0; i < n; i++)
        for (int a = 0; a < 2; a++) {
            from[a] = fmin(from[a], polygon[i][a] - w->window.low[a]);
            to[a] = fmax(to[a], polygon[i][a] - w->window.low[a]);
        }
    return n && (!w->begun || vr_picture_open(w->picture, from, to));
}

/* A brick's part of slices first to last: slice by slice, for boxes have no order but slices have. */
static int add_brick(const struct sweep *w, uint32_t brick, int first, int last, struct brick_error *err)
{
    struct slices *s = w->s;
    const struct vr_parts *parts = &s->parts;
    double polygon[VR_OUTLINE_MAX][2];
    int result = vr_parts_find(&s->parts, w->frame, w->stack, brick, &s->sheets, err);
    for (int i = 0; i <= last - first; i++) {
        const int k = w->far_first ? last - i : first + i;
        for (size_t b = 0; b < parts->count && !result; b++) {
            if (k < parts->boxes[b].first || k > parts->boxes[b].last)
                continue;
            int n = vr_stack_outline(w->stack, &parts->boxes[b], k, &w->window, polygon);
            for (int v = 0; v < n; v++)
                for (int a = 0; a < 2; a++)
                    polygon[v][a] -= w->window.low[a];
            if (n)
                result = vr_sheets_add(&s->sheets, parts->numbers[b], k, polygon, n, err);
        }
    }
    return result;
}

static int draw_sheets(const struct sweep *w, struct brick_error *err)
{
    vr_atlas_use(vr_residency_atlas(w->frame->residency), w->frame->context, VR_UNIT_ATLAS);
    return vr_sheets_draw(&w->s->sheets, w->frame->context, VR_UNIT_SHEETS, err);
}

/* Slices first to last of all bricks, as many bricks at a time as there are slots. */
static int draw_shell(const struct sweep *w, int first, int last, struct brick_error *err)
{
    struct slices *s = w->s;
    const size_t slots = vr_residency_atlas(w->frame->residency)->count;
    size_t n = 0;
    int result = BRICK_OK;
    for (size_t i = 0; i < w->bricks; i++)
        if (s->ranges[i].first <= last && s->ranges[i].last >= first &&
            brick_shows(w, w->order[i], first, last))
            s->shell[n++] = w->order[i];
    for (size_t i = 0; i < n && !result; i += slots) {
        const size_t batch = n - i < slots ? n - i : slots;
        result = vr_residency_hold(w->frame->residency, s->shell + i, batch, w->far_first, err);
        for (size_t b = 0; b < batch && !result; b++) {
            result = add_brick(w, s->shell[i + b], first, last, err);
            if (!result && s->sheets.vertices > VERTICES_A_DRAW)
                result = draw_sheets(w, err);
        }
        if (!result)
            result = draw_sheets(w, err);
        w->report->passes++;
    }
    return result;
}

/* All slices of a part of the picture. */
static int draw_slices(struct sweep *w, struct brick_error *err)
{
    const struct vr_gl *gl = &w->frame->context->gl;
    const double termination = w->frame->quality->termination;
    const int count = w->stack->count, shell = w->stops ? SLICES_A_STOP : count;
    const double everything[2][2] = {{0.0, 0.0}, {w->picture->colour.width, w->picture->colour.height}};
    int result = BRICK_OK;
    w->begun = false;
    for (int k = 0; k < count && !result; k += shell) {
        GLuint64 samples = 0;
        gl->BeginQuery(GL_SAMPLES_PASSED, w->s->query);
        result = draw_shell(w, k, k + shell < count ? k + shell - 1 : count - 1, err);
        gl->EndQuery(GL_SAMPLES_PASSED);
        if (!result && w->stops && k + shell < count) {
            result = vr_picture_stop(w->picture, w->frame, termination, err);
            gl->UseProgram(w->uniforms->program);
            w->begun = true;
        }
        gl->GetQueryObjectui64v(w->s->query, GL_QUERY_RESULT, &samples);
        w->report->samples += w->stack->slabs ? 2 * samples : samples;
        if (w->begun && !result && !vr_picture_open(w->picture, everything[0], everything[1]))
            break;
    }
    w->s->sheets.vertices = w->s->sheets.boxes = 0;
    return result;
}

static int use_program(const struct vr_frame *frame, const struct vr_stack *stack, struct vr_uniforms *u,
                       struct brick_error *err)
{
    static const struct vr_shader_part vertex = {"slices.vert.glsl", vr_shader_slices_vert};
    static const struct vr_shader_part parts[] = {
        {"exponential.glsl", vr_shader_exponential},
        {"field.glsl", vr_shader_field},
        {"transfer.glsl", vr_shader_transfer},
        {"preintegrated.glsl", vr_shader_preintegrated},
        {"shading.glsl", vr_shader_shading},
        {"slices_stack.glsl", vr_shader_slices_stack},
        {"slices_place.glsl", vr_shader_slices_place},
        {"slices_slab.glsl", vr_shader_slices_slab},
        {"slices.glsl", vr_shader_slices},
    };
    static const struct vr_program_source source = {.vertex = &vertex,
                                                    .vertex_count = 1,
                                                    .fragment = parts,
                                                    .fragment_count = sizeof parts / sizeof *parts};
    char defines[VR_FRAME_DEFINES_BYTES + 128];
    size_t n = vr_frame_defines(frame, defines);
    snprintf(defines + n, sizeof defines - n, "%s%s%s%s", stack->perspective ? "#define PERSPECTIVE\n" : "",
             frame->quality->slices.interpolation == VR_INTERPOLATION_POINT ? "#define POINT\n" : "",
             frame->scene->transfer->emission == BRICK_EMISSION_INDEPENDENT ? "#define INDEPENDENT\n" : "",
             frame->quality->classification == VR_CLASSIFY_PRE ? "#define PRECLASSIFIED\n" : "");
    return vr_frame_use_program(frame, &source, defines, u, err);
}

static int set_uniforms(const struct vr_frame *frame, const struct vr_stack *stack,
                        const struct vr_uniforms *u, struct brick_error *err)
{
    const struct brick_view *v = &frame->view;
    double world[3][3];
    for (int i = 0; i < 3; i++) {
        const double *row = v->linear[i];
        world[0][i] = row[0] * v->dir[0] + row[1] * v->dir[1] + row[2] * v->dir[2];
        world[1][i] = row[0] * v->dir_u[0] + row[1] * v->dir_u[1] + row[2] * v->dir_u[2];
        world[2][i] = row[0] * v->dir_v[0] + row[1] * v->dir_v[1] + row[2] * v->dir_v[2];
    }
    vr_frame_set_field(frame, u);
    vr_frame_set_shading(frame, u);
    vr_set_vec3(u, "world", world[0]);
    vr_set_vec3(u, "world_u", world[1]);
    vr_set_vec3(u, "world_v", world[2]);
    vr_set_float(u, "spacing_mm", stack->spacing_mm);
    vr_set_float(u, "per_unit", 1.0 / frame->scene->transfer->unit_mm);
    vr_set_int(u, "spans", VR_UNIT_SPANS);
    vr_set_int(u, "colours", VR_UNIT_ATLAS);
    vr_set_int(u, "vertices", VR_UNIT_SHEETS);
    vr_set_int(u, "boxes", VR_UNIT_SHEETS + 1);
    return vr_frame_set_transfer(frame, u, err);
}

/* Blending: over what is behind, under what is in front, or the larger. */
static void set_blending(const struct vr_frame *frame)
{
    const struct vr_gl *gl = &frame->context->gl;
    gl->Enable(GL_BLEND);
    gl->BlendEquation(frame->scene->mode == BRICK_MODE_MIP ? GL_MAX : GL_FUNC_ADD);
    if (frame->quality->slices.back_to_front)
        gl->BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    else
        gl->BlendFunc(GL_ONE_MINUS_DST_ALPHA, GL_ONE);
}

/* The part whose corner is at pixel x, y, w.window's size, into image. */
static int draw_part(struct sweep *w, int x, int y, struct brick_image *image, struct brick_error *err)
{
    struct vr_frame *frame = w->frame;
    const struct vr_uniforms *u = w->uniforms;
    const struct vr_gl *gl = &frame->context->gl;
    const bool mip = frame->scene->mode == BRICK_MODE_MIP;
    const int width = (int)(w->window.high[0] - w->window.low[0]);
    const int height = (int)(w->window.high[1] - w->window.low[1]);
    struct vr_picture *picture = w->picture;
    int result = vr_picture_begin(picture, frame, w->stack, x, y, mip ? -INFINITY : 0.0f, err);
    if (result)
        return result;
    gl->UseProgram(u->program);
    vr_picture_set_stack(frame, w->stack, u, x, y);
    const double to_clip[2] = {2.0 / picture->colour.width, 2.0 / picture->colour.height};
    gl->Uniform2f(gl->GetUniformLocation(u->program, "pixel_to_clip"), (float)to_clip[0], (float)to_clip[1]);
    set_blending(frame);
    result = draw_slices(w, err);
    gl->Disable(GL_BLEND);
    gl->Disable(GL_DEPTH_TEST);
    if (!result && mip)
        result = vr_picture_classify(picture, frame, err);
    else if (!result)
        vr_canvas_read(&picture->colour, frame->context, picture->colour.width, picture->colour.height,
                       picture->rgba, picture->colour.width);
    for (int row = 0; row < height && !result; row++)
        memcpy(image->rgba + 4 * ((size_t)(y + row) * image->width + (size_t)x),
               picture->rgba + 4 * (size_t)row * (size_t)picture->colour.width,
               4 * (size_t)width * sizeof *image->rgba);
    return result;
}

static int check(const struct vr_frame *frame, struct brick_error *err)
{
    const struct vr_slices *q = &frame->quality->slices;
    if (frame->scene->mode == BRICK_MODE_ISO)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "slices show no isosurfaces: use the methods raycast, isotrace or exact");
    if ((unsigned)q->interpolation > VR_INTERPOLATION_POINT || (unsigned)q->framebuffer > VR_FRAMEBUFFER_32F)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "no interpolation %d or no framebuffer %d",
                          (int)q->interpolation, (int)q->framebuffer);
    if (frame->prefixes && frame->scene->transfer->emission == BRICK_EMISSION_INDEPENDENT)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "pre-integrated classification is for emission scaled by extinction");
    if (frame->quality->classification == VR_CLASSIFY_PRE && frame->scene->mode != BRICK_MODE_DVR)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "pre-classified voxels have colours, but no gradients or values: mode dvr only");
    if (q->classified_bits != 8 && q->classified_bits != 16 && q->classified_bits != 32)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "pre-classified voxels of %u bits; there are 8, 16 and 32",
                          q->classified_bits);
    return BRICK_OK;
}

/* What slots hold depends on the slices' spacing, too (section 2.1.1). */
static int find_texels(void *state, const struct vr_frame *frame, const struct vr_texels **texels,
                       struct brick_error *err)
{
    struct slices *s = state;
    const struct vr_quality *q = frame->quality;
    struct vr_stack stack;
    int result = check(frame, err);
    if (result || (result = vr_stack_init(&stack, frame, q->slices.planes, err)) ||
        q->classification != VR_CLASSIFY_PRE ||
        (result = vr_palette_set(&s->palette, frame, stack.spacing_mm, q->slices.classified_bits, err)))
        return result;
    *texels = &s->palette.texels;
    return BRICK_OK;
}

static int draw(void *state, struct vr_frame *frame, struct brick_image *image, struct vr_report *report,
                struct brick_error *err)
{
    static const GLenum formats[] = {GL_RGBA8, GL_RGBA16F, GL_RGBA32F};
    struct slices *s = state;
    const struct vr_quality *quality = frame->quality;
    const bool mip = frame->scene->mode == BRICK_MODE_MIP, far_first = quality->slices.back_to_front;
    const int width = (int)image->width, height = (int)image->height;
    const int tw = width < PART_EDGE ? width : PART_EDGE, th = height < PART_EDGE ? height : PART_EDGE;
    struct vr_picture picture = {0};
    struct vr_stack stack;
    struct vr_uniforms u;
    struct sweep w = {.s = s,
                      .frame = frame,
                      .stack = &stack,
                      .uniforms = &u,
                      .picture = &picture,
                      .far_first = far_first,
                      .stops = quality->termination > 0.0 && !far_first && !mip,
                      .report = report};
    int result = vr_stack_init(&stack, frame, quality->slices.planes, err);
    if (!result && stack.slabs && frame->scene->mode == BRICK_MODE_SHADED)
        result = vr_residency_touching(frame->residency, err);
    if (result || (result = use_program(frame, &stack, &u, err)) ||
        (result = vr_residency_order(frame->residency, far_first, &w.order, &w.bricks, err)) ||
        (result = reserve(s, frame, w.bricks, err)))
        return result;
    for (size_t i = 0; i < w.bricks; i++) {
        struct vr_stack_box box;
        vr_parts_whole(frame, &stack, w.order[i], &box);
        s->ranges[i] = (struct brick_slices){box.first, box.last};
    }
    frame->context->gl.UseProgram(u.program);
    result = set_uniforms(frame, &stack, &u, err);
    if (!result)
        result = vr_picture_init(&picture, frame->context,
                                 mip ? GL_R32F : formats[quality->slices.framebuffer], tw, th, err);
    for (int y = 0; !result && y < height; y += th)
        for (int x = 0; !result && x < width; x += tw) {
            w.window = (struct vr_window){
                {x, y}, {x + tw < width ? x + tw : width, y + th < height ? y + th : height}};
            result = draw_part(&w, x, y, image, err);
        }
    vr_picture_finish(&picture, frame->context);
    frame->context->gl.UseProgram(0);
    return result;
}

static void finish(void *state, struct vr_context *context)
{
    struct slices *s = state;
    vr_sheets_finish(&s->sheets, context);
    vr_palette_finish(&s->palette);
    vr_parts_finish(&s->parts);
    if (s->query)
        context->gl.DeleteQueries(1, &s->query);
    free(s->ranges);
    free(s->shell);
}

const struct vr_method_row vr_slices = {.state_bytes = sizeof(struct slices),
                                        .draw = draw,
                                        .finish = finish,
                                        .texels = find_texels,
                                        .filters = true,
                                        .clips = true,
                                        .independent = true};
