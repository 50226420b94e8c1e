/* Downsampling for one voxel type. No include guard: included once a type by downsample.c with T, NAME,
 * USABLE, LOWEST, HIGHEST as in ranges_typed.h, and MEAN(rows, i, j): the mean of voxels i and j of the four
 * rows. */

static void NAME(row)(const T *const voxels[4], const T *const min[4], const T *const max[4], uint64_t fine_n,
                      uint64_t coarse_n, bool halved, bool nearest, T *out, T *out_min, T *out_max)
{
    for (uint64_t x = 0; x < coarse_n; x++) {
        uint64_t i = halved ? 2 * x : x, j = halved && i + 1 < fine_n ? i + 1 : i;
        T a = HIGHEST, b = LOWEST;
        for (int r = 0; r < 4; r++) {
            a = USABLE(min[r][i]) && min[r][i] < a ? min[r][i] : a;
            a = USABLE(min[r][j]) && min[r][j] < a ? min[r][j] : a;
            b = USABLE(max[r][i]) && max[r][i] > b ? max[r][i] : b;
            b = USABLE(max[r][j]) && max[r][j] > b ? max[r][j] : b;
        }
        out_min[x] = a;
        out_max[x] = b;
        out[x] = nearest ? voxels[0][i] : MEAN(voxels, i, j);
    }
}

#undef T
#undef NAME
#undef USABLE
#undef LOWEST
#undef HIGHEST
#undef MEAN
