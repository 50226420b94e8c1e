/* The kernels of one set that load voxels of one type. No include guard. Defined before: TYPE, BYTES, FIRST
 * and, where a word of memory holds two neighbours, SECOND. */
#define NAME2(kernel, type) SET(kernel##_##type)
#define NAME1(kernel, type) NAME2(kernel, type)
#define NAME(kernel)        NAME1(kernel, TYPE)

/* The lanes' voxels and their neighbours along x, from each of four bases. */
TARGET INLINE void NAME(pairs)(const char *const base[4], vi byte, vf pair[4][2])
{
#if BYTES == 4
    vi word[4][2];
    SET(rows)(base, byte, word);
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 2; i++)
            pair[k][i] = (vf)word[k][i];
#else
    for (int k = 0; k < 4; k++) {
        const vi word = SET(gather)(base[k], byte);
        pair[k][0] = FIRST(word);
        pair[k][1] = SECOND(word);
    }
#endif
}

/* The same with four voxels in a row. */
TARGET INLINE void NAME(fours)(const char *const base[4], vi byte, vf v[4][4])
{
#if BYTES == 1
    for (int k = 0; k < 4; k++) {
        const vi word = SET(gather)(base[k], byte), rest = (vi)((vu)word >> 16);
        v[k][0] = FIRST(word), v[k][1] = SECOND(word);
        v[k][2] = FIRST(rest), v[k][3] = SECOND(rest);
    }
#elif BYTES == 2
    vi word[4][2];
    SET(rows)(base, byte, word);
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 2; i++) {
            v[k][2 * i] = FIRST(word[k][i]);
            v[k][2 * i + 1] = SECOND(word[k][i]);
        }
#else
    vf pair[4][2];
    const char *const next[4] = {base[0] + 8, base[1] + 8, base[2] + 8, base[3] + 8};
    NAME(pairs)(base, byte, pair);
    for (int k = 0; k < 4; k++)
        v[k][0] = pair[k][0], v[k][1] = pair[k][1];
    NAME(pairs)(next, byte, pair);
    for (int k = 0; k < 4; k++)
        v[k][2] = pair[k][0], v[k][3] = pair[k][1];
#endif
}

TARGET INLINE vf NAME(along)(vf from, vf to, vf t)
{
    return from + t * (to - from);
}

TARGET INLINE vf NAME(bilinear)(const vf v[4], vf s, vf t) /* the first index runs with s */
{
    const vf a = NAME(along)(v[0], v[1], s), b = NAME(along)(v[2], v[3], s);
    return NAME(along)(a, b, t);
}

/* The field in the cells whose first corners are at `byte`, its sign turned; *good: those where it can be
 * visible. */
TARGET INLINE vf NAME(sample)(const struct vr_cast_brick *brick, const struct vr_cast_field *field, vi byte,
                              const vf f[3], vi *good)
{
    const char *voxels = brick->voxels;
    const ptrdiff_t row = (ptrdiff_t)brick->row * BYTES, slice = (ptrdiff_t)brick->slice * BYTES;
    const char *const rows[4] = {voxels, voxels + row, voxels + slice, voxels + slice + row};
    vf c[4][2];
    NAME(pairs)(rows, byte, c);
    const vf y[4] = {NAME(along)(c[0][0], c[0][1], f[0]), NAME(along)(c[1][0], c[1][1], f[0]),
                     NAME(along)(c[2][0], c[2][1], f[0]), NAME(along)(c[3][0], c[3][1], f[0])};
    const vf value = NAME(bilinear)(y, f[1], f[2]) * field->sign;
#if BYTES == 4
    if (field->nonfinite)
        for (int k = 0; k < 8; k++)
            *good &= ((vi)c[k / 2][k % 2] & 0x7f800000) != 0x7f800000;
#endif
    *good &= (value >= field->visible[0]) & (value <= field->visible[1]);
    return value;
}

TARGET static void NAME(look)(struct vr_cast_seen *seen, const struct vr_cast_queue *queue,
                              const struct vr_cast_brick *brick, const struct vr_cast_field *field,
                              bool place)
{
    const vi iota = {IOTA};
    uint32_t n = 0;
    for (uint32_t i = 0; i < queue->count; i += LANES) {
        const vi voxel = LOADI(queue->voxel + i);
        vi good = iota + (int32_t)i < (int32_t)queue->count;
        vf f[3];
        for (int a = 0; a < 3; a++)
            f[a] = __builtin_convertvector(LOADI(queue->at[a] + i) & 0xffffff, vf) * 0x1p-24f;
        const vi byte = ((voxel & good) | (queue->voxel[0] & ~good)) * BYTES;
        const vf value = NAME(sample)(brick, field, byte, f, &good);
        const uint32_t mask = SET(mask)(good);
        if (!mask)
            continue;
        SET(compress)(seen->ray + n, mask, LOADI(queue->ray + i));
        SET(compress)(seen->value + n, mask, (vi)value);
        SET(compress)(seen->length_mm + n, mask, LOADI(queue->length_mm + i));
        if (place) {
            SET(compress)(seen->voxel + n, mask, voxel);
            for (int a = 0; a < 3; a++)
                SET(compress)(seen->fraction[a] + n, mask, (vi)f[a]);
        }
        n += (uint32_t)__builtin_popcount(mask);
    }
    seen->count = n;
}

/* f(p + e) - f(p - e) on a line of four voxels. */
TARGET INLINE vf NAME(central)(vf v0, vf v1, vf v2, vf v3, vf t)
{
    return NAME(along)(v2, v3, t) - NAME(along)(v0, v1, t);
}

TARGET static void NAME(shade)(struct vr_cast_seen *seen, const struct vr_cast_brick *brick,
                               const struct vr_cast_light *light, bool nonfinite)
{
    const char *voxels = brick->voxels;
    const ptrdiff_t row = (ptrdiff_t)brick->row * BYTES, slice = (ptrdiff_t)brick->slice * BYTES;
    /* Rows that cross the cell or touch it: x from -1 on, y at -1 and 2, z at -1 and 2 */
    const char *const along_x[4] = {voxels - BYTES, voxels - BYTES + row, voxels - BYTES + slice,
                                    voxels - BYTES + slice + row};
    const char *const beside_y[4] = {voxels - row, voxels + 2 * row, voxels + slice - row,
                                     voxels + slice + 2 * row};
    const char *const beside_z[4] = {voxels - slice, voxels + 2 * slice, voxels + row - slice,
                                     voxels + row + 2 * slice};
    const vi iota = {IOTA};
    for (uint32_t n = 0; n < seen->count; n += LANES) {
        const vi good = iota + (int32_t)n < (int32_t)seen->count;
        const vi byte = ((LOADI(seen->voxel + n) & good) | (seen->voxel[0] & ~good)) * BYTES;
        const vf f[3] = {LOADF(seen->fraction[0] + n), LOADF(seen->fraction[1] + n),
                         LOADF(seen->fraction[2] + n)};
        /* x: corners are in the middle, [y + 2 z][1 + x]; d: differences along one axis at the corners of the
         * others */
        vf x[4][4], side[4][2], d[4], gradient[3];
        NAME(fours)(along_x, byte, x);
        for (int k = 0; k < 4; k++)
            d[k] = NAME(central)(x[k][0], x[k][1], x[k][2], x[k][3], f[0]);
        gradient[0] = NAME(bilinear)(d, f[1], f[2]);
        NAME(pairs)(beside_y, byte, side);
        for (int k = 0; k < 4; k++) {
            const int i = k % 2, z = k - i; /* z: 0 or 2 */
            d[k] = NAME(central)(side[z][i], x[z][1 + i], x[z + 1][1 + i], side[z + 1][i], f[1]);
        }
        gradient[1] = NAME(bilinear)(d, f[0], f[2]);
        NAME(pairs)(beside_z, byte, side);
        for (int k = 0; k < 4; k++) {
            const int i = k % 2, y = k / 2;
            d[k] = NAME(central)(side[2 * y][i], x[y][1 + i], x[y + 2][1 + i], side[2 * y + 1][i], f[2]);
        }
        gradient[2] = NAME(bilinear)(d, f[0], f[1]);
        for (int a = 0; a < 3; a++) {
            gradient[a] *= 0.5f;
            if (nonfinite) /* where a neighbour is not finite the component is 0 */
                gradient[a] = (vf)((vi)gradient[a] & (((vi)gradient[a] & 0x7f800000) != 0x7f800000));
        }
        SET(lit)(seen, n, gradient, light);
    }
}

TARGET static uint32_t NAME(march)(struct vr_cast_seen *seen, struct vr_cast_packet *p, uint32_t i,
                                   const struct vr_cast_brick *brick, const struct vr_cast_field *field,
                                   bool place)
{
    const vi left = LOADI(p->left + i), from = LOADI(p->voxel + i), ray = LOADI(p->on.ray + i);
    const vf length = LOADF(p->length_mm + i);
    const vi inside =
        (vi){0} + brick->border * (1 + brick->row + brick->slice); /* where lanes without look */
    vl at[3][2], step[3][2];
    vi looked = {0};
    uint32_t n = 0, samples = 0;
    for (int a = 0; a < 3; a++) {
        SET(join)(at[a], p->at[a][0] + i, p->at[a][1] + i);
        SET(join)(step[a], p->step[a][0] + i, p->step[a][1] + i);
    }
    for (int32_t s = 0; s < VR_CAST_STEPS; s++, n += LANES) {
        const vi live = s < left;
        vi cell[3];
        vf f[3];
        if (!SET(mask)(live))
            break;
        for (int a = 0; a < 3; a++) {
            const vu high = __builtin_shufflevector((vu)at[a][0], (vu)at[a][1], ODD);
            cell[a] = (vi)(high >> 24);
            f[a] = __builtin_convertvector((vi)(high & 0xffffff), vf) * 0x1p-24f;
            at[a][0] += step[a][0];
            at[a][1] += step[a][1];
        }
        const vi there = from + cell[2] * brick->slice + cell[1] * brick->row + cell[0];
        const vi voxel = (there & live) | (inside & ~live);
        vi good = live;
        const vf value = NAME(sample)(brick, field, voxel * BYTES, f, &good);
        looked -= live;
        SET(store)(seen->value + n, (vi)value | ~good);
        SET(store)(seen->length_mm + n, (vi)length);
        if (place) {
            SET(store)(seen->ray + n, ray);
            SET(store)(seen->voxel + n, voxel);
            for (int a = 0; a < 3; a++)
                SET(store)(seen->fraction[a] + n, (vi)f[a]);
        }
    }
    for (int a = 0; a < 3; a++) {
        SET(store)(p->at[a][0] + i, (vi)__builtin_shufflevector((vu)at[a][0], (vu)at[a][1], EVEN));
        SET(store)(p->at[a][1] + i, (vi)__builtin_shufflevector((vu)at[a][0], (vu)at[a][1], ODD));
    }
    SET(store)(p->left + i, left - VR_CAST_STEPS);
    seen->count = n;
    for (int k = 0; k < LANES; k++)
        samples += (uint32_t)looked[k];
    return samples;
}

#undef NAME
#undef NAME1
#undef NAME2
#undef TYPE
#undef BYTES
#undef FIRST
#undef SECOND
