/* The renderer: a scene checked, and given to who draws it: OpenGL or, if that is asked for, the processor.
 */
#include <renderer/renderer.h>

#include <math.h>
#include <stdlib.h>

#include "cast.h"
#include "drawing.h"
#include "scene.h"

struct vr_renderer {
    const struct brick_volume *volume;
    struct vr_drawing *drawing; /* one of these */
    struct vr_caster *caster;

    /* The picture at hand, while `open`. */
    bool open;
    struct vr_scene scene;
    struct vr_quality quality;
};

int vr_renderer_create(struct vr_renderer **out, const struct brick_volume *volume,
                       const struct vr_renderer_params *params, struct brick_error *err)
{
    struct vr_renderer *r = calloc(1, sizeof *r);
    *out = NULL;
    if (!r)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the renderer");
    r->volume = volume;
    int result = BRICK_OK;
    if (params->context != VR_CONTEXT_CPU)
        result = vr_drawing_create(&r->drawing, volume, params, err);
    else if (params->filter == VR_FILTER_FAST)
        result = brick_fail(err, BRICK_ERR_UNSUPPORTED, "without OpenGL there is no fast filter");
    else
        result = vr_caster_create(&r->caster, volume, params, err);
    if (result)
        vr_renderer_destroy(&r);
    *out = r;
    return result;
}

void vr_renderer_destroy(struct vr_renderer **renderer)
{
    struct vr_renderer *r = *renderer;
    if (!r)
        return;
    vr_drawing_destroy(&r->drawing);
    vr_caster_destroy(&r->caster);
    free(r);
    *renderer = NULL;
}

bool vr_prefers_cpu(const struct vr_scene *scene, const struct vr_quality *quality,
                    const struct vr_renderer_params *params)
{
    return params->context == VR_CONTEXT_AUTO && params->filter == VR_FILTER_EXACT &&
           quality->setup == VR_SETUP_BOX && !vr_caster_check(scene, quality, NULL) && !vr_drawing_has_gpu();
}

static int check_scene(const struct vr_renderer *r, const struct vr_scene *scene,
                       const struct vr_quality *quality, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(r->volume);
    if ((unsigned)quality->method >= VR_METHODS)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "method %d does not exist", (int)quality->method);
    if ((unsigned)quality->setup > VR_SETUP_GEOMETRY)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "ray set-up %d does not exist", (int)quality->setup);
    if ((unsigned)quality->classification > VR_CLASSIFY_PREINTEGRATED)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "classification %d does not exist",
                          (int)quality->classification);
    if ((unsigned)scene->mode > BRICK_MODE_MIP)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "mode %d does not exist", (int)scene->mode);
    if (scene->mode != BRICK_MODE_ISO && !scene->transfer)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "this mode needs a transfer function");
    if (scene->mode == BRICK_MODE_ISO && !isfinite(scene->isovalue))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the isovalue is not finite");
    if (scene->level >= grid->levels)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "there is no level %u; the last is %u", scene->level,
                          grid->levels - 1);
    if (quality->distances && (scene->mode != BRICK_MODE_ISO || scene->mesh_count))
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "distances are of isosurfaces, without meshes");
    if (!(quality->step_vox > 0.0 && quality->step_vox <= 0x1p30))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "a step of %g voxels; it must be above 0 and at most 2^30",
                          quality->step_vox);
    if (!(quality->termination >= 0.0 && quality->termination < 1.0))
        return brick_fail(err, BRICK_ERR_ARGUMENT, "a termination at %g; it must be in [0, 1)",
                          quality->termination);
    return vr_scene_check_parts(scene, err);
}

int vr_render_begin(struct vr_renderer *r, const struct vr_scene *scene, const struct vr_quality *quality,
                    struct brick_error *err)
{
    int result = check_scene(r, scene, quality, err);
    r->open = false;
    if (result)
        return result;
    r->scene = *scene;
    r->quality = *quality;
    result = r->caster ? vr_caster_check(&r->scene, &r->quality, err)
                       : vr_drawing_begin(r->drawing, &r->scene, &r->quality, err);
    r->open = !result;
    return result;
}

int vr_render_continue(struct vr_renderer *r, const struct vr_budget *budget, struct brick_image *image,
                       bool *final, struct vr_report *report, struct brick_error *err)
{
    if (!r->open)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "no picture has been begun, or it is final");
    if (r->scene.width != image->width || r->scene.height != image->height || !image->rgba)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the image has %u x %u pixels, the scene %u x %u",
                          image->width, image->height, r->scene.width, r->scene.height);
    *final = true;
    int result = r->caster ? vr_cast(r->caster, &r->scene, &r->quality, image, report, err)
                           : vr_drawing_continue(r->drawing, budget, image, final, report, err);
    r->open = !result && !*final;
    return result;
}

int vr_render(struct vr_renderer *renderer, const struct vr_scene *scene, const struct vr_quality *quality,
              struct brick_image *image, struct vr_report *report, struct brick_error *err)
{
    bool final;
    int result = vr_render_begin(renderer, scene, quality, err);
    return result ? result : vr_render_continue(renderer, NULL, image, &final, report, err);
}
