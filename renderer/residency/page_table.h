/* The page table: one word a brick of the level, x fastest, what the shaders know of it (shaders/field.glsl).
 *
 *   bits 30-31  state
 *   bits 24-29  level of the brick in the slot: of a missing brick that of the one that stands in for it, or
 * the table's own where none does bits 16-23  slot's z in the atlas bits  8-15  slot's y bits  0- 7  slot's x
 */
#ifndef RENDERER_RESIDENCY_PAGE_TABLE_H
#define RENDERER_RESIDENCY_PAGE_TABLE_H

#include <stdint.h>

enum vr_page_state {
    VR_PAGE_INACTIVE = 0, /* nothing visible; iso: wholly on one side */
    VR_PAGE_RESIDENT = 1, /* active and in the slot */
    VR_PAGE_WHOLE = 2,    /* the same, and all its macrocells are active: no need to look at them */
    VR_PAGE_MISSING = 3   /* active but not in the atlas */
};

static inline uint32_t vr_page(enum vr_page_state state, uint32_t level, const uint32_t slot[3])
{
    return (uint32_t)state << 30 | level << 24 | slot[2] << 16 | slot[1] << 8 | slot[0];
}

#endif
