/* The camera, and the rays of its pixels.
 *
 * Azimuth 0, elevation 0 looks from anterior (-y) along +y with +z up; azimuth turns the eye towards +x,
 * elevation towards +z. Rays pass pixel centres; row 0 is on top; +x of the picture is to the right as the
 * viewer sees it. */
#ifndef BRICK_CAMERA_H
#define BRICK_CAMERA_H

#include <stdbool.h>
#include <stdint.h>

#include <brick/error.h>
#include <brick/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

struct brick_camera {
    double eye_mm[3];
    double look_mm[3];      /* the point aimed at; differs from the eye */
    double up[3];           /* not parallel to the view */
    double fov_deg;         /* vertical, (0, 180); ignored when ortho_height_mm > 0 */
    double ortho_height_mm; /* picture height in mm for a parallel projection; 0: perspective */
};

/* Aim at the box's centre from azimuth and elevation in degrees, at the distance where the box's bounding
 * sphere fits the picture. fov_deg <= 0: 30. ortho_height_mm > 0: parallel. aspect = width / height. */
void brick_camera_orbit(struct brick_camera *camera, const struct brick_grid *grid, double azimuth_deg,
                        double elevation_deg, double fov_deg, double ortho_height_mm, double aspect);

/* Rays in level-0 index space. The ray of pixel (column c, row r), at pixel centre u = c + 1/2, v = r + 1/2:
 *   position(t) = origin + u * origin_u + v * origin_v + t * d / |M d|,   d = dir + u * dir_u + v * dir_v,
 * with M the linear part of the affine, so that t is in mm from the eye (perspective) or the eye plane
 * (parallel); t >= 0. */
struct brick_view {
    double origin[3], origin_u[3], origin_v[3];
    double dir[3], dir_u[3], dir_v[3];
    double linear[3][3]; /* M: index steps -> mm */
};

/* BRICK_ERR_ARGUMENT for a degenerate camera (eye = look, up parallel to the view, fov or height out of
 * range, anything not finite). */
int brick_view_init(struct brick_view *view, const struct brick_camera *camera, const struct brick_grid *grid,
                    uint32_t width, uint32_t height, struct brick_error *err);

struct brick_ray {
    double origin[3];    /* index0 coordinates at t = 0 */
    double direction[3]; /* index0 units per mm */
};
void brick_view_ray(const struct brick_view *view, uint32_t column, uint32_t row, struct brick_ray *ray);

/* Part of the ray inside level 0's box [-1/2, n-1/2], t >= 0. False when it misses. */
bool brick_ray_span(const struct brick_ray *ray, const struct brick_grid *grid, double *t_enter_mm,
                    double *t_leave_mm);

#ifdef __cplusplus
}
#endif
#endif
