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

/* A fragment program over the whole viewport: `defines` (lines of #define, may be "") and the parts, in
 * order, after
 * "#version 430 core". The context is bound. BRICK_ERR_UNSUPPORTED with the part's name and the first line of
 * the compiler's log. */
int vr_program_create(struct vr_context *context, const char *defines, const struct vr_shader_part *parts,
                      int count, GLuint *program, struct brick_error *err);

#endif
