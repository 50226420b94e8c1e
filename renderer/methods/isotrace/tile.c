/* A tile's rays, traced together: to surfaces and meshes, and from there to the light. */
#include "tile.h"

#include <string.h>

/* Rays to the light that wait to be traced together, and what they are for. */
struct shadows {
    const struct vr_iso_picture *picture;
    struct vr_iso_worker *worker;
    double *light[VR_ISO_TILE_PIXELS];
    size_t waiting;
};

static int trace_shadows(struct shadows *s, struct brick_error *err)
{
    struct vr_iso_worker *w = s->worker;
    int code = vr_iso_trace(w->shadow, s->waiting, &w->pin, err);
    for (size_t i = 0; i < s->waiting && !code; i++)
        *s->light[i] = w->shadow[i].transmittance;
    s->waiting = 0;
    return code;
}

/* How much of the light reaches a point: *light, which is 1. */
static int cast_shadow(struct shadows *s, const struct vr_iso_point *point, double *light,
                       struct brick_error *err)
{
    const struct vr_iso_picture *p = s->picture;
    struct brick_ray world, to_light;
    struct vr_mesh_hit hit;
    double enter, leave;
    if (!vr_iso_to_light(&p->shading, point, &world))
        return BRICK_OK;
    if (p->meshes->any && vr_mesh_tree_first(p->meshes->tree, &world, &hit)) {
        *light = 0.0;
        return BRICK_OK;
    }
    if (!vr_iso_shadow_ray(&p->shading, point, &to_light, &enter, &leave) ||
        !vr_clip_span(&p->clip, &to_light, &enter, &leave)) /* what is cut away casts no shadow */
        return BRICK_OK;
    s->light[s->waiting] = light;
    vr_iso_start(&s->worker->shadow[s->waiting], &to_light, enter, leave);
    return ++s->waiting == VR_ISO_TILE_PIXELS ? trace_shadows(s, err) : BRICK_OK;
}

/* On each of the tile's hits and meshes. */
static int cast_shadows(const struct vr_iso_picture *p, struct vr_iso_worker *w, size_t n,
                        struct brick_error *err)
{
    struct shadows shadows = {.picture = p, .worker = w};
    int code = BRICK_OK;
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < w->walk[i].hit_count && !code; k++) {
            struct vr_iso_hit *hit = &w->walk[i].hits[k];
            struct vr_iso_point point = {.ray = &w->ray[i], .t = hit->t};
            vr_iso_normal(&p->shading, hit->gradient, point.normal);
            code = cast_shadow(&shadows, &point, &hit->light, err);
        }
    for (size_t i = 0; i < w->meshes && !code; i++)
        code = cast_shadow(&shadows, &w->mesh[i].point, &w->mesh[i].light, err);
    return code ? code : trace_shadows(&shadows, err);
}

/* Where the pixel's ray, in index space, meets a mesh: mm, INFINITY if it does not. */
static double meet_mesh(const struct vr_iso_picture *p, struct vr_iso_worker *w, uint32_t x, uint32_t y,
                        const struct brick_ray *ray, float *rgba)
{
    const struct vr_mesh_view *meshes = p->meshes;
    struct vr_iso_mesh_pixel *pixel = &w->mesh[w->meshes];
    struct brick_ray world;
    struct vr_mesh_hit hit;
    brick_view_ray(&meshes->world, x, y, &world);
    if (!vr_mesh_tree_first(meshes->tree, &world, &hit))
        return INFINITY;
    *pixel =
        (struct vr_iso_mesh_pixel){.ray = *ray, .point = {&pixel->ray, hit.t_mm}, .light = 1.0, .rgba = rgba};
    memcpy(pixel->point.normal, hit.normal, sizeof hit.normal);
    memcpy(pixel->rgb, hit.rgb, sizeof hit.rgb);
    w->meshes++;
    return hit.t_mm;
}

int vr_iso_tile_draw(const struct vr_iso_picture *p, struct vr_iso_worker *w, uint32_t tile,
                     struct brick_error *err)
{
    const uint32_t x0 = tile % p->tiles_x * VR_ISO_TILE_WIDTH, y0 = tile / p->tiles_x * VR_ISO_TILE_HEIGHT,
                   x1 = x0 + VR_ISO_TILE_WIDTH < p->image->width ? x0 + VR_ISO_TILE_WIDTH : p->image->width,
                   y1 = y0 + VR_ISO_TILE_HEIGHT < p->image->height ? y0 + VR_ISO_TILE_HEIGHT
                                                                   : p->image->height;
    float *rgba[VR_ISO_TILE_PIXELS];
    struct vr_iso_reach reach = {0};
    size_t n = 0;
    w->meshes = 0;
    for (uint32_t y = y0; y < y1; y++) {
        float *row = &p->image->rgba[(size_t)y * p->image->width * 4];
        memset(row + 4 * x0, 0, (x1 - x0) * 4 * sizeof *row);
        for (uint32_t x = x0; x < x1; x++) {
            double enter, leave, end = INFINITY;
            if (x % VR_ISO_BLOCK == 0)
                reach = vr_iso_bounds_of(p->bounds, x, y);
            if (!p->meshes->any && !(reach.near < reach.far))
                continue;
            rgba[n] = row + 4 * x;
            brick_view_ray(&p->view, x, y, &w->ray[n]);
            if (p->meshes->any)
                end = meet_mesh(p, w, x, y, &w->ray[n], rgba[n]);
            if (!brick_ray_span(&w->ray[n], p->frame.grid, &enter, &leave))
                continue;
            leave = end < leave ? end : leave;
            if (!vr_clip_span(&p->clip, &w->ray[n], &enter, &leave))
                continue;
            enter = enter > (double)reach.near ? enter : (double)reach.near;
            leave = leave < (double)reach.far ? leave : (double)reach.far;
            if (!(enter < leave))
                continue;
            vr_iso_start(&w->walk[n], &w->ray[n], enter, leave);
            n++;
        }
    }
    int code = vr_iso_trace(w->walk, n, &w->pin, err);
    vr_iso_now(&w->activity, VR_ISO_SHADING);
    if (!code && p->shading.shadows)
        code = cast_shadows(p, w, n, err);
    for (size_t i = 0; i < n && !code; i++)
        if (w->walk[i].hit_count)
            vr_iso_shade(&p->shading, &w->walk[i], &w->ray[i], rgba[i]);
    for (size_t i = 0; i < w->meshes && !code; i++)
        vr_iso_shade_opaque(&p->shading, &w->mesh[i].point, w->mesh[i].rgb, w->mesh[i].light,
                            w->mesh[i].rgba);
    vr_iso_now(&w->activity, VR_ISO_TRAVERSAL);
    return code;
}
