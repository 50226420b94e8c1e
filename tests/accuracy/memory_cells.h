/* A small volume in memory as cells, and rays that make trouble. */
#ifndef TESTS_ACCURACY_MEMORY_CELLS_H
#define TESTS_ACCURACY_MEMORY_CELLS_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "march.h"
#include "reference.h"
#include "reference_volume.h"

enum { NX = 5, NY = 4, NZ = 6 };

struct memory_cells {
    struct vr_cells cells;
    double voxels[NZ * NY * NX];
    int64_t last[3];
    uint64_t loads, jumps; /* cells asked for; steps to a cell that is no neighbour */
};

static inline int memory_load(struct vr_cells *base, const int64_t cell[3], struct vr_corners *corners,
                              struct brick_error *err)
{
    struct memory_cells *m = (struct memory_cells *)base;
    int64_t moved = 0;
    (void)err;
    for (int i = 0; i < 3; i++) {
        assert_true(cell[i] >= -1 && cell[i] < (int64_t)m->cells.dims[i]);
        moved += llabs(cell[i] - m->last[i]);
        m->last[i] = cell[i];
    }
    m->jumps += m->loads > 0 && moved > 3;
    m->loads++;
    corners->lo = INFINITY;
    corners->hi = -INFINITY;
    for (int i = 0; i < 8; i++) {
        int64_t at[3];
        for (int a = 0; a < 3; a++)
            at[a] = reference_clamp(cell[a] + (i >> a & 1), (int64_t)m->cells.dims[a]);
        corners->value[i] = m->voxels[(at[2] * NY + at[1]) * NX + at[0]];
        if (!isfinite(corners->value[i]))
            return 0;
        corners->lo = fmin(corners->lo, corners->value[i]);
        corners->hi = fmax(corners->hi, corners->value[i]);
    }
    return 1;
}

static inline void memory_gradient(struct vr_cells *base, const int64_t cell[3], double gradient[3][8])
{
    const struct memory_cells *m = (const struct memory_cells *)base;
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 8; i++) {
            double side[2];
            for (int k = 0; k < 2; k++) {
                int64_t at[3];
                for (int a = 0; a < 3; a++)
                    at[a] = reference_clamp(cell[a] + (i >> a & 1) + (a == axis ? 2 * k - 1 : 0),
                                            (int64_t)m->cells.dims[a]);
                side[k] = m->voxels[(at[2] * NY + at[1]) * NX + at[0]];
            }
            gradient[axis][i] = 0.5 * (side[1] - side[0]);
        }
}

static inline void fill(struct memory_cells *m, unsigned long long seed)
{
    *m = (struct memory_cells){.cells = {{NX, NY, NZ}, {1, 1, 1}, {0, 0, 0}, memory_load, memory_gradient}};
    for (int i = 0; i < NX * NY * NZ; i++)
        m->voxels[i] = reference_random(&seed);
}

static inline struct reference_volume volume_of(const struct memory_cells *m)
{
    struct reference_volume v = {.voxels = m->voxels};
    for (int i = 0; i < 3; i++) {
        v.dims[i] = (int64_t)m->cells.dims[i];
        v.scale[i] = m->cells.scale[i];
        v.offset[i] = m->cells.offset[i];
    }
    return v;
}

#define MAX_AWKWARD 1024

/* Rays that make trouble: in faces and edges, through edges and corners, on the box's own faces, from inside,
 * and with directions that are almost along an axis. */
static inline size_t awkward_rays(struct brick_ray *rays)
{
    static const double coordinate[] = {-0.5, 0.0, 1.0, 1.5, 2.0, 2.9999999999999996, 3.0, 3.5};
    size_t n = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int a = 0; a < 8; a++)
            for (int b = 0; b < 8; b++)
                for (int way = 0; way < 4; way++) {
                    struct brick_ray *r = &rays[n++];
                    for (int i = 0; i < 3; i++) {
                        r->origin[i] = i == (axis + 1) % 3 ? coordinate[a] : coordinate[b];
                        r->direction[i] = way & 2 ? (i == (axis + 1) % 3 ? 1e-17 : -3e-16) : 0.0;
                    }
                    r->origin[axis] = way & 1 ? 11.0 : -7.0;
                    r->direction[axis] = way & 1 ? -1.0 : 1.0;
                }
    for (int x = -1; x <= 1; x++)
        for (int y = -1; y <= 1; y++)
            for (int z = -1; z <= 1; z++)
                for (int start = 0; start < 4; start++) {
                    if (x == 0 && y == 0 && z == 0)
                        continue;
                    /* through voxels, hence through corners and edges of cells; from outside and from inside
                     */
                    double back = start == 0 ? 0.0 : start == 1 ? 8.0 : start == 2 ? 1.0 / 3.0 : 1000.1;
                    rays[n++] = (struct brick_ray){{2.0 - back * x, 2.0 - back * y, 2.0 - back * z},
                                                   {x * 0.577, y * 0.577, z * 0.577}};
                }
    return n;
}

#endif
