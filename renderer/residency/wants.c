/* From two bits a brick to a sorted list. */
#include "wants.h"

#include <stdlib.h>
#include <string.h>

int vr_wants_reserve(struct vr_wants *w, size_t n, struct brick_error *err)
{
    if (n <= w->room)
        return BRICK_OK;
    size_t room = n > 2 * w->room ? n : 2 * w->room;
    struct vr_want *item = realloc(w->item, room * sizeof *item);
    if (!item)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of %zu bricks", room);
    w->item = item;
    w->room = room;
    return BRICK_OK;
}

void vr_wants_finish(struct vr_wants *w)
{
    free(w->item);
    *w = (struct vr_wants){0};
}

static int nearer(const void *a, const void *b)
{
    const struct vr_want *p = a, *q = b;
    if (p->distance != q->distance)
        return p->distance < q->distance ? -1 : 1;
    return (p->brick > q->brick) - (p->brick < q->brick);
}

void vr_wants_sort(struct vr_wants *w, size_t n)
{
    if (n)
        qsort(w->item, n, sizeof *w->item, nearer);
}

static void needed_first(struct vr_wants *w, size_t n)
{
    size_t i = 0;
    while (i < n && !w->item[i].needed)
        i++;
    if (i == n)
        return;
    const struct vr_want first = w->item[i];
    memmove(w->item + 1, w->item, i * sizeof first);
    w->item[0] = first;
}

int vr_wants_gather(struct vr_wants *w, const struct vr_feedback *feedback, const struct vr_depth *depth,
                    size_t *count, struct brick_error *err)
{
    size_t n = 0;
    for (uint64_t i = 0; i < (feedback->bricks + 15) / 16; i++) {
        uint32_t word = feedback->words[feedback->tiles + i];
        for (uint32_t b = (uint32_t)(16 * i); word; b++, word >>= 2) {
            if (!(word & 3))
                continue;
            int result = vr_wants_reserve(w, n + 1, err);
            if (result)
                return result;
            w->item[n++] = (struct vr_want){vr_depth_of(depth, b), b, word & VR_FEEDBACK_NEEDED};
        }
    }
    vr_wants_sort(w, n);
    needed_first(w, n);
    *count = n;
    return BRICK_OK;
}
