/* The raycaster: one program, which takes a ray as far as a pass may. */
#include "method.h"

#include <stdio.h>

#include "march.h"
#include "shaders.h"

/* What a ray does in one pass, bounded so that 16 rays at once stay below the 65535 turns of loops that
 * llvmpipe allows: 2 loops of samples and leaps, halvings at a hit, leaps to look ahead. */
#define STEPS_A_PASS 1500

static int draw(void *state, struct vr_frame *frame, struct brick_image *image, struct vr_report *report,
                struct brick_error *err)
{
    static const struct vr_shader_part parts[] = {VR_MARCH_PARTS, {"raycast.glsl", vr_shader_raycast}};
    static const struct vr_program_source source = {.fragment = parts,
                                                    .fragment_count = sizeof parts / sizeof *parts};
    char defines[64];
    snprintf(defines, sizeof defines, "#define STEPS_A_PASS %d\n", STEPS_A_PASS);
    const struct vr_march_pass pass = {&source, defines, VR_TARGET_DEPTH_OFF};
    return vr_march_draw(state, frame, &pass, 1, image, report, err);
}

static void finish(void *state, struct vr_context *context)
{
    vr_march_finish(state, context);
}

const struct vr_method_row vr_raycast = {
    .state_bytes = sizeof(struct vr_march), .draw = draw, .finish = finish, .clips = true, .meshes = true};
