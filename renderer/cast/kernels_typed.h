/* The kernels of one set that load voxels of one type. No include guard. Defined before: TYPE, BYTES, FIRST
 * and, where a word of memory holds two neighbours, SECOND. */
#define NAME2(kernel, type) SET(kernel##_##type)
#define NAME1(kernel, type) NAME2(kernel, type)
#define NAME(kernel)        NAME1(kernel, TYPE)

/* The lanes' voxels and their neighbours along x. */
TARGET INLINE void NAME(pair)(const char *voxels, vi byte, vf pair[2])
{
#ifdef SECOND
    const vi word = SET(gather)(voxels, byte);
    pair[0] = FIRST(word);
    pair[1] = SECOND(word);
#else
    vi word[2];
    SET(gather_two)(voxels, byte, word);
    pair[0] = (vf)word[0], pair[1] = (vf)word[1];
#endif
}

/* Four in a row along x, from the lanes' voxels on. */
TARGET INLINE void NAME(four)(const char *voxels, vi byte, vf v[4])
{
#if BYTES == 1
    const vi word = SET(gather)(voxels, byte);
    v[0] = FIRST(word), v[1] = SECOND(word);
    v[2] = FIRST((vi)((vu)word >> 16)), v[3] = SECOND((vi)((vu)word >> 16));
#elif BYTES == 2
    vi word[2];
    SET(gather_two)(voxels, byte, word);
    v[0] = FIRST(word[0]), v[1] = SECOND(word[0]);
    v[2] = FIRST(word[1]), v[3] = SECOND(word[1]);
#else
    NAME(pair)(voxels, byte, v);
    NAME(pair)(voxels + 2 * BYTES, byte, v + 2);
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

/* The cells' corners, x fastest. */
TARGET INLINE void NAME(corners)(const struct vr_cast_brick *brick, vi byte, vf c[8])
{
    const char *voxels = brick->voxels;
    const ptrdiff_t row = (ptrdiff_t)brick->row * BYTES, slice = (ptrdiff_t)brick->slice * BYTES;
    NAME(pair)(voxels, byte, c);
    NAME(pair)(voxels + row, byte, c + 2);
    NAME(pair)(voxels + slice, byte, c + 4);
    NAME(pair)(voxels + slice + row, byte, c + 6);
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
        vf f[3], c[8];
        for (int a = 0; a < 3; a++)
            f[a] = __builtin_convertvector(LOADI(queue->at[a] + i) & 0xffffff, vf) * 0x1p-24f;
        NAME(corners)(brick, ((voxel & good) | (queue->voxel[0] & ~good)) * BYTES, c);
        const vf y[4] = {NAME(along)(c[0], c[1], f[0]), NAME(along)(c[2], c[3], f[0]),
                         NAME(along)(c[4], c[5], f[0]), NAME(along)(c[6], c[7], f[0])};
        const vf value = NAME(bilinear)(y, f[1], f[2]) * field->sign;
#if BYTES == 4
        if (field->nonfinite)
            for (int k = 0; k < 8; k++)
                good &= ((vi)c[k] & 0x7f800000) != 0x7f800000;
#endif
        good &= (value >= field->visible[0]) & (value <= field->visible[1]);
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
    const vi iota = {IOTA};
    for (uint32_t n = 0; n < seen->count; n += LANES) {
        const vi good = iota + (int32_t)n < (int32_t)seen->count;
        const vi byte = ((LOADI(seen->voxel + n) & good) | (seen->voxel[0] & ~good)) * BYTES;
        const vf f[3] = {LOADF(seen->fraction[0] + n), LOADF(seen->fraction[1] + n),
                         LOADF(seen->fraction[2] + n)};
        /* c: corners, x fastest; d: differences along one axis at the corners of the other two */
        vf c[8], d[4], gradient[3], v[4], w[2];
        for (int k = 0; k < 4; k++) {
            NAME(four)(voxels - BYTES + (k & 1 ? row : 0) + (k & 2 ? slice : 0), byte, v);
            d[k] = NAME(central)(v[0], v[1], v[2], v[3], f[0]);
            c[2 * k] = v[1], c[2 * k + 1] = v[2];
        }
        gradient[0] = NAME(bilinear)(d, f[1], f[2]);
        for (int k = 0; k < 4; k += 2) {
            const ptrdiff_t at = k & 2 ? slice : 0;
            NAME(pair)(voxels + at - row, byte, v);
            NAME(pair)(voxels + at + 2 * row, byte, w);
            for (int i = 0; i < 2; i++)
                d[k + i] = NAME(central)(v[i], c[2 * k + i], c[2 * k + 2 + i], w[i], f[1]);
        }
        gradient[1] = NAME(bilinear)(d, f[0], f[2]);
        for (int k = 0; k < 4; k += 2) {
            const ptrdiff_t at = k & 2 ? row : 0;
            NAME(pair)(voxels + at - slice, byte, v);
            NAME(pair)(voxels + at + 2 * slice, byte, w);
            for (int i = 0; i < 2; i++)
                d[k + i] = NAME(central)(v[i], c[k + i], c[k + 4 + i], w[i], f[2]);
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

#undef NAME
#undef NAME1
#undef NAME2
#undef TYPE
#undef BYTES
#undef FIRST
#undef SECOND
