/* The order of eviction; slots that are worth the same go by number, so that it depends on nothing else. */
#include "victims.h"

#include <stdlib.h>

static int goes_first(const void *a, const void *b)
{
    const struct vr_victim *p = a, *q = b;
    if (p->worth != q->worth)
        return p->worth < q->worth ? -1 : 1;
    if (p->worth == VR_WORTH_FUTURE && p->distance != q->distance)
        return p->distance > q->distance ? -1 : 1;
    if (p->used != q->used)
        return p->used < q->used ? -1 : 1;
    return (p->slot > q->slot) - (p->slot < q->slot);
}

void vr_victims_sort(struct vr_victim *victims, size_t n)
{
    qsort(victims, n, sizeof *victims, goes_first);
}
