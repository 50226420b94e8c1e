/* The raycaster: one program, which takes a ray as far as a pass may. */
#include "method.h"

#include <stdio.h>

#include "march.h"
#include "shaders.h"

/* What a ray does in one pass, bounded so that 16 rays at once stay below the 65535 turns of loops that
 * llvmpipe allows: 2 loops of samples and leaps (pre-integrated 3), halvings at a hit, leaps to look ahead.
 */
#define STEPS_A_PASS        1500
#define PREINTEGRATED_STEPS 1000

static int draw(void *state, struct vr_frame *frame, struct brick_image *image, struct vr_report *report,
                struct brick_error *err)
{
    static const struct vr_shader_part parts[] = {
        {"exponential.glsl", vr_shader_exponential},
        {"fixed.glsl", vr_shader_fixed},
        {"ray.glsl", vr_shader_ray},
        {"field.glsl", vr_shader_field},
        {"transfer.glsl", vr_shader_transfer},
        {"preintegrated.glsl", vr_shader_preintegrated},
        {"shading.glsl", vr_shader_shading},
        {"feedback.glsl", vr_shader_feedback},
        {"segments.glsl", vr_shader_segments},
        {"state.glsl", vr_shader_state},
        {"march.glsl", vr_shader_march},
        {"raycast.glsl", vr_shader_raycast},
    };
    static const struct vr_program_source source = {.fragment = parts,
                                                    .fragment_count = sizeof parts / sizeof *parts};
    char defines[64];
    if (frame->quality->classification == VR_CLASSIFY_PRE)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "the raycaster classifies values, not voxels");
    snprintf(defines, sizeof defines, "#define STEPS_A_PASS %d\n",
             frame->prefixes ? PREINTEGRATED_STEPS : STEPS_A_PASS);
    return vr_march_draw(state, frame, &source, defines, image, report, err);
}

static void finish(void *state, struct vr_context *context)
{
    vr_march_finish(state, context);
}

const struct vr_method_row vr_raycast = {.state_bytes = sizeof(struct vr_march),
                                         .draw = draw,
                                         .finish = finish,
                                         .filters = true,
                                         .clips = true,
                                         .meshes = true};
