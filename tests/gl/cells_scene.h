/* What the tests of projected cells share: a volume of waves, views of it, the exact picture, and how right
 * cells are.
 *
 * Parallel views: two kinds of error are allowed. Rounding: scalars and lengths that the rasteriser
 * interpolates, right to some 1e-6 of a voxel's step, and sums of some 100 float32 terms. And where a ray
 * passes within 1/256 pixel of a tetrahedron's outline, since corners are rounded to that: a tetrahedron then
 * counts that the ray misses, or not one that it meets, by its length so near to where it is 0: a miss.
 *
 * Perspective: only rounding. Where rays enter and leave is right to a float's rounding of a part of a voxel,
 * and blending rounds once a cell, of which a ray meets NX + NY + NZ + 3 at most. */
#ifndef TESTS_CELLS_SCENE_H
#define TESTS_CELLS_SCENE_H

#include "gl_scene.h"

#define NX   37
#define NY   30
#define NZ   41
#define EDGE 64

/* In perspective. One ulp below 1 a cell; in the mean square they add up as noise does. */
#define CELLS_ROUNDING ((NX + NY + NZ + 3) * 0x1p-24)
#define CELLS_NOISE    (10.6 * 0x1p-24)

/* Extinction up to 0.23 a mm. */
extern const struct brick_transfer_point cells_points[4];

/* A volume of waves on oblique axes; voxels is room for it. */
struct brick_volume *wave_volume(struct memory_source *source, enum brick_type type, int nx, int ny, int nz,
                                 void *voxels, double slope, double intercept, uint32_t edge);

/* Pictures of EDGE x EDGE. */
void look(struct vr_scene *scene, const struct brick_volume *volume, double azimuth, double elevation,
          bool perspective);

/* Of the field on tetrahedra. */
struct brick_image exact_of(const struct brick_volume *volume, const struct vr_scene *scene);

/* Asserts that the picture, integrated exactly, is as right as above, and that it shows something. */
void against_exact(struct vr_renderer *renderer, const struct brick_volume *volume,
                   const struct vr_scene *scene, const char *what);

/* What a test of one volume has. */
struct fixture {
    struct memory_source source;
    struct brick_volume *volume;
    struct brick_transfer *transfer;
    struct vr_renderer *renderer; /* NULL: skip */
    struct vr_scene scene;
    struct vr_quality quality;
};

void fixture_init(struct fixture *f, enum brick_type type, void *voxels);
void fixture_finish(struct fixture *f);

#endif
