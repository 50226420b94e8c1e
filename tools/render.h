/* `brick render` in two halves: the request, read and checked, and the pictures drawn for it. */
#ifndef TOOLS_RENDER_H
#define TOOLS_RENDER_H

#include <formats/formats.h>
#include <renderer/renderer.h>

#include "cameras.h"
#include "parse.h"
#include "slices_options.h"

/* The GPU's, in the order of enum vr_method, then those on the CPU. */
enum { METHOD_ISOTRACE = VR_METHODS, METHOD_EXACT };

/* What the command line asks for. */
struct tool_request {
    struct tool_list outputs;
    const char *tf, *path;
    uint32_t turntable;
    struct vr_scene scene;
    struct vr_quality quality;
    struct vr_budget budget;
    struct vr_renderer_params renderer;
    struct fmt_image_params image;
    struct tool_list clip, mesh;
    double clip_box[3][2], mesh_rgb[3];
    struct tool_reals iso, iso_opacity;
    struct vr_isotrace_params isotrace;
    struct tool_slices slices;
    int mode, method, context, field, filter, integration, classification, emission;
    double orbit[2], eye[3], look[3], up[3], fov, ortho, opacity;
    bool has_iso, has_camera, has_eye, has_look, has_up, has_fov, has_ortho;
    bool has_step, has_termination, has_refinements, has_cache, has_context, has_field, has_turntable;
    bool has_opacity, has_emission, has_clip_box, has_integration, has_classification, no_skip, json, quiet;
};

/* A picture for every camera, written to every output; reports: one each. *final: no frame's budget was used
 * up before its end. */
int tool_render_frames(const struct tool_request *request, const struct brick_volume *volume,
                       const struct tool_cameras *cameras, struct vr_report *reports, bool *final,
                       struct brick_error *err);

#endif
