/* Shader programs from sources built into the library. */
#ifndef RENDERER_GPU_PROGRAM_H
#define RENDERER_GPU_PROGRAM_H

#include "context.h"

/* A piece of shader text; a stage is several in a row. */
struct vr_shader_part {
    const char *name; /* for messages */
    const char *text;
};

#define VR_PROGRAM_MAX_PARTS 16

/* What a program is made of, up to VR_PROGRAM_MAX_PARTS each, in order. */
struct vr_program_source {
    const struct vr_shader_part *vertex; /* NULL: one triangle over the whole viewport, drawn as 3 vertices */
    int vertex_count;
    const struct vr_shader_part *fragment;
    int fragment_count;
};

/* Both stages have `defines` (lines of #define, may be "") and their parts, in order, after "#version 430
 * core". The context is bound. BRICK_ERR_UNSUPPORTED with the part's name and the first line of the
 * compiler's log. */
int vr_program_create(struct vr_context *context, const char *defines, const struct vr_program_source *source,
                      GLuint *program, struct brick_error *err);

#endif
