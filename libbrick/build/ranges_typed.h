/* Ranges of a brick for one voxel type. No include guard: included once a type by encode.c, with
 *   T       the voxel type,  NAME(f) the function's name for it,
 *   USABLE(v) whether v counts (finite),  LOWEST, HIGHEST  the ends of the type (of an empty range: HIGHEST,
 * LOWEST). */

/* A padded or tight array: element (x,y,z) is at base + (z * sy + y) * sx + x. */
static void NAME(macrocell_range)(const T *lo, const T *hi, size_t sx, size_t sy, const uint32_t from[3],
                                  const uint32_t to[3], T out[2])
{
    T a = HIGHEST, b = LOWEST;
    for (uint32_t z = from[2]; z <= to[2]; z++)
        for (uint32_t y = from[1]; y <= to[1]; y++) {
            const T *l = lo + (z * sy + y) * sx, *h = hi + (z * sy + y) * sx;
            for (uint32_t x = from[0]; x <= to[0]; x++) {
                a = USABLE(l[x]) && l[x] < a ? l[x] : a;
                b = USABLE(h[x]) && h[x] > b ? h[x] : b;
            }
        }
    out[0] = a;
    out[1] = b;
}

/* lo, hi point at core voxel (0,0,0); both arrays hold at least core + 1 voxels on each axis. */
static void NAME(ranges)(const struct brick_grid *grid, const struct brick_place *place, const T *lo,
                         const T *hi, size_t sx, size_t sy, T *macrocells, struct brick_entry *entry)
{
    T min = HIGHEST, max = LOWEST;
    for (uint32_t z = 0; z < place->macrocells[2]; z++)
        for (uint32_t y = 0; y < place->macrocells[1]; y++)
            for (uint32_t x = 0; x < place->macrocells[0]; x++) {
                uint32_t at[3] = {x, y, z}, from[3], to[3];
                for (int a = 0; a < 3; a++) {
                    from[a] = at[a] * grid->macrocell;
                    to[a] = from[a] + grid->macrocell < place->core[a] ? from[a] + grid->macrocell
                                                                       : place->core[a];
                }
                NAME(macrocell_range)(lo, hi, sx, sy, from, to, macrocells);
                min = macrocells[0] < min ? macrocells[0] : min;
                max = macrocells[1] > max ? macrocells[1] : max;
                macrocells += 2;
            }
    entry->min = min <= max ? (float)min : INFINITY;
    entry->max = min <= max ? (float)max : -INFINITY;
}

#undef T
#undef NAME
#undef USABLE
#undef LOWEST
#undef HIGHEST
