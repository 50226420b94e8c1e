/* Why: `brick render`: from a .brick file to pictures. Everything that can be checked without the volume is
 * checked before it is opened, so that a typing mistake costs no render. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <brick/threads.h>
#include <formats/formats.h>
#include <renderer/renderer.h>

#include "command.h"
#include "message.h"
#include "options.h"
#include "render.h"
#include "render_report.h"

/* Mode, method, set-up, offset, refinement, field, classification, emission and context are in the order of
 * their enums. */
static const char *const modes[] = {"dvr", "shaded", "iso", "mip", NULL};
static const char *const methods[] = {"raycast", "multipass", "slices", "cells", "isotrace", "exact", NULL};
static const char *const setups[] = {"box", "geometry", NULL};
static const char *const offsets[] = {"none", "interleaved", NULL};
static const char *const refines[] = {"bisection", "cubic", NULL};
static const char *const contexts[] = {"auto", "egl", "osmesa", "cpu", NULL};
static const char *const fields[] = {"trilinear", "tetrahedra", "preclassified", NULL};
static const char *const integrations[] = {"prefix", "exact", "psi", "exp", "average", "scalar", NULL};
static const char *const classifications[] = {"post", "pre", "preintegrated", NULL};
static const char *const emissions[] = {"scaled", "independent", NULL};
static const char *const filters[] = {"exact", "fast", NULL};

/* -1, or the exit code of a usage error. */
static int check_isotrace(const struct tool_request *request)
{
    if (request->method != METHOD_ISOTRACE) {
        if (request->iso.count > 1 || request->has_opacity || request->isotrace.lit ||
            request->isotrace.shadows)
            return tool_misuse(
                "render", "several --iso, --iso-opacity, --light and --shadows go with --method isotrace");
        return -1;
    }
    if (request->mode != BRICK_MODE_ISO)
        return tool_misuse("render", "--method isotrace renders --mode iso only");
    if (request->has_opacity && request->iso_opacity.count != request->iso.count)
        return tool_misuse("render", "--iso-opacity needs as many numbers as --iso");
    if (request->has_step || request->has_refinements)
        return tool_misuse("render", "--method isotrace has no --step or --refinements");
    if (request->has_cache || request->has_context)
        return tool_misuse("render", "--method isotrace runs on the CPU, without --gpu-cache and --context");
    return -1;
}

/* -1, or the exit code of a usage error. */
static int check_cells(const struct tool_request *request)
{
    if (request->method != VR_METHOD_CELLS)
        return request->has_integration
                   ? tool_misuse("render", "--cells-integration goes with --method cells")
                   : -1;
    if (request->mode != BRICK_MODE_DVR)
        return tool_misuse("render", "--method cells renders --mode dvr only");
    if (request->has_step || request->has_termination || request->has_classification)
        return tool_misuse("render", "--method cells has no --step, --termination or --classification");
    return -1;
}

/* -1, or the exit code of a usage error. */
static int check_classification(const struct tool_request *request)
{
    if (request->has_classification && request->method >= VR_METHODS)
        return tool_misuse("render", "--classification goes with the methods on the GPU");
    if (request->classification == VR_CLASSIFY_PRE &&
        (request->method != VR_METHOD_SLICES || request->mode != BRICK_MODE_DVR))
        return tool_misuse("render", "--classification pre goes with --method slices and --mode dvr");
    if (request->slices.has_bits && request->classification != VR_CLASSIFY_PRE)
        return tool_misuse("render", "--classified-bits goes with --classification pre");
    if (request->classification == VR_CLASSIFY_PREINTEGRATED && request->mode != BRICK_MODE_DVR &&
        request->mode != BRICK_MODE_SHADED)
        return tool_misuse("render", "--classification preintegrated goes with --mode dvr or shaded");
    return -1;
}

/* -1, or the exit code of a usage error. */
static int check_request(const struct tool_request *request)
{
    const bool iso = request->mode == BRICK_MODE_ISO;
    const bool marches = request->method == VR_METHOD_RAYCAST || request->method == VR_METHOD_MULTIPASS;
    if (iso && !request->has_iso)
        return tool_misuse("render", "--mode iso needs --iso V");
    if (!iso && request->has_iso)
        return tool_misuse("render", "--iso goes with --mode iso");
    if (!iso && (request->has_refinements || request->has_refine))
        return tool_misuse("render", "--refine and --refinements go with --mode iso");
    if (request->refine && request->has_refinements)
        return tool_misuse("render", "--refinements goes with --refine bisection");
    if (request->has_refine && !marches)
        return tool_misuse("render", "--refine goes with --method raycast or multipass");
    if (request->has_camera && (request->has_eye || request->has_look || request->has_up))
        return tool_misuse("render", "--camera goes without --eye, --look and --up");
    if (!request->has_eye && (request->has_look || request->has_up))
        return tool_misuse("render", "--look and --up go with --eye");
    if (request->has_turntable && (request->has_eye || request->path))
        return tool_misuse("render", "--turntable goes without --eye and --path");
    if (request->path && (request->has_eye || request->has_camera))
        return tool_misuse("render", "--path goes without --camera and --eye");
    if (request->has_fov && request->has_ortho)
        return tool_misuse("render", "--fov and --ortho exclude each other");
    if ((request->has_setup || request->offset) && !marches)
        return tool_misuse("render", "--setup and --offset go with --method raycast or multipass");
    if (request->has_pass_steps && request->method != VR_METHOD_MULTIPASS)
        return tool_misuse("render", "--pass-steps goes with --method multipass");
    if (request->method == METHOD_EXACT) {
        if (request->has_step || request->has_termination || request->no_skip || request->has_refinements)
            return tool_misuse("render",
                               "--method exact has no --step, --termination, --refinements or --no-skip");
        if (request->field == VR_FIELD_PRECLASSIFIED && request->mode != BRICK_MODE_DVR &&
            request->mode != BRICK_MODE_SHADED)
            return tool_misuse("render", "--field preclassified goes with --mode dvr or shaded");
        if (request->has_cache || request->has_context)
            return tool_misuse("render", "--method exact runs on the CPU, without --gpu-cache and --context");
    } else if (request->has_field) {
        return tool_misuse("render", "--field goes with --method exact");
    }
    if (request->filter == VR_FILTER_FAST && request->method >= VR_METHODS)
        return tool_misuse("render", "--filter fast goes with methods on the GPU");
    if (request->budget.seconds > 0.0 && !marches)
        return tool_misuse("render", "--budget goes with --method raycast or multipass");
    const bool slices = request->method == VR_METHOD_SLICES;
    if (request->has_emission && ((!slices && request->method != METHOD_EXACT) ||
                                  (request->mode != BRICK_MODE_DVR && request->mode != BRICK_MODE_SHADED)))
        return tool_misuse("render", "--emission goes with --method slices or exact, --mode dvr or shaded");
    const char *wrong =
        tool_slices_check(&request->slices, slices, request->has_step, request->has_termination);
    if (wrong)
        return tool_misuse("render", "%s", wrong);
    int code = check_cells(request);
    if (code < 0)
        code = check_classification(request);
    if (request->context == VR_CONTEXT_CPU && (request->has_cache || request->budget.seconds > 0.0))
        return tool_misuse("render", "--gpu-cache and --budget go with OpenGL, not with --context cpu");
    return code < 0 ? check_isotrace(request) : code;
}

static int place_cameras(const struct tool_request *request, const struct brick_grid *grid,
                         struct tool_cameras *cameras, struct brick_error *err)
{
    const struct tool_view view = {request->orbit[0], request->orbit[1], request->fov, request->ortho,
                                   (double)request->scene.width / request->scene.height};
    if (request->path)
        return tool_cameras_load(cameras, request->path, grid, &view, err);
    int code =
        tool_cameras_turntable(cameras, grid, &view, request->has_turntable ? request->turntable : 1, err);
    if (code || !request->has_eye)
        return code;
    struct brick_camera *camera = cameras->item;
    memcpy(camera->eye_mm, request->eye, sizeof camera->eye_mm);
    if (request->has_look)
        memcpy(camera->look_mm, request->look,
               sizeof camera->look_mm); /* else the box's centre, from the orbit */
    memcpy(camera->up, request->up, sizeof camera->up);
    return BRICK_OK;
}

/* -1, or the exit code of a usage error. A box is six planes. */
static int read_clip_planes(const struct tool_request *request, struct vr_scene *scene)
{
    static const struct tool_limits any = {0};
    const struct tool_list *list = &request->clip;
    uint32_t count = 0;
    if (list->count + (request->has_clip_box ? 6 : 0) > VR_MAX_CLIP_PLANES)
        return tool_misuse("render", "%d clip planes are possible, of which --clip-box is six",
                           VR_MAX_CLIP_PLANES);
    for (size_t i = 0; i < list->count; i++) {
        double plane[4];
        const char *wrong = tool_parse_plane(list->item[i], plane, &any);
        if (wrong)
            return tool_misuse("render", "--clip '%s' %s", list->item[i], wrong);
        memcpy(scene->clip[count].normal, plane, sizeof scene->clip[count].normal);
        scene->clip[count++].offset_mm = plane[3];
    }
    for (int side = 0; request->has_clip_box && side < 6; side++) {
        double sign = side % 2 ? -1.0 : 1.0;
        scene->clip[count].normal[side / 2] = sign;
        scene->clip[count++].offset_mm = sign * request->clip_box[side / 2][side % 2];
    }
    scene->clip_count = count;
    return -1;
}

static void print_summary(const struct tool_request *request, const struct vr_report *reports, size_t count,
                          bool final, double seconds)
{
    const struct vr_report sum = tool_render_sum(reports, count);
    fprintf(stderr, "%s: %s, %llu of %llu bricks visible, frame %.3f s, all %.3f s%s%s%s\n",
            request->outputs.item[0], modes[request->mode], (unsigned long long)sum.bricks_active,
            (unsigned long long)sum.bricks_total, sum.seconds_frame, seconds, final ? "" : ", not final",
            request->method < VR_METHODS ? ", " : "",
            sum.gl_renderer[0]             ? sum.gl_renderer
            : request->method < VR_METHODS ? "without OpenGL"
                                           : "");
}

static int render(const struct tool_request *request, const char *path)
{
    struct brick_volume *volume = NULL;
    struct tool_cameras cameras = {0};
    struct vr_report *reports = NULL;
    struct brick_error err = {0};
    uint64_t start_ns = brick_now_ns();
    bool final = true;

    int code = 0;
    for (size_t i = 0; i < request->outputs.count && !code; i++)
        code = fmt_image_check_path(request->outputs.item[i], &err);
    if (!code)
        code = brick_volume_open(&volume, path, &err);
    if (!code && !brick_volume_stats(volume)->count && !request->quiet)
        tool_note("render", "%s: no voxel is finite, the picture is empty", path);
    if (!code)
        code = place_cameras(request, brick_volume_grid(volume), &cameras, &err);
    if (!code && !(reports = calloc(cameras.count, sizeof *reports)))
        code = brick_fail(&err, BRICK_ERR_MEMORY, "no memory for %zu frames", cameras.count);
    if (!code)
        code = tool_render_frames(request, volume, &cameras, reports, &final, &err);
    double seconds = 1e-9 * (double)(brick_now_ns() - start_ns);
    if (code) {
        code = tool_fail("render", &err);
    } else {
        if (!request->quiet)
            print_summary(request, reports, cameras.count, final, seconds);
        if (request->json)
            code = tool_render_json(reports, cameras.count, final, seconds);
    }
    free(reports);
    tool_cameras_finish(&cameras);
    brick_volume_close(&volume);
    return code;
}

int cmd_render(int argc, char **argv)
{
    struct tool_request r = {
        .scene = vr_scene_defaults,
        .quality = vr_quality_defaults,
        .renderer = vr_renderer_defaults,
        .image = fmt_image_defaults,
        .isotrace = vr_isotrace_defaults,
        .slices = TOOL_SLICES_DEFAULTS,
        .up = {0, 0, 1},
        .mesh_rgb = {0.25, 0.5, 0.8},
        .opacity = 1.0,
    };
    uint32_t size[2] = {512, 512};
    int first = 0;

    const struct tool_option options[] = {
        {"output", .letter = 'o', .value = "IMG", .parse = tool_parse_list, .target = &r.outputs,
         .required = true, .help = "picture to write (required): .exr or .png; several are\none render"},
        {"tf", .value = "NAME|FILE", .parse = tool_parse_text, .target = &r.tf,
         .help = "transfer function: ct-bone, ct-skin, mri, gray (default),\nor a JSON file"},
        {"opacity", .value = "F", .parse = tool_parse_real, .target = &r.opacity,
         .limits = {.min = 1e-9, .max = 1e9}, .help = "times the transfer function's extinction (default 1)"},
        {"mode", .value = "MODE", .parse = tool_parse_choice, .target = &r.mode, .limits = {.choices = modes},
         .help = "dvr (default), shaded, iso or mip"},
        {"iso", .value = "V[,V...]", .parse = tool_parse_reals, .target = &r.iso, .given = &r.has_iso,
         .help = "isovalue, physical; isotrace takes up to 16"},
        {"iso-opacity", .value = "A[,A...]", .parse = tool_parse_reals, .target = &r.iso_opacity,
         .given = &r.has_opacity, .limits = {.min = 0, .max = 1},
         .help = "isotrace: opacity of each --iso (default 1)"},
        {"light", .value = "X,Y,Z", .parse = tool_parse_triple, .target = r.isotrace.light,
         .given = &r.isotrace.lit,
         .help = "isotrace: direction towards the light, LPS (default:\nat the eye)"},
        {"shadows", .target = &r.isotrace.shadows,
         .help = "isotrace: shadows; without --light the light is over\nthe left shoulder"},
        {"size", .value = "WxH", .parse = tool_parse_picture, .target = size,
         .help = "pixels (default 512x512)"},
        {"step", .value = "S", .parse = tool_parse_positive, .target = &r.quality.step_vox,
         .given = &r.has_step, .help = "sampling distance in smallest voxel edges (default 0.5)"},
        {"method", .value = "METHOD", .parse = tool_parse_choice, .target = &r.method,
         .limits = {.choices = methods},
         .help = "raycast (default), multipass: the same picture in short\npasses, slices: planes, blended, "
                 "cells:\nprojected tetrahedra, isotrace: "
                 "isosurfaces, ray traced "
                 "on\nthe CPU, or exact: no step size, right to 1e-10, on the\nCPU"},
        TOOL_SLICES_OPTIONS(&r.slices),
        {"cells-integration", .value = "HOW", .parse = tool_parse_choice, .target = &r.integration,
         .given = &r.has_integration, .limits = {.choices = integrations},
         .help = "cells: in each tetrahedron prefix (default), exact or psi,\nor of its ends exp, average, "
                 "scalar"},
        {"pass-steps", .value = "M", .parse = tool_parse_u32, .target = &r.quality.pass_steps,
         .given = &r.has_pass_steps, .limits = {.min = 1, .max = VR_MAX_PASS_STEPS},
         .help = "multipass: samples a ray and pass (default 64)"},
        {"setup", .value = "HOW", .parse = tool_parse_choice, .target = &r.setup, .given = &r.has_setup,
         .limits = {.choices = setups},
         .help = "raycast, multipass: where rays begin and end, from the\nvolume's box (default) or from the "
                 "faces of "
                 "what is\nactive: geometry; the same picture"},
        {"offset", .value = "HOW", .parse = tool_parse_choice, .target = &r.offset,
         .limits = {.choices = offsets},
         .help =
             "raycast, multipass: none (default), or interleaved:\nneighbours' samples at different depths"},
        {"field", .value = "FIELD", .parse = tool_parse_choice, .target = &r.field, .given = &r.has_field,
         .limits = {.choices = fields},
         .help = "exact: trilinear (default), tetrahedra, or preclassified:\nwhat is interpolated"},
        {"emission", .value = "HOW", .parse = tool_parse_choice, .target = &r.emission,
         .given = &r.has_emission, .limits = {.choices = emissions},
         .help =
             "slices, exact: colour scaled by extinction (default), or\nindependent of it, so much a unit of "
             "length"},
        {"clip", .value = "A,B,C,D", .parse = tool_parse_list, .target = &r.clip,
         .help = "keep A x + B y + C z >= D of the volume, in mm; may be\nrepeated"},
        {"clip-box", .value = "X0,X1,Y0,Y1,Z0,Z1", .parse = tool_parse_box, .target = r.clip_box,
         .given = &r.has_clip_box, .help = "keep what is in the box, in mm"},
        {"mesh", .value = "FILE", .parse = tool_parse_list, .target = &r.mesh,
         .help = "an opaque mesh in the scene, in mm: .ply or .obj; may be\nrepeated"},
        {"mesh-color", .value = "R,G,B", .parse = tool_parse_triple, .target = r.mesh_rgb,
         .limits = {.min = 0, .max = 1}, .help = "of meshes that have none, linear (default 0.25,0.5,0.8)"},
        {"camera", .value = "AZ,EL", .parse = tool_parse_pair, .target = r.orbit, .given = &r.has_camera,
         .help = "azimuth and elevation in degrees (default 0,0: from\nthe front)"},
        {"eye", .value = "X,Y,Z", .parse = tool_parse_triple, .target = r.eye, .given = &r.has_eye,
         .help = "the eye in mm, LPS"},
        {"look", .value = "X,Y,Z", .parse = tool_parse_triple, .target = r.look, .given = &r.has_look,
         .help = "point looked at (default the centre)"},
        {"up", .value = "X,Y,Z", .parse = tool_parse_triple, .target = r.up, .given = &r.has_up,
         .help = "direction that is up in the picture (default 0,0,1)"},
        {"fov", .value = "D", .parse = tool_parse_real, .target = &r.fov, .given = &r.has_fov,
         .limits = {.min = 0.001, .max = 179}, .help = "vertical opening in degrees (default 30)"},
        {"ortho", .value = "H", .parse = tool_parse_positive, .target = &r.ortho, .given = &r.has_ortho,
         .help = "parallel projection, the picture H mm high"},
        {"turntable", .value = "N", .parse = tool_parse_u32, .target = &r.turntable,
         .given = &r.has_turntable, .limits = {.min = 1, .max = 100000},
         .help = "N pictures all the way round: IMG-0000.exr, ..."},
        {"path", .value = "FILE", .parse = tool_parse_text, .target = &r.path,
         .help = "a picture for each camera of a JSON file"},
        {"level", .value = "L", .parse = tool_parse_u32, .target = &r.scene.level,
         .help = "level to render; 0 is full resolution (default)"},
        {"termination", .value = "T", .parse = tool_parse_real, .target = &r.quality.termination,
         .given = &r.has_termination, .limits = {.min = 0, .max = 1},
         .help = "end a ray when less than T gets through (default 1e-4)"},
        {"classification", .value = "WHEN", .parse = tool_parse_choice, .target = &r.classification,
         .given = &r.has_classification, .limits = {.choices = classifications},
         .help = "post (default): the value at each sample; pre: voxels\n(slices); preintegrated: all values "
                 "between two "
                 "samples,\nsteps up to a voxel"},
        {"refinements", .value = "N", .parse = tool_parse_u32, .target = &r.quality.refinements,
         .given = &r.has_refinements, .limits = {.min = 0, .max = 60}, .help = "iso: bisections at a hit"},
        {"refine", .value = "HOW", .parse = tool_parse_choice, .target = &r.refine, .given = &r.has_refine,
         .limits = {.choices = refines},
         .help = "iso: what finds the hit between two samples: bisection\n(default), or cubic, exact in the "
                 "cell"},
        {"no-skip", .target = &r.no_skip, .help = "do not jump over inactive parts (same picture, slower)"},
        {"filter", .value = "FILTER", .parse = tool_parse_choice, .target = &r.filter,
         .limits = {.choices = filters},
         .help = "exact (default): trilinear of eight voxels in float32, or\nfast: by the texture unit, "
                 "fractions of 2^-12"},
        {"budget", .value = "SECONDS", .parse = tool_parse_positive, .target = &r.budget.seconds,
         .help = "write what is there after so long; coarser bricks stand in\nfor what is missing"},
        {"ambient", .value = "K", .parse = tool_parse_real, .target = &r.scene.ambient,
         .limits = {.min = 0, .max = 1e6}, .help = "shading (default 0.2)"},
        {"diffuse", .value = "K", .parse = tool_parse_real, .target = &r.scene.diffuse,
         .limits = {.min = 0, .max = 1e6}, .help = "shading (default 0.7)"},
        {"specular", .value = "K", .parse = tool_parse_real, .target = &r.scene.specular,
         .limits = {.min = 0, .max = 1e6}, .help = "shading (default 0.3)"},
        {"shininess", .value = "N", .parse = tool_parse_real, .target = &r.scene.shininess,
         .limits = {.min = 0, .max = 1e6}, .help = "shading (default 20)"},
        {"background", .value = "R,G,B", .parse = tool_parse_triple, .target = r.image.background,
         .limits = {.min = 0, .max = 1}, .help = "PNG: linear colour behind (default 0,0,0)"},
        {"gpu-cache", .value = "SIZE", .parse = tool_parse_bytes, .target = &r.renderer.gpu_cache_bytes,
         .given = &r.has_cache, .help = "bytes of bricks in the GPU's memory, such as 256M"},
        {"host-cache", .value = "SIZE", .parse = tool_parse_bytes, .target = &r.renderer.host_cache_bytes,
         .help = "bytes of decoded bricks in memory, such as 1G"},
        {"context", .value = "KIND", .parse = tool_parse_choice, .target = &r.context,
         .given = &r.has_context, .limits = {.choices = contexts},
         .help = "egl, osmesa or cpu, without OpenGL; auto (default): OpenGL\non a GPU; without one the CPU "
                 "for what it draws"},
        TOOL_OPTION_THREADS(&r.renderer.threads),
        TOOL_OPTION_JSON(&r.json),
        TOOL_OPTION_QUIET(&r.quiet),
    };
    const struct tool_usage usage = {
        .command = "render",
        .arguments = "FILE -o IMG [OPTIONS]",
        .summary = "Make a picture of a .brick file. EXR holds premultiplied linear RGBA in float32;\n"
                   "PNG is that over the background, in sRGB.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code < 0)
        code = check_request(&r);
    if (code < 0)
        code = read_clip_planes(&r, &r.scene);
    if (code >= 0)
        return code;
    r.scene.width = size[0];
    r.scene.height = size[1];
    r.scene.isovalue = r.iso.value[0];
    r.quality.skip = !r.no_skip;
    r.quality.slices = tool_slices_quality(&r.slices, r.has_step);
    r.quality.classification = (enum vr_classification)r.classification;
    r.quality.interleaved = r.offset == 1;
    r.quality.cubic = r.refine == 1;
    r.quality.setup = (enum vr_setup)r.setup;
    if (r.method < VR_METHODS)
        r.quality.method = (enum vr_method)r.method;
    r.quality.cells_integration = (enum vr_cells_integration)r.integration;
    r.renderer.context = (enum vr_context_kind)r.context;
    r.renderer.filter = (enum vr_filter)r.filter;
    return render(&r, argv[first]);
}
