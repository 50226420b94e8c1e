/* One set of kernels. No include guard. Defined before: SET, TARGET, LANES, IOTA, ODD and the set's own
 * operations. */
#define LOADF(p) (*(const vf *)(const void *)(p))
#define LOADI(p) (*(const vi *)(const void *)(p))

TARGET INLINE void SET(store)(void *to, vi v) /* anywhere */
{
    memcpy(to, &v, sizeof v);
}

TARGET INLINE vf SET(select)(vi mask, vf yes, vf no)
{
    return (vf)((mask & (vi)yes) | (~mask & (vi)no));
}

TARGET INLINE vf SET(absolute)(vf v)
{
    return (vf)((vi)v & 0x7fffffff);
}

/* exponential.glsl */
TARGET INLINE vf SET(exponential_part)(vf x, vf *scale)
{
    const vf y = SET(max)(x, (vf){0} - 87.0f);
    const vf n = SET(floor)(y * 1.44269504f + 0.5f);
    const vf r = (y - n * 0.693359375f) - n * -2.12194440e-4f;
    vf p = (float)(1.0 / 720.0) + r * (float)(1.0 / 5040.0);
    p = (float)(1.0 / 120.0) + r * p;
    p = (float)(1.0 / 24.0) + r * p;
    p = (float)(1.0 / 6.0) + r * p;
    p = 0.5f + r * p;
    p = r + (r * r) * p;
    *scale = (vf)((__builtin_convertvector(n, vi) + 127) << 23);
    return p;
}

TARGET INLINE vf SET(exponential)(vf x)
{
    vf scale, p = SET(exponential_part)(x, &scale);
    return scale * (1.0f + p);
}

TARGET INLINE vf SET(opacity)(vf x)
{
    vf scale, p = SET(exponential_part)(-x, &scale);
    return (1.0f - scale) - scale * p;
}

/* x^n, 0 <= x <= 1, n >= 0 */
TARGET INLINE vf SET(power)(vf x, float n)
{
    const vi exponent = ((vi)x - 0x3f3504f3) >> 23; /* x = 2^e m with m from sqrt(1/2) to sqrt(2) */
    const vf e = __builtin_convertvector(exponent, vf), m = (vf)((vi)x - (exponent << 23));
    const vf s = (m - 1.0f) / (m + 1.0f), z = s * s; /* ln m = 2 artanh s */
    vf p = (float)(2.0 / 7.0) + z * (float)(2.0 / 9.0);
    p = (float)(2.0 / 5.0) + z * p;
    p = (float)(2.0 / 3.0) + z * p;
    p = s * (2.0f + z * p);
    const vf logarithm = e * 0.693359375f + (e * -2.12194440e-4f + p);
    return SET(select)(x >= 0x1p-126f, SET(exponential)(SET(min)(n * logarithm, (vf){0})), (vf){0});
}

TARGET INLINE vi SET(either)(vi second, const uint32_t words[2])
{
    const vi mask = -second;
    return (mask & (int32_t)words[1]) | (~mask & (int32_t)words[0]);
}

TARGET static void SET(scan)(struct vr_cast_queue *queue, const struct vr_cast_brick *brick,
                             struct vr_cast_run *run)
{
    const vi iota = {IOTA};
    uint64_t first[LANES / 2] = {0};
    vl number, at[3][2];
    uint32_t n = queue->count, left = run->count, done = 0;
    const uint32_t enough = n + VR_CAST_ROUND;
    for (int i = 0; i < LANES / 2; i++)
        first[i] = (uint64_t)i;
    memcpy(&number, first, sizeof number);
    for (int a = 0; a < 3; a++) {
        at[a][0] = run->at[a] + number * run->step[a];
        at[a][1] = at[a][0] + LANES / 2 * run->step[a];
    }
    do {
        const uint32_t some = left < LANES ? left : LANES;
        vu high[3];
        vi cell[3], active = iota < (int32_t)some;
        for (int a = 0; a < 3; a++) {
            high[a] = __builtin_shufflevector((vu)at[a][0], (vu)at[a][1], ODD);
            cell[a] = (vi)(high[a] >> 24) + run->offset[a];
            at[a][0] += LANES * run->step[a];
            at[a][1] += LANES * run->step[a];
        }
        vi part[3];
        for (int a = 0; a < 3; a++) { /* the half cell before the volume belongs to its first macrocell */
            part[a] = cell[a] - brick->border;
            part[a] = (part[a] & ~(part[a] >> 31)) >> brick->macro_shift;
        }
        const vi bit = (part[0] + part[1] * brick->bit_row + part[2] * brick->bit_slice) & active;
        const vi word =
            brick->words == 2 ? SET(either)(bit >> 5, brick->bits) : SET(gather)(brick->bits, bit >> 5 << 2);
        active &= -((vi)((vu)word >> (vu)(bit & 31)) & 1);
        const uint32_t mask = SET(mask)(active);
        if (mask) {
            SET(compress)(queue->voxel + n, mask, cell[2] * brick->slice + cell[1] * brick->row + cell[0]);
            for (int a = 0; a < 3; a++)
                SET(compress)(queue->at[a] + n, mask, (vi)high[a]);
            SET(store)(queue->ray + n, (vi){0} + (int32_t)run->ray);
            SET(store)(queue->length_mm + n, (vi)((vf){0} + run->length_mm));
            n += (uint32_t)__builtin_popcount(mask);
        }
        left -= some;
        done += some;
    } while (left && n < enough);
    queue->count = n;
    run->count = left;
    for (int a = 0; a < 3; a++)
        run->at[a] += done * run->step[a];
}

TARGET INLINE vf SET(piece)(const struct vr_cast_pieces *pieces, uint32_t count, int row, vi at)
{
    return SET(pick)(pieces->row[row], count, at);
}

/* Which piece each lane's value belongs to: of few pieces by comparing with all, else by bins. */
TARGET INLINE vi SET(find_piece)(const struct vr_cast_pieces *pieces, uint32_t count, vf v)
{
    const struct vr_transfer_table *table = pieces->table;
    if (count <= 16) {
        vi piece = {0};
        for (uint32_t i = 1; i < table->count; i++)
            piece -= v >= pieces->row[VR_CAST_START][i];
        return piece;
    }
    const vf last_bin = (vf){0} + (float)(table->bin_count - 1);
    const vf bin = SET(min)(SET(max)((v - table->bin_origin) * table->bin_scale, (vf){0}), last_bin);
    const vi at = __builtin_convertvector(bin, vi) * (int32_t)sizeof(struct vr_bin);
    vi low = SET(gather)(&table->bins->first, at), high = SET(gather)(&table->bins->last, at);
    for (uint32_t s = 0; s < table->search_steps; s++) {
        const vi middle = (low + high + 1) >> 1;
        const vi up = v >= SET(piece)(pieces, count, VR_CAST_START, middle);
        const vi down = middle - 1, not_below = (vi)(down > low);
        low = (up & middle) | (~up & low);
        high = (up & high) | (~up & ((not_below & down) | (~not_below & low)));
    }
    return low;
}

/* transfer.glsl: optical depth and colour of values. count: of pieces, or 16 where there are no more. */
TARGET INLINE vf SET(transfer)(const struct vr_cast_pieces *pieces, uint32_t count, vf v, vf length,
                               vf rgb[3])
{
    const vf zero = {0}, one = zero + 1.0f;
    const vi at = SET(find_piece)(pieces, count, v);
    const vf from = v - SET(piece)(pieces, count, VR_CAST_ORIGIN, at);
    for (int c = 0; c < 3; c++) {
        const vf raw = SET(piece)(pieces, count, VR_CAST_RGB + c, at) +
                       SET(piece)(pieces, count, VR_CAST_RGB_SLOPE + c, at) * from;
        rgb[c] = SET(min)(SET(max)(raw, zero), one);
    }
    const vf sigma = SET(piece)(pieces, count, VR_CAST_SIGMA, at) +
                     SET(piece)(pieces, count, VR_CAST_SIGMA_SLOPE, at) * from;
    return SET(max)(sigma, zero) * length;
}

TARGET INLINE void SET(classify_part)(struct vr_cast_seen *seen, const struct vr_cast_pieces *pieces,
                                      uint32_t count)
{
    for (uint32_t i = 0; i < seen->count; i += LANES) {
        vf rgb[3];
        const vf depth =
            SET(transfer)(pieces, count, LOADF(seen->value + i), LOADF(seen->length_mm + i), rgb);
        SET(store)(seen->depth + i, (vi)depth);
        SET(store)(seen->alpha + i, (vi)SET(opacity)(depth));
        for (int c = 0; c < 3; c++)
            SET(store)(seen->rgb[c] + i, (vi)rgb[c]);
    }
}

TARGET static void SET(classify)(struct vr_cast_seen *seen, const struct vr_cast_pieces *pieces)
{
    const uint32_t count = pieces->table->count;
    if (count <= 16)
        SET(classify_part)(seen, pieces, 16);
    else
        SET(classify_part)(seen, pieces, count);
}

TARGET static void SET(opacities)(struct vr_cast_seen *seen)
{
    for (uint32_t i = 0; i < seen->count; i += LANES)
        SET(store)(seen->alpha + i, (vi)SET(opacity)(LOADF(seen->depth + i)));
}

TARGET static void SET(dim)(struct vr_cast_seen *seen, const float *before)
{
    for (uint32_t i = 0; i < seen->count; i += LANES)
        SET(store)(seen->alpha + i, (vi)(SET(exponential)(-LOADF(before + i)) * LOADF(seen->alpha + i)));
}

/* shading.glsl */
TARGET INLINE void SET(lit)(struct vr_cast_seen *seen, uint32_t i, const vf gradient[3],
                            const struct vr_cast_light *light)
{
    const vi ray = LOADI(seen->ray + i) << 2;
    vf n[3], view[3], most = {0}, total = {0};
    for (int a = 0; a < 3; a++) {
        n[a] = light->normal[a][0] * gradient[0] + light->normal[a][1] * gradient[1] +
               light->normal[a][2] * gradient[2];
        most = SET(max)(most, SET(absolute)(n[a]));
        total = total + SET(absolute)(n[a]);
        view[a] = (vf)SET(gather)(light->view[a], ray);
    }
    const vi sided = (total > 0.0f) & (total <= 3.0e38f);
    for (int a = 0; a < 3; a++)
        n[a] = n[a] / most;
    const vf length = SET(sqrt)(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const vf along = (n[0] * view[0] + n[1] * view[1] + n[2] * view[2]) / length;
    const vf facing = SET(min)(SET(absolute)(along), (vf){0} + 1.0f);
    const vf highlight = SET(power)(facing, light->shininess);
    const vf factor = SET(select)(sided, light->ambient + light->diffuse * facing, (vf){0} + light->ambient);
    const vf added = SET(select)(sided, light->specular * highlight, (vf){0});
    for (int c = 0; c < 3; c++)
        SET(store)(seen->rgb[c] + i, (vi)(LOADF(seen->rgb[c] + i) * factor + added));
}

/* Two words a lane as one, the lower lanes' first. */
TARGET INLINE void SET(join)(vl to[2], const uint32_t low[], const uint32_t high[])
{
    const vu a = (vu)LOADI(low), b = (vu)LOADI(high);
    to[0] = (vl)__builtin_shufflevector(a, b, ZIP_LOW);
    to[1] = (vl)__builtin_shufflevector(a, b, ZIP_HIGH);
}

TARGET INLINE void SET(move_sums)(struct vr_cast_sums *to, const struct vr_cast_sums *from, uint32_t i,
                                  uint32_t mask)
{
    const uint32_t n = to->count;
    SET(compress)(to->ray + n, mask, LOADI(from->ray + i));
    SET(compress)(to->depth + n, mask, LOADI(from->depth + i));
    for (int c = 0; c < 3; c++)
        SET(compress)(to->rgb[c] + n, mask, LOADI(from->rgb[c] + i));
    to->count = n + (uint32_t)__builtin_popcount(mask);
}

/* Rays i to i + LANES - 1, of which those of `on` go on, to the end of the list of these; the others of
 * `ended` to the list of those. */
TARGET INLINE void SET(part)(struct vr_cast_packet *p, uint32_t i, uint32_t on, uint32_t ended)
{
    const uint32_t n = p->on.count;
    for (int a = 0; a < 3; a++)
        for (int w = 0; w < 2; w++) {
            SET(compress)(p->at[a][w] + n, on, LOADI(p->at[a][w] + i));
            SET(compress)(p->step[a][w] + n, on, LOADI(p->step[a][w] + i));
        }
    SET(compress)(p->voxel + n, on, LOADI(p->voxel + i));
    SET(compress)(p->left + n, on, LOADI(p->left + i));
    SET(compress)(p->length_mm + n, on, LOADI(p->length_mm + i));
    SET(move_sums)(&p->ended, &p->on, i, ended);
    SET(move_sums)(&p->on, &p->on, i, on);
}

TARGET static void SET(sum)(struct vr_cast_packet *p, uint32_t i, uint32_t rays,
                            const struct vr_cast_seen *seen, float depth_end)
{
    const vi iota = {IOTA}, valid = iota + (int32_t)i < (int32_t)rays;
    vf rgb[3], depth = LOADF(p->on.depth + i);
    vi on = ~(depth > depth_end);
    for (int c = 0; c < 3; c++)
        rgb[c] = LOADF(p->on.rgb[c] + i);
    for (uint32_t n = 0; n < seen->count; n += LANES) {
        const vf alpha = SET(exponential)(-depth) * (vf)(LOADI(seen->alpha + n) & on);
        for (int c = 0; c < 3; c++)
            rgb[c] += alpha * LOADF(seen->rgb[c] + n);
        depth += (vf)(LOADI(seen->depth + n) & on);
        on = ~(depth > depth_end);
    }
    SET(store)(p->on.depth + i, (vi)depth);
    for (int c = 0; c < 3; c++)
        SET(store)(p->on.rgb[c] + i, (vi)rgb[c]);
    on &= valid & (LOADI(p->left + i) > 0);
    SET(part)(p, i, SET(mask)(on), SET(mask)(valid & ~on));
}

TARGET static void SET(largest)(struct vr_cast_packet *p, uint32_t i, uint32_t rays,
                                const struct vr_cast_seen *seen)
{
    const vi iota = {IOTA}, valid = iota + (int32_t)i < (int32_t)rays;
    const vf one = (vf){0} + 1.0f;
    vf most = LOADF(p->on.rgb[0] + i), any = LOADF(p->on.depth + i);
    for (uint32_t n = 0; n < seen->count; n += LANES) {
        const vf value = LOADF(seen->value + n);
        const vi is = value == value;
        most = SET(select)((value > most) | (is & (any == 0.0f)), value, most);
        any = SET(select)(is, one, any);
    }
    SET(store)(p->on.depth + i, (vi)any);
    SET(store)(p->on.rgb[0] + i, (vi)most);
    const vi on = valid & (LOADI(p->left + i) > 0);
    SET(part)(p, i, SET(mask)(on), SET(mask)(valid & ~on));
}

#define TYPE      u8
#define BYTES     1
#define FIRST(w)  __builtin_convertvector((w)&0xff, vf)
#define SECOND(w) __builtin_convertvector((w) >> 8 & 0xff, vf)
#include "kernels_typed.h"
#define TYPE      i8
#define BYTES     1
#define FIRST(w)  __builtin_convertvector((w) << 24 >> 24, vf)
#define SECOND(w) __builtin_convertvector((w) << 16 >> 24, vf)
#include "kernels_typed.h"
#define TYPE      u16
#define BYTES     2
#define FIRST(w)  __builtin_convertvector((w)&0xffff, vf)
#define SECOND(w) __builtin_convertvector((vi)((vu)(w) >> 16), vf)
#include "kernels_typed.h"
#define TYPE      i16
#define BYTES     2
#define FIRST(w)  __builtin_convertvector((w) << 16 >> 16, vf)
#define SECOND(w) __builtin_convertvector((w) >> 16, vf)
#include "kernels_typed.h"
#define TYPE     f32
#define BYTES    4
#define FIRST(w) ((vf)(w))
#include "kernels_typed.h"

static const struct vr_cast_kernels SET(kernels) = {
    .scan = SET(scan),
    .classify = SET(classify),
    .opacities = SET(opacities),
    .dim = SET(dim),
    .sum = SET(sum),
    .largest = SET(largest),
    .lanes = LANES,
    .typed = {[BRICK_U8] = {SET(look_u8), SET(shade_u8), SET(march_u8)},
              [BRICK_I8] = {SET(look_i8), SET(shade_i8), SET(march_i8)},
              [BRICK_U16] = {SET(look_u16), SET(shade_u16), SET(march_u16)},
              [BRICK_I16] = {SET(look_i16), SET(shade_i16), SET(march_i16)},
              [BRICK_F32] = {SET(look_f32), SET(shade_f32), SET(march_f32)}},
};

#undef LOADF
#undef LOADI
#undef SET
#undef TARGET
#undef LANES
#undef IOTA
#undef ODD
#undef EVEN
#undef ZIP_LOW
#undef ZIP_HIGH
