/* Ray casting in many short passes (Krueger and Westermann 2003, section 2). A round is their two: the
 * intermediate pass (stop.glsl) ends rays, leaps over empty space, and writes depth; the main pass
 * (multipass.glsl) takes a few samples of every ray that the early depth test lets through.
 *
 * As in the paper: what a ray has gathered lives in textures between passes; a pass takes a fixed number of
 * steps; rays that are opaque or have left the volume, and pixels with nothing but empty blocks, cost the
 * main pass nothing; which blocks are empty is found from their smallest and largest values; isosurfaces go
 * back to front within a pass.
 *
 * Otherwise, where hindsight allows: each ray has a sample number of its own, where the paper's pass number
 * was all rays', so that the intermediate pass leaps over empty space of any length, not only of the M steps
 * ahead, and a ray that waits for a brick holds up no other. It goes from block to block, where the paper
 * samples blocks every 8 steps and may miss a corner. The (min,max) table of the transfer function is applied
 * by the host, once for each block when the function changes or the block arrives: a bit a block on the GPU.
 * Textures are read and written in place. A tile whose rays have all ended is not drawn. */
#include "method.h"

#include <stdio.h>

#include "march.h"
#include "shaders.h"

/* Of one pass; see vr_march_far. */
#define LEAPS_A_PASS        1500
#define PREINTEGRATED_STEPS 1000

static int draw(void *state, struct vr_frame *frame, struct brick_image *image, struct vr_report *report,
                struct brick_error *err)
{
    static const struct vr_shader_part stop_parts[] = {VR_MARCH_PARTS, {"stop.glsl", vr_shader_stop}};
    static const struct vr_shader_part main_parts[] = {VR_MARCH_PARTS,
                                                       {"multipass.glsl", vr_shader_multipass}};
    static const struct vr_program_source stop = {.fragment = stop_parts,
                                                  .fragment_count = sizeof stop_parts / sizeof *stop_parts},
                                          main = {.fragment = main_parts,
                                                  .fragment_count = sizeof main_parts / sizeof *main_parts};
    uint32_t steps = frame->quality->pass_steps;
    char leaps_define[64], steps_define[64];
    if (steps < 1 || steps > VR_MAX_PASS_STEPS)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%u steps a pass; 1 to %d are possible", steps,
                          VR_MAX_PASS_STEPS);
    if (frame->prefixes && steps > PREINTEGRATED_STEPS)
        steps = PREINTEGRATED_STEPS;
    snprintf(leaps_define, sizeof leaps_define, "#define LEAPS_A_PASS %d\n", LEAPS_A_PASS);
    snprintf(steps_define, sizeof steps_define, "#undef SKIP\n#define STEPS_A_PASS %u\n", steps);
    const struct vr_march_pass passes[] = {{&stop, leaps_define, VR_TARGET_DEPTH_WRITE},
                                           {&main, steps_define, VR_TARGET_DEPTH_TEST}};
    return vr_march_draw(state, frame, passes, 2, image, report, err);
}

static void finish(void *state, struct vr_context *context)
{
    vr_march_finish(state, context);
}

const struct vr_method_row vr_multipass = {.state_bytes = sizeof(struct vr_march),
                                           .draw = draw,
                                           .finish = finish,
                                           .filters = true,
                                           .clips = true,
                                           .meshes = true};
