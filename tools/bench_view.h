/* What measurements look at: the options that say so, and the scene and the camera they ask for. */
#ifndef TOOLS_BENCH_VIEW_H
#define TOOLS_BENCH_VIEW_H

#include <renderer/renderer.h>

#include "bench.h"
#include "options.h"

struct bench_view {
    uint32_t size[2];
    double orbit[2]; /* azimuth and elevation in degrees */
    double ortho_mm; /* the height of a parallel projection; 0: perspective */
    double iso;
    bool has_iso; /* false: the middle of the range */
};

/* Rows of tables of options, without their targets; usual: the default. */
#define BENCH_TF                                                                                             \
    "tf", .value = "NAME|FILE", .parse = tool_parse_text, .help = "transfer function (default gray)"
#define BENCH_FRAMES(usual)                                                                                  \
    "frames", .value = "N", .parse = tool_parse_u32, .limits = {.min = 1, .max = BENCH_REPEAT_MAX},          \
              .help = "frames to take the median of (default " usual ")"
#define BENCH_STEP(usual)                                                                                    \
    "step", .value = "S", .parse = tool_parse_positive,                                                      \
            .help = "sampling distance in smallest voxel edges (default " usual ")"
#define BENCH_GPU_CACHE                                                                                      \
    "gpu-cache", .value = "SIZE", .parse = tool_parse_bytes, .help = "bytes of bricks in the GPU's memory"
/* Of the view, with their targets. */
#define BENCH_ISO(view)                                                                                      \
    "iso", .value = "V", .parse = tool_parse_real, .target = &(view).iso, .given = &(view).has_iso,          \
           .help = "isovalue (default the middle of the range)"
#define BENCH_SIZE(view, usual)                                                                              \
    "size", .value = "WxH", .parse = tool_parse_picture, .target = (view).size,                              \
            .help = "pixels (default " usual ")"
#define BENCH_CAMERA(view, usual)                                                                            \
    "camera", .value = "AZ,EL", .parse = tool_parse_pair, .target = (view).orbit,                            \
              .help = "azimuth and elevation in degrees (default " usual ")"

/* The default scene, of the view's size, isovalue and camera. */
void bench_view_scene(const struct bench_view *view, const struct brick_volume *volume,
                      struct vr_scene *scene);
/* Millimetres from corner to corner: a parallel projection so high holds all of the volume from any side. */
double bench_view_diagonal_mm(const struct brick_volume *volume);

#endif
