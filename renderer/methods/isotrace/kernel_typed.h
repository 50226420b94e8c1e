/* Through a block: parts and cells, for one type of voxel and one order of voxels in memory. Included once
 * for each, with these defined: VOXEL, the stored type; SPLIT, the member of struct vr_iso_level to compare
 * with, and SPLIT_TYPE, its type; NAME(x), which is x with a suffix of its own; FINITE(x), is a voxel
 * finite?; and TILED for blocks with address tables. */

#ifdef TILED
#define PREFETCH()
#define AT(x, y, z) (block->table[0][x] + block->table[1][y] + block->table[2][z])
#else
/* What a gradient will need beside the cell, while its cubic is solved. */
#define PREFETCH()                                                                                           \
    for (int i = 0; i < 4; i++) {                                                                            \
        const ptrdiff_t y = (i & 1) * (ptrdiff_t)row, z = (i >> 1) * (ptrdiff_t)slice;                       \
        FETCH(v + z + (i & 1 ? 2 : -1) * (ptrdiff_t)row);                                                    \
        FETCH(v + y + (i >> 1 ? 2 : -1) * (ptrdiff_t)slice);                                                 \
    }
#define AT(x, y, z) ((size_t)(z)*block->slice + (size_t)(y)*block->row + (size_t)(x))
#endif

/* Do values from lo to hi lie on both sides of a surface? */
static inline bool NAME(mixed)(const struct vr_iso_frame *frame, VOXEL lo, VOXEL hi)
{
    for (uint32_t k = 0; k < frame->surfaces; k++)
        if ((SPLIT_TYPE)lo < frame->surface[k].SPLIT && (SPLIT_TYPE)hi >= frame->surface[k].SPLIT)
            return true;
    return false;
}

/* One surface, eight corners: are some, but not all of them on the upper side? */
static inline bool NAME(crossed)(const VOXEL c[8], SPLIT_TYPE split)
{
    int n = ((SPLIT_TYPE)c[0] >= split) + ((SPLIT_TYPE)c[1] >= split) + ((SPLIT_TYPE)c[2] >= split) +
            ((SPLIT_TYPE)c[3] >= split) + ((SPLIT_TYPE)c[4] >= split) + ((SPLIT_TYPE)c[5] >= split) +
            ((SPLIT_TYPE)c[6] >= split) + ((SPLIT_TYPE)c[7] >= split);
    return (n & 7) != 0;
}

static inline bool NAME(candidate)(const struct vr_iso_frame *frame, const VOXEL c[8])
{
    for (uint32_t k = 0; k < frame->surfaces; k++)
        if (NAME(crossed)(c, frame->surface[k].SPLIT))
            return true;
    return false;
}

/* Are corners of the cells [at, at + 4) on both sides of a surface? */
static bool NAME(part_mixed)(const struct vr_iso_frame *frame, const struct vr_iso_block *block,
                             const int32_t at[3])
{
    const VOXEL *voxels = block->voxels;
    int32_t n[3];
    for (int i = 0; i < 3; i++)
        n[i] = (block->end[i] - at[i] < VR_ISO_PART ? block->end[i] - at[i] : VR_ISO_PART) + 1;
    for (uint32_t k = 0; k < frame->surfaces; k++) {
        const SPLIT_TYPE split = frame->surface[k].SPLIT;
        int32_t above = 0;
        for (int32_t z = 0; z < n[2]; z++)
            for (int32_t y = 0; y < n[1]; y++)
                for (int32_t x = 0; x < n[0]; x++)
                    above += (SPLIT_TYPE)voxels[AT(at[0] + x, at[1] + y, at[2] + z)] >= split;
        if (above && above < n[0] * n[1] * n[2])
            return true;
    }
    return false;
}

static uint64_t NAME(parts)(const struct vr_iso_frame *frame, const struct vr_iso_block *block, size_t word)
{
    const VOXEL *ranges = block->ranges;
    const int32_t *macros = block->macros;
    const uint32_t row = block->part_row, per_macro = block->macro_shift - block->part_shift;
    uint64_t bits = 0;
    for (uint32_t bit = 0; bit < 64 && (word * 64 + bit) >> (3 * row) == 0; bit++) {
        const uint32_t i = (uint32_t)word * 64 + bit;
        int32_t p[3], at[3];
        bool inside = true;
        for (int a = 0; a < 3; a++) {
            p[a] = (int32_t)(i >> (uint32_t)a * row & ((1u << row) - 1));
            at[a] = block->first[a] + p[a] * VR_ISO_PART;
            inside &= p[a] < block->parts[a];
        }
        if (!inside)
            continue;
        const VOXEL *range =
            ranges +
            2 * (((p[2] >> per_macro) * macros[1] + (p[1] >> per_macro)) * macros[0] + (p[0] >> per_macro));
        if (!frame->skip || (NAME(mixed)(frame, range[0], range[1]) && NAME(part_mixed)(frame, block, at)))
            bits |= UINT64_C(1) << bit;
    }
    return bits;
}

/* From cell to cell while parts are active, from part to part where they are not. */
static int NAME(through)(struct vr_iso_walk *walk, const struct vr_iso_block *block,
                         const atomic_uint_least64_t *bits, double t, int axis, struct brick_error *err)
{
    const struct vr_iso_frame *frame = walk->frame;
    const struct vr_iso_ray *r = &walk->ray;
    const VOXEL *voxels = block->voxels;
    const double slope = frame->grid->slope, intercept = frame->grid->intercept, leave = r->leave;
    int32_t at[3], left[3], step[3], part[3], part_index = 0, part_move[3];
    double next[3], plane[3], pace[3], from[3], stride[3], part_stride[3];
    bool low[3];
#ifndef TILED
    const size_t row = block->row, slice = block->slice;
    const ptrdiff_t move[3] = {r->up[0] ? 1 : -1, r->up[1] ? (ptrdiff_t)row : -(ptrdiff_t)row,
                               r->up[2] ? (ptrdiff_t)slice : -(ptrdiff_t)slice};
    const VOXEL *v;
#endif
    for (int i = 0; i < 3; i++) {
        at[i] = vr_iso_block_cell(r, block, i, t, axis, vr_iso_part_first(block, i, 0), block->end[i]);
        part[i] = at[i] < block->first[i] ? 0 : (at[i] - block->first[i]) >> block->part_shift;
        part_index += part[i] << (uint32_t)i * block->part_row;
        step[i] = r->up[i] ? 1 : -1;
        part_move[i] = step[i] * (1 << (uint32_t)i * block->part_row);
        stride[i] = (double)step[i];
        part_stride[i] = (double)(step[i] * (INT32_C(1) << block->part_shift));
        low[i] = block->edge_low[i] && !r->up[i];
        from[i] = r->from[i];
        pace[i] = r->pace[i];
    }
/* Into the next part, if there is one before the ray's end. */
#define CROSS(i)                                                                                             \
    part[i] += step[i];                                                                                      \
    if (!(t < leave) || (uint32_t)part[i] >= (uint32_t)block->parts[i])                                      \
        return 0;                                                                                            \
    part_index += part_move[i];
#define ACTIVE() (atomic_load_explicit(&bits[part_index >> 6], memory_order_relaxed) >> (part_index & 63) & 1)
    for (;;) {
        if (!ACTIVE()) {
            for (int i = 0; i < 3; i++) {
                plane[i] = (double)(block->lo[i] + (r->up[i] ? vr_iso_part_end(block, i, part[i])
                                                             : vr_iso_part_first(block, i, part[i])));
                next[i] = (plane[i] - from[i]) * pace[i];
            }
/* The low edge's half cell is part of the first part; at the high edge the ray ends before the planes. */
#define LEAP(i)                                                                                              \
    t = next[i];                                                                                             \
    axis = i;                                                                                                \
    CROSS(i)                                                                                                 \
    plane[i] += part_stride[i] - (double)(low[i] & (part[i] == 0));                                          \
    next[i] = (plane[i] - from[i]) * pace[i];
            do {
                if (next[0] <= next[1] && next[0] <= next[2]) {
                    LEAP(0)
                } else if (next[1] <= next[2]) {
                    LEAP(1)
                } else {
                    LEAP(2)
                }
            } while (!ACTIVE());
            for (int i = 0; i < 3; i++)
                at[i] = vr_iso_block_cell(r, block, i, t, axis, vr_iso_part_first(block, i, part[i]),
                                          vr_iso_part_end(block, i, part[i]));
        }
        for (int i = 0; i < 3; i++) {
            const int32_t first = vr_iso_part_first(block, i, part[i]),
                          end = vr_iso_part_end(block, i, part[i]);
            left[i] = r->up[i] ? end - at[i] : at[i] - first + 1;
            plane[i] = (double)(block->lo[i] + at[i] + r->up[i]);
            next[i] = (plane[i] - from[i]) * pace[i];
        }
#ifndef TILED
        v = voxels + AT(at[0], at[1], at[2]);
#endif
        do {
#ifdef TILED
            const uint32_t *x = block->table[0] + at[0], *y = block->table[1] + at[1],
                           *z = block->table[2] + at[2];
            const uint32_t y0 = y[0] + z[0], y1 = y[1] + z[0], y2 = y[0] + z[1], y3 = y[1] + z[1];
            const VOXEL c[8] = {voxels[y0 + x[0]], voxels[y0 + x[1]], voxels[y1 + x[0]], voxels[y1 + x[1]],
                                voxels[y2 + x[0]], voxels[y2 + x[1]], voxels[y3 + x[0]], voxels[y3 + x[1]]};
#else
            const VOXEL c[8] = {v[0],     v[1],         v[row],         v[row + 1],
                                v[slice], v[slice + 1], v[slice + row], v[slice + row + 1]};
#endif
            if (NAME(candidate)(frame, c)) {
                double corners[8];
                bool finite = true;
                PREFETCH()
                for (int i = 0; i < 8; i++) {
                    finite &= FINITE(c[i]);
                    corners[i] = slope * (double)c[i] + intercept;
                }
                if (finite) {
                    int last = vr_iso_first(next);
                    bool ends = !(next[last] < leave);
                    int code = vr_iso_cell(walk, block, at, corners, t, axis, ends ? leave : next[last],
                                           ends ? -1 : last, err);
                    if (code)
                        return code;
                }
            }
#ifdef TILED
#define MOVE(i)
#else
#define MOVE(i) v += move[i];
#endif
#define STEP(i)                                                                                              \
    t = next[i];                                                                                             \
    axis = i;                                                                                                \
    plane[i] += stride[i];                                                                                   \
    next[i] = (plane[i] - from[i]) * pace[i];                                                                \
    at[i] += step[i];                                                                                        \
    MOVE(i)                                                                                                  \
    if (--left[i] == 0) {                                                                                    \
        CROSS(i)                                                                                             \
        if (!ACTIVE())                                                                                       \
            break;                                                                                           \
        left[i] = vr_iso_part_end(block, i, part[i]) - vr_iso_part_first(block, i, part[i]);                 \
    }
            /* Three branches rather than an index: the numbers stay in registers. */
            if (next[0] <= next[1] && next[0] <= next[2]) {
                STEP(0)
            } else if (next[1] <= next[2]) {
                STEP(1)
            } else {
                STEP(2)
            }
        } while (t < leave);
        if (!(t < leave))
            return 0;
    }
#undef LEAP
#undef CROSS
#undef ACTIVE
#undef MOVE
#undef STEP
}

/* Of a cell's surroundings what its gradients need: no corners, no edges. */
static void NAME(gradient)(const struct vr_iso_block *block, const int32_t at[3], const double f[3],
                           double gradient[3])
{
    const VOXEL *voxels = block->voxels;
    double c[64];
    for (int z = 0; z < 4; z++)
        for (int y = 0; y < 4; y++) {
            const bool inside_y = y == 1 || y == 2, inside_z = z == 1 || z == 2;
            for (int x = 0; x < 4; x++)
                if (inside_y + inside_z + (x == 1 || x == 2) >= 2)
                    c[x + 4 * y + 16 * z] = (double)voxels[AT(at[0] + x - 1, at[1] + y - 1, at[2] + z - 1)];
        }
    gradient[0] = central(c + 21, 1, 4, 16, f[0], f[1], f[2]);
    gradient[1] = central(c + 21, 4, 1, 16, f[1], f[0], f[2]);
    gradient[2] = central(c + 21, 16, 1, 4, f[2], f[0], f[1]);
}

#undef AT
#undef PREFETCH
#undef VOXEL
#undef SPLIT
#undef SPLIT_TYPE
#undef NAME
#undef FINITE
