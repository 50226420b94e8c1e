/* Blinn-Phong, two-sided, and shadows. With the light at the eye it is shaders/shading.glsl, in double.
 *
 * A shadow ray starts one voxel edge from its hit: nearer, the hit's own cell, whose facets are not quite
 * where the smooth normal says they are, would speckle the surface with its own shadow. */
#include "shade.h"

#include <math.h>

#include "vector.h"

static bool normalize(double v[3])
{
    double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    if (!(largest > 0.0))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] /= largest;
    double length = sqrt(vr_dot(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return true;
}

/* A light that casts shadows to be seen: from the eye, half as far again up and to the left. */
static void over_the_shoulder(const struct brick_camera *c, double light[3])
{
    double back[3], up[3], left[3];
    for (int i = 0; i < 3; i++) {
        back[i] = c->eye_mm[i] - c->look_mm[i];
        up[i] = c->up[i];
    }
    normalize(back);
    for (int i = 0; i < 3; i++)
        left[i] = back[(i + 1) % 3] * up[(i + 2) % 3] - back[(i + 2) % 3] * up[(i + 1) % 3];
    normalize(left);
    for (int i = 0; i < 3; i++)
        up[i] = left[(i + 1) % 3] * back[(i + 2) % 3] - left[(i + 2) % 3] * back[(i + 1) % 3];
    for (int i = 0; i < 3; i++)
        light[i] = back[i] + 0.5 * up[i] + 0.5 * left[i];
}

void vr_iso_shading_init(struct vr_iso_shading *s, const struct brick_grid *grid,
                         const struct vr_scene *scene, const struct vr_isotrace_params *params)
{
    const struct brick_level *level = &grid->level[scene->level];
    double inverse[3][4], spacing[3];
    *s = (struct vr_iso_shading){.grid = grid,
                                 .ambient = scene->ambient,
                                 .diffuse = scene->diffuse,
                                 .specular = scene->specular,
                                 .shininess = scene->shininess,
                                 .headlight = !params->lit && !params->shadows,
                                 .shadows = params->shadows};
    brick_affine_invert(grid->affine, inverse);
    brick_grid_spacing_mm(grid, spacing);
    s->shadow_start_mm = INFINITY;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            s->linear[i][j] = grid->affine[i][j];
            s->normal[i][j] = inverse[j][i] / level->scale[j];
        }
        s->shadow_start_mm = fmin(s->shadow_start_mm, spacing[i] * level->scale[i]);
        s->light[i] = params->light[i];
    }
    if (s->headlight)
        return;
    if (!params->lit)
        over_the_shoulder(&scene->camera, s->light);
    normalize(s->light);
    for (int i = 0; i < 3; i++)
        s->light_direction[i] = vr_dot(inverse[i], s->light);
}

void vr_iso_normal(const struct vr_iso_shading *s, const double gradient[3], double normal[3])
{
    for (int i = 0; i < 3; i++)
        normal[i] = vr_dot(s->normal[i], gradient);
}

/* The normal made a unit and turned to the eye, and its cosine with the light. False: there is none, or it
 * faces away. */
static bool facing_light(const struct vr_iso_shading *s, const double view[3], double n[3], double *diffuse)
{
    if (!normalize(n))
        return false;
    double side = vr_dot(n, view) > 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < 3; i++)
        n[i] *= side;
    *diffuse = s->headlight ? -vr_dot(n, view) : vr_dot(n, s->light);
    *diffuse = fmax(0.0, fmin(*diffuse, 1.0));
    return *diffuse > 0.0;
}

/* x^n; most exponents are small integers, for which pow is slow. */
static double power(double x, double n)
{
    if (!(n >= 0.0 && n < 256.0 && n == floor(n)))
        return pow(x, n);
    double product = 1.0;
    for (unsigned i = (unsigned)n; i; i >>= 1, x *= x)
        if (i & 1)
            product *= x;
    return product;
}

static void view_of(const struct vr_iso_shading *s, const struct brick_ray *ray, double view[3])
{
    for (int i = 0; i < 3; i++)
        view[i] = vr_dot(s->linear[i], ray->direction);
}

bool vr_iso_to_light(const struct vr_iso_shading *s, const struct vr_iso_point *point,
                     struct brick_ray *world)
{
    double view[3], n[3] = {point->normal[0], point->normal[1], point->normal[2]}, diffuse, at[3];
    view_of(s, point->ray, view);
    if (!facing_light(s, view, n, &diffuse))
        return false;
    for (int i = 0; i < 3; i++)
        at[i] = point->ray->origin[i] + point->t * point->ray->direction[i];
    for (int i = 0; i < 3; i++) {
        world->origin[i] =
            vr_dot(s->linear[i], at) + s->grid->affine[i][3] + s->shadow_start_mm * s->light[i];
        world->direction[i] = s->light[i];
    }
    return true;
}

bool vr_iso_shadow_ray(const struct vr_iso_shading *s, const struct vr_iso_point *point,
                       struct brick_ray *to_light, double *enter_mm, double *leave_mm)
{
    for (int i = 0; i < 3; i++) {
        to_light->origin[i] = point->ray->origin[i] + point->t * point->ray->direction[i];
        to_light->direction[i] = s->light_direction[i];
    }
    if (!brick_ray_span(to_light, s->grid, enter_mm, leave_mm))
        return false;
    *enter_mm = fmax(*enter_mm, s->shadow_start_mm);
    return *enter_mm < *leave_mm;
}

/* normal: in the world, of any length */
static void shade_point(const struct vr_iso_shading *s, const double view[3], const double normal[3],
                        const double rgb[3], double light, double out[3])
{
    double n[3] = {normal[0], normal[1], normal[2]}, half[3], diffuse = 0.0, shine = 0.0;
    if (facing_light(s, view, n, &diffuse)) {
        double highlight = diffuse;
        if (!s->headlight) {
            for (int i = 0; i < 3; i++)
                half[i] = s->light[i] - view[i];
            highlight = normalize(half) ? fmax(0.0, fmin(vr_dot(n, half), 1.0)) : 0.0;
        }
        if (highlight > 0.0 && s->specular > 0.0)
            shine = s->specular * power(highlight, s->shininess);
    }
    for (int c = 0; c < 3; c++)
        out[c] = rgb[c] * (s->ambient + light * s->diffuse * diffuse) + light * shine;
}

void vr_iso_shade_opaque(const struct vr_iso_shading *s, const struct vr_iso_point *point,
                         const double rgb[3], double light, float rgba[4])
{
    double view[3], colour[3];
    view_of(s, point->ray, view);
    shade_point(s, view, point->normal, rgb, light, colour);
    for (int c = 0; c < 3; c++)
        rgba[c] = (float)((double)rgba[c] + (1.0 - (double)rgba[3]) * colour[c]);
    rgba[3] = 1.0f;
}

void vr_iso_shade(const struct vr_iso_shading *s, const struct vr_iso_walk *walk, const struct brick_ray *ray,
                  float rgba[4])
{
    double sum[3] = {0, 0, 0}, transmittance = 1.0, view[3];
    view_of(s, ray, view);
    for (size_t i = 0; i < walk->hit_count; i++) {
        const struct vr_iso_hit *hit = &walk->hits[i];
        double opacity = walk->frame->surface[hit->surface].opacity, normal[3], colour[3];
        vr_iso_normal(s, hit->gradient, normal);
        shade_point(s, view, normal, s->rgb[hit->surface], hit->light, colour);
        for (int c = 0; c < 3; c++)
            sum[c] += transmittance * opacity * colour[c];
        transmittance *= 1.0 - opacity;
    }
    for (int c = 0; c < 3; c++)
        rgba[c] = (float)sum[c];
    rgba[3] = (float)(1.0 - transmittance);
}
