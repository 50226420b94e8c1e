/* A pixel's ray and its samples: shaders/ray.glsl for the CPU, the same numbers. */
#ifndef RENDERER_CAST_RAY_H
#define RENDERER_CAST_RAY_H

#include <brick/camera.h>

#include "fixed.h"
#include "scene.h"

/* What the rays of a picture have in common. */
struct vr_cast_set {
    const struct brick_grid *grid;
    const struct brick_level *level;
    double per_voxel[3]; /* 1 / level->scale: exact, powers of 2 */
    struct brick_view view;
    struct vr_clip clip;
    double step_mm;
    bool interleaved;
    bool cut; /* a ray's first piece may be shorter */
};

/* Samples 0 to count - 1, each in the middle of its piece. All pieces are of one length but the last and,
 * where rays are cut, the first; their samples are not where steps lead. */
struct vr_cast_ray {
    struct vr_fixed first[3], step[3]; /* level's index space; sample k is at first + k step */
    double start[3], stride[3];        /* the same from where steps are counted from */
    double cut, last; /* in steps from there: sample 0 of a ray that is cut, sample count - 1 */
    uint32_t count;
    float length_mm, begin_length_mm, last_length_mm;
    float pace[3],
        never[3]; /* steps a voxel on each axis; where it does not move along one 0 and a huge number */
    bool forward[3];
    float view[3];   /* world direction, unit */
    double enter_mm; /* t of the way into the volume */
};

/* The pixel's ray, as far as end_mm. False when there is nothing on it. */
bool vr_cast_ray_init(const struct vr_cast_set *set, uint32_t column, uint32_t row, double end_mm,
                      struct vr_cast_ray *ray);

/* Is sample k one that steps do not lead to? */
static inline bool vr_cast_ray_is_end(const struct vr_cast_set *set, const struct vr_cast_ray *ray,
                                      uint32_t k)
{
    return k + 1 == ray->count || (set->cut && k == 0);
}

static inline struct vr_fixed vr_cast_ray_end(const struct vr_cast_ray *ray, int axis, uint32_t k)
{
    return vr_fixed_from(ray->start[axis] + (k + 1 == ray->count ? ray->last : ray->cut) * ray->stride[axis]);
}

static inline struct vr_fixed vr_cast_ray_sample(const struct vr_cast_set *set, const struct vr_cast_ray *ray,
                                                 int axis, uint32_t k)
{
    return vr_cast_ray_is_end(set, ray, k) ? vr_cast_ray_end(ray, axis, k)
                                           : vr_fixed_after(ray->first[axis], ray->step[axis], k);
}

static inline float vr_cast_ray_length(const struct vr_cast_set *set, const struct vr_cast_ray *ray,
                                       uint32_t k)
{
    return k + 1 == ray->count  ? ray->last_length_mm
           : set->cut && k == 0 ? ray->begin_length_mm
                                : ray->length_mm;
}

#endif
