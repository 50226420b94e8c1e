/* Which slots give up their bricks first.
 *
 * Depths of bricks ascend along every ray (depth.h). Hence no ray will need a brick that is nearer than the
 * nearest brick that some ray waits for; and that one is needed now for the last time. So bricks behind the
 * front go first, least recently used ones before others; after them the farthest, which are needed last. */
#ifndef RENDERER_RESIDENCY_VICTIMS_H
#define RENDERER_RESIDENCY_VICTIMS_H

#include <stddef.h>
#include <stdint.h>

enum vr_worth { VR_WORTH_NOTHING, VR_WORTH_PAST, VR_WORTH_FUTURE };

struct vr_victim {
    enum vr_worth worth;
    uint64_t used;   /* number of the last pass that wanted it */
    double distance; /* VR_WORTH_FUTURE */
    uint32_t slot;
};

/* Those that go first in front. */
void vr_victims_sort(struct vr_victim *victims, size_t n);

#endif
