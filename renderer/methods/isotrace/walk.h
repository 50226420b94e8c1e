/* A ray's way through bricks, macrocells and cells (Parker et al. 1998, sections 2.1 and 2.2), and what it
 * finds. */
#ifndef RENDERER_ISOTRACE_WALK_H
#define RENDERER_ISOTRACE_WALK_H

#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include <brick/volume.h>
#include <renderer/renderer.h>

/* A surface in terms of the voxels: stored values from `split` on are on one side, those below on the other.
 * For integer types `split_int` is the same. */
struct vr_iso_level {
    double isovalue, opacity;
    float split;
    int32_t split_int;
};

/* A brick's parts are VR_ISO_PART^3 cells. */
enum { VR_ISO_PART = 4, VR_ISO_PART_SHIFT = 2 };

/* A block of voxels that holds everything a sample of its cells needs: a stored brick, or a whole level.
 * Plane and cell coordinates are the level's, as offsets from lo. */
struct vr_iso_block {
    const void *voxels;
    const void *ranges; /* (min, max) of each macrocell; NULL: none */
    int64_t lo[3];      /* the level's voxel at 0, 0, 0 of the block */
    int32_t first[3];   /* the cells that are the block's, without the half cells outside the volume */
    int32_t end[3];
    bool edge_low[3],
        edge_high[3];     /* the volume ends there: no ray leaves, and the half cell is the block's too */
    uint32_t macro_shift; /* log2 of a macrocell's edge */
    int32_t macros[3];
    uint32_t part_shift, part_row; /* log2 of a part's edge, and of how many a whole brick has on an axis */
    int32_t parts[3];
    size_t row, slice;        /* strides in voxels */
    const uint32_t *table[3]; /* tiled: where a coordinate's voxels are, to be added up */
};

struct vr_iso_ray {
    double origin[3], direction[3]; /* in the level's index coordinates, per mm */
    double from[3],
        pace[3]; /* the ray meets plane p at (p - from) * pace; never (infinity) if it runs along */
    bool moves[3], up[3];
    double enter, leave; /* mm */
};

struct vr_iso_hit {
    double t;
    double gradient[3]; /* level's index space, stored values */
    double light;       /* what of the light's reaches it */
    uint32_t surface;
};

enum vr_iso_phase { VR_ISO_TRAVERSAL, VR_ISO_INTERSECTION, VR_ISO_SHADING };

struct vr_iso_walk;
struct vr_iso_frame;
/* Go through a block that the ray enters at t through a plane of `axis` (-1: starts inside), in the parts
 * whose bits are set. 0: left it; 1: the ray has ended; or a negative enum brick_result. */
typedef int vr_iso_through(struct vr_iso_walk *walk, const struct vr_iso_block *block,
                           const atomic_uint_least64_t *bits, double t, int axis, struct brick_error *err);
/* A word of a block's bits: through which of its parts a surface passes, by the ranges of macrocells and, in
 * those, by the voxels; or all of them, without skipping. */
typedef uint64_t vr_iso_parts(const struct vr_iso_frame *frame, const struct vr_iso_block *block,
                              size_t word);
typedef void vr_iso_gradient(const struct vr_iso_block *block, const int32_t at[3], const double f[3],
                             double gradient[3]);

struct vr_iso_kernel {
    vr_iso_through *through;
    vr_iso_parts *parts;
    vr_iso_gradient *gradient;
};
/* Of a stored type; tiled: for blocks with tables. */
const struct vr_iso_kernel *vr_iso_kernel_of(enum brick_type type, bool tiled);

/* What is the same for all rays of a picture. */
struct vr_iso_frame {
    const struct brick_grid *grid;
    const struct brick_level *level;
    const struct vr_iso_kernel *kernel;
    struct vr_iso_level surface[VR_ISO_MAX_SURFACES];
    uint32_t surfaces;
    struct vr_iso_map *map;          /* where they may be */
    const struct vr_iso_block *flat; /* the whole level as one block, or NULL */
    double termination;
    bool skip;
};

/* What a thread does at this moment, and has done. */
struct vr_iso_activity {
    uint64_t cells;     /* whose cubic was formed */
    atomic_uchar phase; /* enum vr_iso_phase, read by the profile's thread */
};

static inline void vr_iso_now(struct vr_iso_activity *activity, enum vr_iso_phase phase)
{
    atomic_store_explicit(&activity->phase, (unsigned char)phase, memory_order_relaxed);
}

/* A ray under way, waiting at a brick through which a surface may pass. */
struct vr_iso_walk {
    const struct vr_iso_frame *frame;
    struct vr_iso_activity *activity;
    struct vr_iso_ray ray;
    bool done;
    int64_t at[3], index;    /* the brick, in its level */
    double next[3];          /* where the ray meets the brick's planes */
    double t;                /* where it entered the brick, */
    int axis;                /* and through which planes; -1: started inside */
    struct vr_iso_hit *hits; /* front to back; owned */
    size_t hit_count, hit_room;
    double transmittance; /* behind the hits so far */
    bool want_gradient;
};

/* Put the ray between two distances before its first brick. Hits of an earlier ray are gone. */
void vr_iso_start(struct vr_iso_walk *walk, const struct brick_ray *ray, double enter_mm, double leave_mm);

struct vr_iso_pin;
enum { VR_ISO_RAYS = 128 };
/* Follow n started rays, VR_ISO_RAYS at most, to their ends, brick by brick, the nearest brick first: a brick
 * is pinned for all the rays that wait for it. */
int vr_iso_trace(struct vr_iso_walk *walks, size_t n, struct vr_iso_pin *pin, struct brick_error *err);
void vr_iso_walk_finish(struct vr_iso_walk *walk);

/* The cell at `at` of the block (its first corner), whose corners lie on both sides of a surface: look for
 * hits between t0 and t1, where the ray enters and leaves through planes of axis0 and axis1 (-1: it starts or
 * ends inside the cell). Answers as vr_iso_through. */
int vr_iso_cell(struct vr_iso_walk *walk, const struct vr_iso_block *block, const int32_t at[3],
                const double corners[8], double t0, int axis0, double t1, int axis1, struct brick_error *err);

/* Where the ray meets a plane. Ascends with the plane along the ray, and knows nothing but ray and plane: so
 * every level of the hierarchy agrees on the order of crossings. */
static inline double vr_iso_meets(const struct vr_iso_ray *ray, int axis, int64_t plane)
{
    return ((double)plane - ray->from[axis]) * ray->pace[axis];
}

/* The axis whose plane is met first; of several at once the lowest. */
static inline int vr_iso_first(const double t[3])
{
    int axis = t[0] <= t[1] ? 0 : 1;
    return t[axis] <= t[2] ? axis : 2;
}

/* The level's cell that the ray is in on one axis after crossing a plane of axis `crossed` at t (-1: none, it
 * starts there): crossings are in order of t, at the same t in order of axes. Rounding may put the point off
 * by a plane; the planes themselves decide. */
static inline int64_t vr_iso_cell_on(const struct vr_iso_ray *ray, int axis, double t, int crossed)
{
    double p = ray->origin[axis] + t * ray->direction[axis];
    int64_t cell = (int64_t)p;
    cell -= (double)cell > p;
    if (!ray->moves[axis])
        return cell;
    bool ties = crossed < 0 || axis < crossed; /* a plane met at t itself is behind */
#define BEHIND(plane) (ties ? vr_iso_meets(ray, axis, plane) <= t : vr_iso_meets(ray, axis, plane) < t)
    if (ray->up[axis]) {
        while (BEHIND(cell + 1))
            cell++;
        while (!BEHIND(cell))
            cell--;
    } else {
        while (BEHIND(cell))
            cell--;
        while (!BEHIND(cell + 1))
            cell++;
    }
#undef BEHIND
    return cell;
}

/* The same as an offset in a block, among its cells [first, end). */
static inline int32_t vr_iso_block_cell(const struct vr_iso_ray *ray, const struct vr_iso_block *block,
                                        int axis, double t, int crossed, int32_t first, int32_t end)
{
    if (axis == crossed) /* known, whatever rounding says of a point on a plane */
        return ray->up[axis] ? first : end - 1;
    int64_t cell = vr_iso_cell_on(ray, axis, t, crossed) - block->lo[axis];
    return cell < first ? first : cell >= end ? end - 1 : (int32_t)cell;
}

/* A part's cells on an axis: [first, end). At the volume's edge the half cell is one of them. */
static inline int32_t vr_iso_part_first(const struct vr_iso_block *block, int axis, int32_t part)
{
    return block->first[axis] + (part ? part << block->part_shift : -(int32_t)block->edge_low[axis]);
}

static inline int32_t vr_iso_part_end(const struct vr_iso_block *block, int axis, int32_t part)
{
    return part + 1 == block->parts[axis] ? block->end[axis]
                                          : block->first[axis] + ((part + 1) << block->part_shift);
}

#endif
