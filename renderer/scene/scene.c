/* One check for all methods, and one set of numbers for the planes: so rays are cut at the same t everywhere.
 */
#include "scene.h"

#include <math.h>

static int check_planes(const struct vr_scene *scene, struct brick_error *err)
{
    if (scene->clip_count > VR_MAX_CLIP_PLANES)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%u clip planes; %d are allowed", scene->clip_count,
                          VR_MAX_CLIP_PLANES);
    for (uint32_t p = 0; p < scene->clip_count; p++) {
        const double *n = scene->clip[p].normal;
        double length = hypot(hypot(n[0], n[1]), n[2]);
        if (!(length > 0.0) || !isfinite(length) || !isfinite(scene->clip[p].offset_mm))
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "clip plane %u has a normal of zero or numbers that are not finite", p);
    }
    return BRICK_OK;
}

int vr_scene_check_parts(const struct vr_scene *scene, struct brick_error *err)
{
    int result = check_planes(scene, err);
    if (!result && scene->mesh_count > VR_MAX_MESHES)
        result = brick_fail(err, BRICK_ERR_ARGUMENT, "%u meshes; %d are allowed", scene->mesh_count,
                            VR_MAX_MESHES);
    for (uint32_t m = 0; !result && m < scene->mesh_count; m++) {
        const struct vr_mesh *mesh = &scene->meshes[m];
        if (!mesh->mesh || !mesh->mesh->triangles)
            result = brick_fail(err, BRICK_ERR_ARGUMENT, "mesh %u has no triangles", m);
        for (int c = 0; c < 3 && !result; c++)
            if (!(mesh->rgb[c] >= 0.0 && mesh->rgb[c] <= 1.0))
                result = brick_fail(err, BRICK_ERR_ARGUMENT, "mesh %u has a colour outside [0,1]", m);
    }
    return result;
}

#define MAX_SAMPLES 2147483648.0

int vr_scene_check_step(const struct brick_grid *grid, double step_mm, struct brick_error *err)
{
    double spacing[3], longest = 0.0;
    brick_grid_spacing_mm(grid, spacing);
    for (int a = 0; a < 3; a++)
        longest += spacing[a] * (double)grid->dims[a];
    return ceil(longest / step_mm) + 1.0 > MAX_SAMPLES
               ? brick_fail(err, BRICK_ERR_ARGUMENT, "a step of %g mm makes more than 2^31 samples a ray",
                            step_mm)
               : BRICK_OK;
}

void vr_scene_normals(const struct brick_grid *grid, const struct brick_level *level, float normals[3][3])
{
    double inverse[3][4], largest = 0.0;
    brick_affine_invert(grid->affine, inverse);
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs(inverse[i / 3][i % 3] / level->scale[i / 3]));
    for (int i = 0; i < 9; i++)
        normals[i % 3][i / 3] = (float)(inverse[i / 3][i % 3] / level->scale[i / 3] / largest);
}

void vr_scene_clip_plane(const struct vr_scene *scene, const struct brick_grid *grid, uint32_t index,
                         double plane[4])
{
    const struct vr_plane *clip = &scene->clip[index];
    for (int a = 0; a < 4; a++) {
        plane[a] = a == 3 ? -clip->offset_mm : 0.0;
        for (int i = 0; i < 3; i++)
            plane[a] += clip->normal[i] * grid->affine[i][a];
    }
}

void vr_scene_level_plane(const struct vr_scene *scene, const struct brick_grid *grid,
                          const struct brick_level *level, uint32_t index, double plane[4])
{
    vr_scene_clip_plane(scene, grid, index, plane);
    for (int a = 0; a < 3; a++) {
        plane[3] += plane[a] * level->offset[a];
        plane[a] *= level->scale[a];
    }
}

void vr_scene_clip(const struct vr_scene *scene, const struct brick_grid *grid, struct vr_clip *clip)
{
    clip->count = scene->clip_count;
    for (uint32_t p = 0; p < clip->count; p++)
        vr_scene_clip_plane(scene, grid, p, clip->plane[p]);
}

bool vr_clip_span(const struct vr_clip *clip, const struct brick_ray *ray, double *t_enter_mm,
                  double *t_leave_mm)
{
    for (uint32_t p = 0; p < clip->count; p++) {
        const double *plane = clip->plane[p];
        double inside = plane[3], slope = 0.0; /* of the kept side's distance, at t = 0 */
        for (int i = 0; i < 3; i++) {
            inside += plane[i] * ray->origin[i];
            slope += plane[i] * ray->direction[i];
        }
        if (slope > 0.0)
            *t_enter_mm = fmax(*t_enter_mm, -inside / slope);
        else if (slope < 0.0)
            *t_leave_mm = fmin(*t_leave_mm, -inside / slope);
        else if (inside < 0.0)
            return false;
    }
    return *t_enter_mm < *t_leave_mm;
}

/* Of a point, or of a direction. */
static void to_world(const struct brick_grid *grid, const double index[3], bool point, double world[3])
{
    for (int i = 0; i < 3; i++) {
        const double *row = grid->affine[i];
        world[i] = row[0] * index[0] + row[1] * index[1] + row[2] * index[2] + (point ? row[3] : 0.0);
    }
}

void vr_scene_world_view(const struct brick_view *view, const struct brick_grid *grid,
                         struct brick_view *world)
{
    *world = (struct brick_view){.linear = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    to_world(grid, view->origin, true, world->origin);
    to_world(grid, view->origin_u, false, world->origin_u);
    to_world(grid, view->origin_v, false, world->origin_v);
    to_world(grid, view->dir, false, world->dir);
    to_world(grid, view->dir_u, false, world->dir_u);
    to_world(grid, view->dir_v, false, world->dir_v);
}
