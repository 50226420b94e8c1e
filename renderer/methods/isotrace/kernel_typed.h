/* Through a block: macrocells and cells, for one type of voxel and one order of voxels in memory. Included
 * once for each with VOXEL        the stored type SPLIT        the member of struct vr_iso_level to compare
 * with, SPLIT_TYPE its type NAME(x)      x with a suffix of its own FINITE(x)    is a voxel finite? TILED
 * defined: through address tables
 */

#ifdef TILED
#define AT(x, y, z) (block->table[0][x] + block->table[1][y] + block->table[2][z])
#else
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

/* Cells of a box [first, end) of the block's cells, from the one that the ray is in at t. */
static inline int NAME(cells)(struct vr_iso_walk *walk, const struct vr_iso_block *block,
                              const int32_t first[3], const int32_t end[3], double t, int axis,
                              const int32_t start[3], struct brick_error *err)
{
    const struct vr_iso_frame *frame = walk->frame;
    const struct vr_iso_ray *r = &walk->ray;
    const VOXEL *voxels = block->voxels;
    const double slope = frame->grid->slope, intercept = frame->grid->intercept, leave = r->leave;
    int32_t at[3], left[3], step[3];
    double next[3], plane[3], pace[3], from[3], stride[3];
    for (int i = 0; i < 3; i++) {
        at[i] = start[i];
        step[i] = r->up[i] ? 1 : -1;
        left[i] = r->up[i] ? end[i] - at[i] : at[i] - first[i] + 1;
        stride[i] = (double)step[i];
        from[i] = r->from[i];
        pace[i] = r->pace[i];
        plane[i] = (double)(block->lo[i] + at[i] + r->up[i]);
        next[i] = (plane[i] - from[i]) * pace[i];
    }
#ifndef TILED
    const ptrdiff_t move[3] = {step[0], step[1] * (ptrdiff_t)block->row, step[2] * (ptrdiff_t)block->slice};
    const size_t row = block->row, slice = block->slice;
    const VOXEL *v = voxels + AT(at[0], at[1], at[2]);
#endif
    for (;;) {
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
        /* Three branches rather than an index: the numbers stay in registers. */
        if (next[0] <= next[1] && next[0] <= next[2]) {
            t = next[0];
            axis = 0;
            plane[0] += stride[0];
            next[0] = (plane[0] - from[0]) * pace[0];
#ifndef TILED
            v += move[0];
#endif
            at[0] += step[0];
            if (--left[0] == 0)
                return 0;
        } else if (next[1] <= next[2]) {
            t = next[1];
            axis = 1;
            plane[1] += stride[1];
            next[1] = (plane[1] - from[1]) * pace[1];
#ifndef TILED
            v += move[1];
#endif
            at[1] += step[1];
            if (--left[1] == 0)
                return 0;
        } else {
            t = next[2];
            axis = 2;
            plane[2] += stride[2];
            next[2] = (plane[2] - from[2]) * pace[2];
#ifndef TILED
            v += move[2];
#endif
            at[2] += step[2];
            if (--left[2] == 0)
                return 0;
        }
        if (!(t < leave))
            return 0;
    }
}

static int NAME(through)(struct vr_iso_walk *walk, const struct vr_iso_block *block, double t, int axis,
                         struct brick_error *err)
{
    const struct vr_iso_ray *r = &walk->ray;
    const bool skip = walk->frame->skip && block->ranges;
    const uint32_t shift = skip ? block->macro_shift : 30; /* without the hierarchy one macrocell holds all */
    const VOXEL *ranges = block->ranges;
    int32_t at[3], macro[3], macros[3], first[3], end[3], move[3];
    int32_t index = 0, stride = 2;
    double next[3];

    for (int i = 0; i < 3; i++) {
        at[i] = vr_iso_block_cell(r, block, i, t, axis, block->first[i] - block->edge_low[i], block->end[i]);
        macros[i] = skip ? block->macros[i] : 1;
        macro[i] = at[i] < block->first[i] ? 0 : (at[i] - block->first[i]) >> shift;
        next[i] = vr_iso_macro_exit(r, block, i, macro[i], macros[i], shift);
        move[i] = r->up[i] ? stride : -stride;
        index += macro[i] * stride;
        stride *= macros[i];
    }
    for (bool entered = true;; entered = false) {
        if (!skip || NAME(mixed)(walk->frame, ranges[index], ranges[index + 1])) {
            for (int i = 0; i < 3; i++) {
                bool low = macro[i] == 0, high = macro[i] + 1 == macros[i];
                first[i] = block->first[i] + (low ? -(int32_t)block->edge_low[i] : macro[i] << shift);
                end[i] = high ? block->end[i] : block->first[i] + ((macro[i] + 1) << shift);
                if (!entered)
                    at[i] = vr_iso_block_cell(r, block, i, t, axis, first[i], end[i]);
            }
            int code = NAME(cells)(walk, block, first, end, t, axis, at, err);
            if (code)
                return code;
        }
        axis = vr_iso_first(next);
        t = next[axis];
        macro[axis] += r->up[axis] ? 1 : -1;
        if (!(t < r->leave) || (uint32_t)macro[axis] >= (uint32_t)macros[axis])
            return 0;
        index += move[axis];
        next[axis] = vr_iso_macro_exit(r, block, axis, macro[axis], macros[axis], shift);
    }
}

/* f(p + e) - f(p - e) from rows of four voxels along an axis, at the corners of the other two. */
static inline double NAME(central)(const struct vr_iso_block *block, const int32_t at[3], int axis,
                                   const double f[3])
{
    const VOXEL *voxels = block->voxels;
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    double d[4];
    for (int i = 0; i < 4; i++) {
        int32_t p[3] = {at[0], at[1], at[2]};
        double row[4];
        p[u] += i & 1;
        p[v] += i >> 1;
        p[axis]--;
        for (int j = 0; j < 4; j++, p[axis]++)
            row[j] = (double)voxels[AT(p[0], p[1], p[2])];
        d[i] = (row[2] + f[axis] * (row[3] - row[2])) - (row[0] + f[axis] * (row[1] - row[0]));
    }
    double low = d[0] + f[u] * (d[1] - d[0]), high = d[2] + f[u] * (d[3] - d[2]);
    return low + f[v] * (high - low);
}

/* Central differences of the trilinear field at +-1 voxel; where a neighbour is not finite the component is
 * 0. */
static void NAME(gradient)(const struct vr_iso_block *block, const int32_t at[3], const double f[3],
                           double gradient[3])
{
    for (int i = 0; i < 3; i++) {
        double g = 0.5 * NAME(central)(block, at, i, f);
        gradient[i] = isfinite(g) ? g : 0.0;
    }
}

#undef AT
#undef VOXEL
#undef SPLIT
#undef SPLIT_TYPE
#undef NAME
#undef FINITE
