/* Programs compiled so far, one per set of features: a shader models only what a scene needs, and the next
 * picture with the same needs finds it here. */
#ifndef RENDERER_FRAME_PROGRAMS_H
#define RENDERER_FRAME_PROGRAMS_H

#include "program.h"

/* Programs of zeros are empty. */
struct vr_programs {
    struct vr_program_entry *entry;
    size_t count;
};

/* The context is bound in both. */

/* The program of `source` with these defines; compiled when it is asked for the first time. It stays the
 * programs'. */
int vr_programs_get(struct vr_programs *programs, struct vr_context *context,
                    const struct vr_program_source *source, const char *defines, GLuint *program,
                    struct brick_error *err);
void vr_programs_finish(struct vr_programs *programs, struct vr_context *context);

#endif
