/* A small volume in memory as a field along a ray, in long double: trilinear, clamped to its edge. */
#ifndef TESTS_ACCURACY_REFERENCE_VOLUME_H
#define TESTS_ACCURACY_REFERENCE_VOLUME_H

#include <stdint.h>
#include <stdlib.h>

#include <brick/camera.h>

#include "reference.h"

#define REFERENCE_MAX_PLANES 256

struct reference_volume {
    const double *voxels; /* physical, x fastest */
    int64_t dims[3];
    double scale[3], offset[3];  /* index0 = scale * index + offset */
    const struct brick_ray *ray; /* in index0 coordinates */
};

static int64_t reference_clamp(int64_t i, int64_t n)
{
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

/* Weights and numbers of the 8 voxels around a point of the level's index space. */
static inline void reference_corners(const struct reference_volume *v, const long double p[3],
                                     long double weight[8], int64_t voxel[8])
{
    int64_t cell[3];
    long double x[3];
    for (int i = 0; i < 3; i++) {
        long double q = fminl(fmaxl(p[i], 0.0L), (long double)(v->dims[i] - 1));
        cell[i] = (int64_t)floorl(q);
        x[i] = q - (long double)cell[i];
    }
    for (int i = 0; i < 8; i++) {
        int64_t at[3];
        weight[i] = 1.0L;
        for (int a = 0; a < 3; a++) {
            weight[i] *= i >> a & 1 ? x[a] : 1.0L - x[a];
            at[a] = reference_clamp(cell[a] + (i >> a & 1), v->dims[a]);
        }
        voxel[i] = (at[2] * v->dims[1] + at[1]) * v->dims[0] + at[0];
    }
}

static inline long double reference_value(const struct reference_volume *v, const long double p[3])
{
    long double weight[8], sum = 0.0L;
    int64_t voxel[8];
    reference_corners(v, p, weight, voxel);
    for (int i = 0; i < 8; i++)
        sum += weight[i] * v->voxels[voxel[i]];
    return sum;
}

static inline void reference_position(const struct reference_volume *v, long double t, long double p[3])
{
    for (int i = 0; i < 3; i++)
        p[i] = (v->ray->origin[i] + t * v->ray->direction[i] - v->offset[i]) / v->scale[i];
}

static inline long double reference_field(void *context, long double t)
{
    const struct reference_volume *v = context;
    long double p[3];
    reference_position(v, t, p);
    return reference_value(v, p);
}

static int reference_ascending(const void *a, const void *b)
{
    long double x = *(const long double *)a, y = *(const long double *)b;
    return (x > y) - (x < y);
}

/* Where a ray enters and where it meets the level's integer planes before it leaves, ascending; how many. */
static inline size_t reference_cuts(const struct reference_volume *v, const struct brick_ray *ray,
                                    double enter, double leave, long double cuts[REFERENCE_MAX_PLANES])
{
    size_t count = 0;
    cuts[count++] = enter;
    for (int i = 0; i < 3; i++)
        for (int64_t plane = 0; plane < v->dims[i] && ray->direction[i] != 0.0; plane++) {
            long double at = (long double)plane * v->scale[i] + v->offset[i];
            long double cut = (at - ray->origin[i]) / ray->direction[i];
            if (cut > enter && cut < leave && count < REFERENCE_MAX_PLANES)
                cuts[count++] = cut;
        }
    qsort(cuts, count, sizeof *cuts, reference_ascending);
    return count;
}

/* Go on along a whole ray, cut where it meets the level's integer planes, with n intervals between two cuts.
 */
static inline void reference_along(struct reference *r, struct reference_volume *v,
                                   const struct brick_ray *ray, double enter, double leave, int n)
{
    long double cuts[REFERENCE_MAX_PLANES];
    size_t count = reference_cuts(v, ray, enter, leave, cuts);
    v->ray = ray;
    for (size_t i = 0; i < count; i++)
        reference_add(r, cuts[i], i + 1 < count ? cuts[i + 1] : leave, n);
}

static inline struct reference reference_ray(struct reference_volume *v,
                                             const struct brick_transfer *transfer,
                                             const struct brick_ray *ray, double enter, double leave, int n)
{
    struct reference r = {.field = reference_field, .context = v, .transfer = transfer};
    reference_along(&r, v, ray, enter, leave, n);
    return r;
}

#endif
