/* Where on their rays the pixels of a picture can meet a surface, for each block of 2 x 2 pixels: from the
 * boxes of what is active, seen by the camera. Rays elsewhere need not start, and the others start and end
 * there. */
#ifndef RENDERER_ISOTRACE_BOUNDS_H
#define RENDERER_ISOTRACE_BOUNDS_H

#include <brick/camera.h>

#include "map.h"

enum { VR_ISO_BLOCK = 2 };

/* An interval of t, in mm; empty when far < near. */
struct vr_iso_reach {
    float near, far;
};

struct vr_iso_bounds {
    const struct vr_iso_frame *frame;
    /* Voxels of the level in mm from the eye (parallel: from the first pixel's origin): right, up, forward.
     */
    double to_eye[3][4];
    double scale[2], shift[2]; /* to columns and rows, of what is right and up, or of its ratio to forward */
    bool parallel;
    int32_t blocks[2];
    unsigned threads;
    size_t room;                 /* blocks that there is memory for, a thread */
    struct vr_iso_reach **reach; /* one picture a thread; NULL: no memory yet */
    bool *used;                  /* has that thread added anything to this frame? */
};

/* Nothing is active yet. Memory is kept for the next frame: finish once. */
int vr_iso_bounds_begin(struct vr_iso_bounds *bounds, const struct vr_iso_frame *frame,
                        const struct brick_view *view, uint32_t width, uint32_t height, unsigned threads,
                        struct brick_error *err);
void vr_iso_bounds_finish(struct vr_iso_bounds *bounds);

/* Add the active ones of a level's bricks [first, end). Threads add each to its own, at the same time. */
int vr_iso_bounds_add(struct vr_iso_bounds *bounds, unsigned thread, uint64_t first, uint64_t end,
                      struct brick_error *err);

/* What all threads have added to a block. */
static inline struct vr_iso_reach vr_iso_bounds_of(const struct vr_iso_bounds *bounds, uint32_t column,
                                                   uint32_t row)
{
    const size_t at = (size_t)(row / VR_ISO_BLOCK) * (size_t)bounds->blocks[0] + column / VR_ISO_BLOCK;
    struct vr_iso_reach all = {INFINITY, -INFINITY};
    for (unsigned i = 0; i < bounds->threads; i++)
        if (bounds->used[i]) {
            struct vr_iso_reach r = bounds->reach[i][at];
            all.near = r.near < all.near ? r.near : all.near;
            all.far = r.far > all.far ? r.far : all.far;
        }
    return all;
}

#endif
