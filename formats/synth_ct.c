/* Painting the body phantom (synth_ct_body.c) row by row.
 *
 * A part covers a voxel by clamp(1/2 + d, 0, 1), d the distance in voxels from its surface, positive inside,
 * to first order: partial volumes over one voxel. Parts are mixed in order. Two intervals of a row, found per
 * row in double precision and so the same for every span, bound the work: outside the outer one coverage is
 * zero, inside the inner one it is one and the row is filled. Air is exactly air: noise fades below -900
 * HU, so that it neither falls on air nor makes any. */
#include <math.h>
#include <stdlib.h>

#include "synth_ct.h"

#define NOISE_HU 12.0f /* standard deviation */

/* A part in voxel coordinates. */
struct painted {
    enum ct_kind kind;
    float hu;
    double lo[3], hi[3]; /* box that holds every voxel the part touches */
    /* Ellipsoid and shell: q = sum of ((p - centre) / axis)^2. */
    double centre[3], inverse_axis2[3]; /* 1 / axis^2 */
    double q_out, q_in;                 /* the part's edge lies within these q */
    float half_wall;                    /* shell, in voxels */
    float fade;                         /* below 1 for what is thinner than a voxel */
    float plane[2][4];                  /* shell: distance in voxels = plane . (p, 1) */
    /* Capsule, in body coordinates; to_body scales voxels. */
    float end[3], axis[3], inverse_length2, radius;
};

struct ct_phantom {
    unsigned count;
    double to_body[3]; /* body = (2 i + 1) / n - 1 */
    struct painted part[SYNTH_MAX_PARTS];
};

/* Range of sqrt(q) at which the first-order distance to q = 1 is within `margin` voxels: |grad q| <= 2
 * sqrt(q) / a, with a the shortest axis in voxels. */
static void edge_range(double margin, double shortest, double *q_in, double *q_out)
{
    const double h = 2 * margin / shortest, root = sqrt(h * h + 4);
    *q_out = (root + h) * (root + h) / 4;
    *q_in = (root - h) * (root - h) / 4;
}

static void prepare_ellipsoid(struct painted *out, const struct ct_part *part, const uint64_t dims[3])
{
    double shortest = INFINITY, scale = 0;
    for (int i = 0; i < 3; i++) {
        const double half = (double)dims[i] / 2, axis = part->b[i] * half;
        out->centre[i] = (part->a[i] + 1) * half - 0.5;
        out->inverse_axis2[i] = 1 / (axis * axis);
        shortest = axis < shortest ? axis : shortest;
        scale += half / 3;
    }
    const double half_wall = part->kind == CT_SHELL ? part->thickness / 2 * scale : 0;
    edge_range(half_wall + 0.5, shortest, &out->q_in, &out->q_out);
    for (int i = 0; i < 3; i++) {
        const double reach = sqrt(out->q_out / out->inverse_axis2[i]);
        out->lo[i] = out->centre[i] - reach;
        out->hi[i] = out->centre[i] + reach;
    }
    out->half_wall = (float)half_wall;
    out->fade = half_wall < 0.5 ? (float)(2 * half_wall) : 1;
    for (int k = 0; k < 2 && part->kind == CT_SHELL; k++) {
        /* normal . ((2 i + 1) / n - 1) + offset, over the length of its gradient in voxels */
        const struct ct_plane *plane = &part->plane[k];
        double gradient[3], constant = plane->offset, length = 0;
        for (int i = 0; i < 3; i++) {
            gradient[i] = plane->normal[i] * 2 / (double)dims[i];
            constant += plane->normal[i] * (1 / (double)dims[i] - 1);
            length += gradient[i] * gradient[i];
        }
        length = sqrt(length);
        for (int i = 0; i < 3; i++)
            out->plane[k][i] = (float)(gradient[i] / length);
        out->plane[k][3] = (float)(constant / length);
    }
}

static void prepare_capsule(struct painted *out, const struct ct_part *part, const uint64_t dims[3])
{
    double length2 = 0, voxel = 0;
    for (int i = 0; i < 3; i++) {
        const double half = (double)dims[i] / 2, axis = part->b[i] - part->a[i];
        out->end[i] = (float)part->a[i];
        out->axis[i] = (float)axis;
        length2 += axis * axis;
        voxel += 1 / half / 3;
        const double a = (part->a[i] + 1) * half - 0.5, b = (part->b[i] + 1) * half - 0.5;
        const double reach = part->thickness * half + 1.5;
        out->lo[i] = (a < b ? a : b) - reach;
        out->hi[i] = (a < b ? b : a) + reach;
    }
    const double diameter_vox = 2 * part->thickness / voxel;
    out->radius = (float)part->thickness;
    out->inverse_length2 = (float)(1 / length2);
    out->fade = diameter_vox < 1 ? (float)(diameter_vox * diameter_vox) : 1;
}

int synth_ct_init(struct synth_volume *volume, struct brick_error *err)
{
    struct ct_part_list *list = malloc(sizeof *list);
    struct ct_phantom *phantom = calloc(1, sizeof *phantom);
    if (!list || !phantom) {
        free(list);
        free(phantom);
        return brick_fail(err, BRICK_ERR_MEMORY, "synth: out of memory");
    }
    synth_ct_body(list);
    phantom->count = list->count;
    for (int i = 0; i < 3; i++)
        phantom->to_body[i] = 2 / (double)volume->dims[i];
    for (unsigned i = 0; i < list->count; i++) {
        struct painted *out = &phantom->part[i];
        out->kind = list->part[i].kind;
        out->hu = (float)list->part[i].hu;
        if (out->kind == CT_CAPSULE)
            prepare_capsule(out, &list->part[i], volume->dims);
        else
            prepare_ellipsoid(out, &list->part[i], volume->dims);
    }
    free(list);
    volume->phantom = phantom;
    switch (volume->type) { /* HU of stored values: air at the least one, or as scanners write it */
    case BRICK_U8:
    case BRICK_I8:
        volume->slope = 10; /* -1000 to 1550 HU */
        volume->intercept = CT_AIR - 10 * volume->lo;
        break;
    case BRICK_U16:
        volume->intercept = CT_AIR;
        break;
    default: /* i16 and f32 hold HU */
        break;
    }
    return BRICK_OK;
}

void synth_ct_finish(struct synth_volume *volume)
{
    free(volume->phantom);
    volume->phantom = NULL;
}

static bool reaches(const struct painted *part, int axis, uint64_t at)
{
    return part->lo[axis] <= (double)at && (double)at <= part->hi[axis];
}

void synth_ct_slice(const struct synth_volume *volume, struct synth_slice *slice)
{
    const struct ct_phantom *phantom = volume->phantom;
    slice->parts = 0;
    for (unsigned i = 0; i < phantom->count; i++)
        if (reaches(&phantom->part[i], 2, slice->z))
            slice->part[slice->parts++] = (uint16_t)i;
}

/* Voxels of [lo, hi] that fall into the span [x, x + n), counted from x; empty when *first >= *end. */
static void clip_to_span(double lo, double hi, uint64_t x, unsigned n, unsigned *first, unsigned *end)
{
    const double from = ceil(lo) - (double)x, to = floor(hi) + 1 - (double)x;
    *first = from <= 0 ? 0 : from >= n ? n : (unsigned)from;
    *end = to <= 0 ? 0 : to >= n ? n : (unsigned)to;
}

static inline float clamp01(float v)
{
    v = v > 0 ? v : 0;
    return v < 1 ? v : 1;
}

static inline float absolute(float v)
{
    return v < 0 ? -v : v;
}

/* Exact for a cover of 0 and of 1. */
static inline float mix(float under, float over, float cover)
{
    return (1 - cover) * under + cover * over;
}

/* One row of an ellipsoid or shell: what does not change along it. */
struct ellipsoid_row {
    float inverse_axis2, inverse_axis4; /* along x */
    float q, gradient2;                 /* of y and z */
};

static inline float ellipsoid_distance_vox(const struct ellipsoid_row *row, float dx)
{
    const float q = dx * dx * row->inverse_axis2 + row->q;
    const float gradient2 = dx * dx * row->inverse_axis4 + row->gradient2;
    return (1 - q) / (2 * sqrtf(gradient2) + 1e-30f);
}

static void paint_edge(const struct painted *part, const struct ellipsoid_row *row, uint64_t x,
                       unsigned first, unsigned end, float *out)
{
    const float start = (float)((double)(x + first) - part->centre[0]);
    const float hu = part->hu;
    const struct ellipsoid_row r = *row;
    for (unsigned i = 0; i + first < end; i++) {
        const float cover = clamp01(0.5f + ellipsoid_distance_vox(&r, start + (float)(int)i));
        out[first + i] = mix(out[first + i], hu, cover);
    }
}

static void paint_shell(const struct painted *part, const struct ellipsoid_row *row, uint64_t x,
                        unsigned first, unsigned end, uint64_t y, uint64_t z, float *out)
{
    const float start = (float)((double)(x + first) - part->centre[0]);
    float base[2];
    for (int k = 0; k < 2; k++)
        base[k] =
            (float)((double)part->plane[k][0] * (double)(x + first) + (double)part->plane[k][1] * (double)y +
                    (double)part->plane[k][2] * (double)z + (double)part->plane[k][3]);
    for (unsigned i = 0; i + first < end; i++) {
        const float at = (float)(int)i;
        const float d = ellipsoid_distance_vox(row, start + at);
        float cover = clamp01(0.5f + part->half_wall - absolute(d)) * part->fade;
        cover *= clamp01(0.5f + base[0] + at * part->plane[0][0]);
        cover *= clamp01(0.5f + base[1] + at * part->plane[1][0]);
        out[first + i] = mix(out[first + i], part->hu, cover);
    }
}

static void paint_ellipsoid(const struct painted *part, uint64_t x, unsigned n, uint64_t y, uint64_t z,
                            float *out)
{
    const double dy = (double)y - part->centre[1], dz = (double)z - part->centre[2];
    const double qy = dy * dy * part->inverse_axis2[1], qz = dz * dz * part->inverse_axis2[2], q = qy + qz;
    if (q >= part->q_out)
        return;
    const double reach = sqrt((part->q_out - q) / part->inverse_axis2[0]);
    const struct ellipsoid_row row = {(float)part->inverse_axis2[0],
                                      (float)(part->inverse_axis2[0] * part->inverse_axis2[0]), (float)q,
                                      (float)(qy * part->inverse_axis2[1] + qz * part->inverse_axis2[2])};
    unsigned first, end, inner_first, inner_end;
    clip_to_span(part->centre[0] - reach, part->centre[0] + reach, x, n, &first, &end);
    inner_first = inner_end = end; /* no inner interval: all of it is edge */
    if (q < part->q_in) {
        const double inner = sqrt((part->q_in - q) / part->inverse_axis2[0]);
        clip_to_span(part->centre[0] - inner, part->centre[0] + inner, x, n, &inner_first, &inner_end);
        if (inner_first >= inner_end)
            inner_first = inner_end = end;
    }
    if (part->kind == CT_SHELL) {
        paint_shell(part, &row, x, first, inner_first, y, z, out);
        paint_shell(part, &row, x, inner_end, end, y, z, out);
        return;
    }
    paint_edge(part, &row, x, first, inner_first, out);
    for (unsigned i = inner_first; i < inner_end; i++)
        out[i] = part->hu;
    paint_edge(part, &row, x, inner_end, end, out);
}

static void paint_capsule(const struct painted *part, const double to_body[3], uint64_t x, unsigned n,
                          uint64_t y, uint64_t z, float *out)
{
    unsigned first, end;
    clip_to_span(part->lo[0], part->hi[0], x, n, &first, &end);
    const float step[3] = {(float)to_body[0], (float)to_body[1], (float)to_body[2]};
    const float px = (float)(((double)(x + first) + 0.5) * to_body[0] - 1 - (double)part->end[0]);
    const float py = (float)(((double)y + 0.5) * to_body[1] - 1 - (double)part->end[1]);
    const float pz = (float)(((double)z + 0.5) * to_body[2] - 1 - (double)part->end[2]);
    const float along_yz = py * part->axis[1] + pz * part->axis[2];
    for (unsigned i = 0; i + first < end; i++) {
        const float qx = px + (float)(int)i * step[0];
        const float t = clamp01((qx * part->axis[0] + along_yz) * part->inverse_length2);
        const float dx = qx - t * part->axis[0], dy = py - t * part->axis[1], dz = pz - t * part->axis[2];
        const float distance = sqrtf(dx * dx + dy * dy + dz * dz);
        /* Length of one voxel across the surface, in body coordinates, is |(dx, dy, dz) * step| / distance.
         */
        const float sx = dx * step[0], sy = dy * step[1], sz = dz * step[2];
        const float d = (part->radius - distance) * distance / (sqrtf(sx * sx + sy * sy + sz * sz) + 1e-30f);
        const float cover = clamp01(0.5f + (distance > 1e-12f ? d : 1)) * part->fade;
        out[first + i] = mix(out[first + i], part->hu, cover);
    }
}

/* Bits that depend on every bit of the seed and the row (Steele's SplitMix64 finalizer). */
static uint64_t mix64(uint64_t v)
{
    v = (v ^ (v >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    v = (v ^ (v >> 27)) * UINT64_C(0x94d049bb133111eb);
    return v ^ (v >> 31);
}

/* Noise that is nearly Gaussian: the sum of four bytes of a hash of seed and coordinates. */
static void add_noise(const struct synth_volume *volume, uint64_t x, unsigned first, unsigned end, uint64_t y,
                      uint64_t z, float *out)
{
    uint64_t key = mix64(volume->seed + UINT64_C(0x9e3779b97f4a7c15));
    key = mix64(key ^ z);
    key = mix64(key ^ y);
    key = mix64(key ^ (x >> 32));
    const uint32_t add = (uint32_t)key, flip = (uint32_t)(key >> 32), low = (uint32_t)x;
    const float scale = NOISE_HU / 147.80f; /* four bytes: variance 4 (256^2 - 1) / 12 */
    for (unsigned i = first; i < end; i++) {
        uint32_t h = (low + i) * 0x9e3779b1u + add;
        h = (h ^ (h >> 16)) * 0x85ebca6bu ^ flip;
        h = (h ^ (h >> 13)) * 0xc2b2ae35u;
        h ^= h >> 16;
        const uint32_t pairs = (h & 0xff00ff) + (h >> 8 & 0xff00ff);
        const float noise = ((float)(int)((pairs & 0xffff) + (pairs >> 16)) - 510) * scale; /* below 42 HU */
        out[i] += noise * clamp01((out[i] - (float)CT_AIR) * 0.01f);
    }
}

void synth_ct_span(const struct synth_volume *volume, const struct synth_slice *slice, uint64_t x, unsigned n,
                   uint64_t y, float *out)
{
    const struct ct_phantom *phantom = volume->phantom;
    const uint64_t z = slice->z;
    for (unsigned i = 0; i < n; i++)
        out[i] = (float)CT_AIR;
    for (unsigned k = 0; k < slice->parts; k++) {
        const struct painted *part = &phantom->part[slice->part[k]];
        if (!reaches(part, 1, y) || part->hi[0] < (double)x || part->lo[0] >= (double)(x + n))
            continue;
        if (part->kind == CT_CAPSULE)
            paint_capsule(part, phantom->to_body, x, n, y, z, out);
        else
            paint_ellipsoid(part, x, n, y, z, out);
    }
    unsigned first, end; /* the skin is the first part: all else lies within */
    clip_to_span(phantom->part[0].lo[0], phantom->part[0].hi[0], x, n, &first, &end);
    add_noise(volume, x, first, end, y, z, out);
    const float scale = (float)(1 / volume->slope), offset = (float)(-volume->intercept / volume->slope);
    for (unsigned i = 0; i < n; i++)
        out[i] = out[i] * scale + offset;
}
