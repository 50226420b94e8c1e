/* A list searched from its start: a renderer has some ten programs, and a frame asks for one or two. */
#include "programs.h"

#include <stdlib.h>
#include <string.h>

struct vr_program_entry {
    const struct vr_program_source *source; /* static data: its address is its name */
    char *defines;
    GLuint program;
};

int vr_programs_get(struct vr_programs *p, struct vr_context *context, const struct vr_program_source *source,
                    const char *defines, GLuint *program, struct brick_error *err)
{
    for (size_t i = 0; i < p->count; i++)
        if (p->entry[i].source == source && !strcmp(p->entry[i].defines, defines)) {
            *program = p->entry[i].program;
            return BRICK_OK;
        }
    struct vr_program_entry *entry = realloc(p->entry, (p->count + 1) * sizeof *entry);
    if (!entry)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for %zu programs", p->count + 1);
    p->entry = entry;
    entry += p->count;
    *entry = (struct vr_program_entry){source, strdup(defines), 0};
    if (!entry->defines)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a program");
    int result = vr_program_create(context, defines, source, &entry->program, err);
    if (result)
        free(entry->defines);
    else
        p->count++, *program = entry->program;
    return result;
}

void vr_programs_finish(struct vr_programs *p, struct vr_context *context)
{
    for (size_t i = 0; i < p->count; i++) {
        context->gl.DeleteProgram(p->entry[i].program);
        free(p->entry[i].defines);
    }
    free(p->entry);
    *p = (struct vr_programs){0};
}
