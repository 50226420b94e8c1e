/* Where parameters start from. */
#include <renderer/renderer.h>

const struct vr_scene vr_scene_defaults = {
    .mode = BRICK_MODE_DVR,
    .iso_rgb = {0.85, 0.8, 0.7},
    .camera = {.fov_deg = 30.0},
    .width = 512,
    .height = 512,
    .ambient = 0.2,
    .diffuse = 0.7,
    .specular = 0.3,
    .shininess = 20.0,
};

const struct vr_quality vr_quality_defaults = {
    .step_vox = 0.5,
    .termination = 1e-4,
    .skip = true,
    .refinements = 8,
    .slices = {.planes = VR_PLANES_PAPER, .framebuffer = VR_FRAMEBUFFER_32F, .classified_bits = 32},
    .pass_steps = 64,
};

const struct vr_renderer_params vr_renderer_defaults = {
    .context = VR_CONTEXT_AUTO,
    .gpu_cache_bytes = UINT64_C(256) << 20,
    .host_cache_bytes = UINT64_C(1) << 30,
};
