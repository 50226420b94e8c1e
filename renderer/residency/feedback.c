/* Feedback from rays. Bits in a buffer image rather than bricks in a list: whatever the number of rays that
 * want a brick, it is one bit, and the host reads a quarter byte a brick. */
#include "feedback.h"

#include <stdlib.h>

static uint64_t words_of(const struct vr_feedback *f)
{
    return f->tiles + (f->bricks + 15) / 16;
}

int vr_feedback_resize(struct vr_feedback *f, struct vr_context *context, uint32_t tiles, uint64_t bricks,
                       struct brick_error *err)
{
    if (f->tiles == tiles && f->bricks == bricks)
        return BRICK_OK;
    vr_feedback_finish(f, context);
    f->tiles = tiles;
    f->bricks = bricks;
    f->words = calloc(words_of(f), sizeof *f->words);
    int result = f->words ? vr_buffer_write(&f->buffer, context, GL_R32UI, f->words,
                                            words_of(f) * sizeof *f->words, "list of wanted bricks", err)
                          : brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of wanted bricks");
    if (result)
        vr_feedback_finish(f, context);
    return result;
}

void vr_feedback_finish(struct vr_feedback *f, struct vr_context *context)
{
    vr_buffer_finish(&f->buffer, context);
    free(f->words);
    *f = (struct vr_feedback){0};
}

void vr_feedback_clear(struct vr_feedback *f, struct vr_context *context)
{
    vr_buffer_clear(&f->buffer, context, words_of(f) * sizeof *f->words);
}

void vr_feedback_read(struct vr_feedback *f, struct vr_context *context)
{
    vr_buffer_read(&f->buffer, context, f->words, words_of(f) * sizeof *f->words);
}
