/* Rays cast on the CPU, without OpenGL: the raycast method for dvr, shaded and mip. It takes the samples that
 * the shaders take (shaders/raycast.glsl) and does the same to them, so where OpenGL rounds as IEEE 754 does
 * the pictures have the same bytes. Bricks come through the host cache. */
#ifndef RENDERER_CAST_CAST_H
#define RENDERER_CAST_CAST_H

#include <renderer/renderer.h>

struct vr_caster;

/* Of params: host_cache_bytes and threads. No more threads run than the cache has bricks. */
int vr_caster_create(struct vr_caster **caster, const struct brick_volume *volume,
                     const struct vr_renderer_params *params, struct brick_error *err);
void vr_caster_destroy(struct vr_caster **caster);

/* BRICK_OK, or BRICK_ERR_UNSUPPORTED with what it is that is not drawn here. */
int vr_caster_check(const struct vr_scene *scene, const struct vr_quality *quality, struct brick_error *err);
/* The image has the scene's size. */
int vr_cast(struct vr_caster *caster, const struct vr_scene *scene, const struct vr_quality *quality,
            struct brick_image *image, struct vr_report *report, struct brick_error *err);

#endif
