/* The last axis of macrocell ranges for one voxel type. No include guard: included once a type by ranges.c
 * with T, NAME, LOWEST, HIGHEST as in kernels_typed.h (lo and hi hold no NaN any more) and CANONICAL(v),
 * which turns -0 into 0: which of the two comes first in a minimum is left to the order, and the order is
 * free. */

static void NAME(split)(const T *lo, const T *hi, uint32_t core, uint32_t edge, T *out, T range[2])
{
    for (uint32_t from = 0; from < core; from += edge, out += 2) {
        uint32_t to = from + edge < core ? from + edge : core;
        T a = lo[from], b = hi[from];
        for (uint32_t x = from + 1; x <= to; x++) {
            a = lo[x] < a ? lo[x] : a;
            b = hi[x] > b ? hi[x] : b;
        }
        out[0] = CANONICAL(a);
        out[1] = CANONICAL(b);
        range[0] = out[0] < range[0] ? out[0] : range[0];
        range[1] = out[1] > range[1] ? out[1] : range[1];
    }
}

static void NAME(ranges)(const struct kernels *k, const struct brick_grid *grid,
                         const struct brick_place *place, const T *lo, const T *hi, size_t sx, size_t sy,
                         T *macrocells, T *scratch, struct brick_entry *entry)
{
    const uint32_t *core = place->core, edge = grid->macrocell;
    size_t width = core[0] + 1, plane = core[1] * sx + width, stride = sx * sy;
    T *plane_lo = scratch, *plane_hi = plane_lo + plane, *row_lo = plane_hi + plane, *row_hi = row_lo + width;
    T range[2] = {HIGHEST, LOWEST};
    for (uint32_t z = 0; z < core[2]; z += edge) {
        uint32_t nz = z + edge < core[2] ? edge : core[2] - z;
        k->fold[grid->type](plane_lo, plane_hi, lo + z * stride, hi + z * stride, stride, nz + 1, plane);
        for (uint32_t y = 0; y < core[1]; y += edge) {
            uint32_t ny = y + edge < core[1] ? edge : core[1] - y;
            k->fold[grid->type](row_lo, row_hi, plane_lo + y * sx, plane_hi + y * sx, sx, ny + 1, width);
            NAME(split)(row_lo, row_hi, core[0], edge, macrocells, range);
            macrocells += (size_t)2 * place->macrocells[0];
        }
    }
    entry->min = range[0] <= range[1] ? (float)range[0] : INFINITY;
    entry->max = range[0] <= range[1] ? (float)range[1] : -INFINITY;
}

#undef T
#undef NAME
#undef LOWEST
#undef HIGHEST
#undef CANONICAL
