/* Depth of bricks. In units of bricks of the level the bricks are the unit cells of a lattice, so each is the
 * set of points nearest to its own centre. A ray that goes from one into another crosses the plane between
 * their centres once, and the eye is on the first one's side: its centre is nearer to the eye. That holds for
 * neighbours, and so along the ray; parallel rays are the limit of a far eye. (A brick cut off at the
 * volume's end counts as whole: it lies in its cell.) */
#include "depth.h"

void vr_depth_init(struct vr_depth *depth, const struct brick_grid *grid, uint32_t level,
                   const struct brick_camera *camera)
{
    const struct brick_level *l = &grid->level[level];
    double inverse[3][4];
    brick_affine_invert(grid->affine, inverse);
    depth->parallel = camera->ortho_height_mm > 0.0;
    for (int a = 0; a < 3; a++) {
        const double *m = inverse[a], *eye = camera->eye_mm, *look = camera->look_mm;
        double unit = l->scale[a] * grid->edge;
        if (depth->parallel)
            depth->eye[a] =
                (m[0] * (look[0] - eye[0]) + m[1] * (look[1] - eye[1]) + m[2] * (look[2] - eye[2])) / unit;
        else
            depth->eye[a] = (m[0] * eye[0] + m[1] * eye[1] + m[2] * eye[2] + m[3] - l->offset[a]) / unit;
    }
    depth->bricks[0] = l->bricks[0];
    depth->bricks[1] = l->bricks[1];
}

double vr_depth_of(const struct vr_depth *depth, uint64_t b)
{
    const uint64_t nx = depth->bricks[0], ny = depth->bricks[1];
    const double at[3] = {(double)(b % nx), (double)(b / nx % ny), (double)(b / nx / ny)};
    double squared = 0.0, along = 0.0;
    for (int a = 0; a < 3; a++) {
        double d = at[a] + 0.5 - depth->eye[a];
        squared += d * d;
        along += at[a] * depth->eye[a];
    }
    return depth->parallel ? along : squared;
}
