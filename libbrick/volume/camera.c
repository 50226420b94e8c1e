/* The camera: from eye and field of view to the rays of pixels in level-0 index space.
 *
 * The view is affine in the pixel's position, so a shader and this file share the same coefficients. Angles
 * that are multiples of 90 degrees give directions with exact zeros: rays that look along the axes stay on
 * them. */
#include <brick/camera.h>

#include <math.h>

#define DEFAULT_FOV_DEG 30.0
#define RADIANS         (M_PI / 180.0)

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* False when the vector has no direction that a double can hold. Scaled first, so that its square cannot
 * overflow. */
static bool normalize(double v[3])
{
    double scale = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    if (!(scale > 0.0) || !isfinite(v[0]) || !isfinite(v[1]) || !isfinite(v[2]))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] /= scale;
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return true;
}

static void sin_cos_deg(double deg, double *s, double *c)
{
    int quadrant;
    double rest = remquo(deg, 90.0, &quadrant) * RADIANS;
    double sr = sin(rest), cr = cos(rest);
    switch (quadrant & 3) {
    case 0:
        *s = sr, *c = cr;
        break;
    case 1:
        *s = cr, *c = -sr;
        break;
    case 2:
        *s = -sr, *c = -cr;
        break;
    default:
        *s = -cr, *c = sr;
    }
}

static void to_world(const struct brick_grid *grid, const double index[3], double mm[3])
{
    for (int i = 0; i < 3; i++)
        mm[i] = dot(grid->affine[i], index) + grid->affine[i][3];
}

static double bounding_radius_mm(const struct brick_grid *grid, const double centre_mm[3])
{
    double radius = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        double index[3], mm[3];
        for (int i = 0; i < 3; i++)
            index[i] = (corner >> i & 1) ? (double)grid->dims[i] - 0.5 : -0.5;
        to_world(grid, index, mm);
        for (int i = 0; i < 3; i++)
            mm[i] -= centre_mm[i];
        radius = fmax(radius, sqrt(dot(mm, mm)));
    }
    return radius;
}

void brick_camera_orbit(struct brick_camera *camera, const struct brick_grid *grid, double azimuth_deg,
                        double elevation_deg, double fov_deg, double ortho_height_mm, double aspect)
{
    double centre[3], sin_az, cos_az, sin_el, cos_el;
    for (int i = 0; i < 3; i++)
        centre[i] = ((double)grid->dims[i] - 1.0) / 2.0;
    to_world(grid, centre, camera->look_mm);
    camera->fov_deg = fov_deg > 0.0 ? fov_deg : DEFAULT_FOV_DEG;
    camera->ortho_height_mm = ortho_height_mm > 0.0 ? ortho_height_mm : 0.0;

    double radius = bounding_radius_mm(grid, camera->look_mm);
    double tangent = tan(camera->fov_deg * RADIANS / 2.0) * fmin(1.0, aspect);
    double distance = camera->ortho_height_mm > 0.0 ? 2.0 * radius : radius / sin(atan(tangent));

    sin_cos_deg(azimuth_deg, &sin_az, &cos_az);
    sin_cos_deg(elevation_deg, &sin_el, &cos_el);
    const double towards_eye[3] = {sin_az * cos_el, -cos_az * cos_el, sin_el};
    /* The direction of growing elevation, never parallel to the view. */
    const double up[3] = {-sin_az * sin_el, cos_az * sin_el, cos_el};
    for (int i = 0; i < 3; i++) {
        camera->eye_mm[i] = camera->look_mm[i] + distance * towards_eye[i];
        camera->up[i] = up[i];
    }
}

int brick_view_init(struct brick_view *view, const struct brick_camera *camera, const struct brick_grid *grid,
                    uint32_t width, uint32_t height, struct brick_error *err)
{
    double forward[3], right[3], up[3] = {camera->up[0], camera->up[1], camera->up[2]};
    double inverse[3][4], pixel;
    bool parallel = camera->ortho_height_mm > 0.0;

    if (width == 0 || height == 0)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "camera: a picture of %u x %u pixels", width, height);
    for (int i = 0; i < 3; i++) {
        forward[i] = camera->look_mm[i] - camera->eye_mm[i];
        if (!isfinite(camera->look_mm[i]) || !isfinite(camera->eye_mm[i]))
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "camera: the eye or the point looked at is not finite");
    }
    if (!normalize(forward))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "camera: the eye is at the point it looks at");
    if (!normalize(up))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "camera: the up direction is zero or not finite");
    cross(forward, up, right);
    /* Below this the direction of the cross product is mostly rounding error. */
    if (dot(right, right) < 1e-20 || !normalize(right))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "camera: the up direction is parallel to the view");
    cross(right, forward, up);
    if (parallel) {
        if (!isfinite(camera->ortho_height_mm))
            return brick_fail(err, BRICK_ERR_ARGUMENT, "camera: the picture's height is not finite");
        pixel = camera->ortho_height_mm / height;
    } else {
        if (!(camera->ortho_height_mm <= 0.0 && camera->fov_deg > 0.0 && camera->fov_deg < 180.0))
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "camera: a field of view of %g degrees; it must be above 0 and below 180",
                              camera->fov_deg);
        pixel = 2.0 * tan(camera->fov_deg * RADIANS / 2.0) / height;
    }

    brick_affine_invert(grid->affine, inverse);
    for (int i = 0; i < 3; i++) {
        double u = pixel * dot(inverse[i], right), v = -pixel * dot(inverse[i], up);
        double corner = -(0.5 * width) * u - (0.5 * height) * v;
        double eye = dot(inverse[i], camera->eye_mm) + inverse[i][3];
        double ahead = dot(inverse[i], forward);
        view->origin[i] = parallel ? eye + corner : eye;
        view->origin_u[i] = parallel ? u : 0.0;
        view->origin_v[i] = parallel ? v : 0.0;
        view->dir[i] = parallel ? ahead : ahead + corner;
        view->dir_u[i] = parallel ? 0.0 : u;
        view->dir_v[i] = parallel ? 0.0 : v;
        for (int j = 0; j < 3; j++)
            view->linear[i][j] = grid->affine[i][j];
    }
    return BRICK_OK;
}

void brick_view_ray(const struct brick_view *view, uint32_t column, uint32_t row, struct brick_ray *ray)
{
    double u = column + 0.5, v = row + 0.5;
    double d[3], mm[3];
    for (int i = 0; i < 3; i++) {
        ray->origin[i] = view->origin[i] + u * view->origin_u[i] + v * view->origin_v[i];
        d[i] = view->dir[i] + u * view->dir_u[i] + v * view->dir_v[i];
    }
    for (int i = 0; i < 3; i++)
        mm[i] = dot(view->linear[i], d);
    double length = sqrt(dot(mm, mm));
    for (int i = 0; i < 3; i++)
        ray->direction[i] = d[i] / length;
}

bool brick_ray_span(const struct brick_ray *ray, const struct brick_grid *grid, double *t_enter_mm,
                    double *t_leave_mm)
{
    double enter = 0.0, leave = INFINITY;
    for (int i = 0; i < 3; i++) {
        double lo = -0.5, hi = (double)grid->dims[i] - 0.5;
        double o = ray->origin[i], d = ray->direction[i];
        if (d == 0.0) {
            if (o < lo || o > hi)
                return false;
            continue;
        }
        double a = (lo - o) / d, b = (hi - o) / d;
        double near = a < b ? a : b, far = a < b ? b : a; /* fmin would be a call */
        enter = near > enter ? near : enter;
        leave = far < leave ? far : leave;
    }
    *t_enter_mm = enter;
    *t_leave_mm = leave;
    return enter < leave;
}
