/* The options of `brick render` that --method slices alone has. */
#ifndef TOOLS_SLICES_OPTIONS_H
#define TOOLS_SLICES_OPTIONS_H

#include <renderer/renderer.h>

#include "options.h"

struct tool_slices {
    uint32_t planes;
    int interpolation, framebuffer, order, bits;
    bool has_planes, has_interpolation, has_framebuffer, has_order, has_bits;
};

/* In the order of their enums. */
extern const char *const tool_interpolations[], *const tool_framebuffers[], *const tool_slice_orders[],
                                                                                *const tool_classified_bits[];

#define TOOL_SLICES_DEFAULTS                                                                                 \
    {                                                                                                        \
        .framebuffer = VR_FRAMEBUFFER_32F, .bits = 2 /* 32 */                                                \
    }

/* Rows of a table of options; slices: a struct tool_slices. */
#define TOOL_SLICES_OPTIONS(slices)                                                                          \
    {"planes",                                                                                               \
     .value = "N",                                                                                           \
     .parse = tool_parse_u32,                                                                                \
     .target = &(slices)->planes,                                                                            \
     .given = &(slices)->has_planes,                                                                         \
     .limits = {.min = 1, .max = 1 << 30},                                                                   \
     .help = "slices: planes over the volume's diagonal (default:\none a smallest voxel edge, or as --step " \
             "says)"},                                                                                       \
        {"interpolation",                                                                                    \
         .value = "HOW",                                                                                     \
         .parse = tool_parse_choice,                                                                         \
         .target = &(slices)->interpolation,                                                                 \
         .given = &(slices)->has_interpolation,                                                              \
         .limits = {.choices = tool_interpolations},                                                         \
         .help = "slices: trilinear (default) or point"},                                                    \
        {"framebuffer",                                                                                      \
         .value = "BITS",                                                                                    \
         .parse = tool_parse_choice,                                                                         \
         .target = &(slices)->framebuffer,                                                                   \
         .given = &(slices)->has_framebuffer,                                                                \
         .limits = {.choices = tool_framebuffers},                                                           \
         .help = "slices: blend in 8 bits, 16f or 32f (default)"},                                           \
        {"classified-bits",                                                                                  \
         .value = "BITS",                                                                                    \
         .parse = tool_parse_choice,                                                                         \
         .target = &(slices)->bits,                                                                          \
         .given = &(slices)->has_bits,                                                                       \
         .limits = {.choices = tool_classified_bits},                                                        \
         .help = "slices, classification pre: 8, 16 or 32 (default)\nbits a channel"},                       \
    {                                                                                                        \
        "order", .value = "WAY", .parse = tool_parse_choice, .target = &(slices)->order,                     \
                 .given = &(slices)->has_order, .limits = {.choices = tool_slice_orders},                    \
                 .help = "slices: front (default: front to back, rays end\nearly) or back (to front)"        \
    }

/* What is wrong with the options as they were given, or NULL. used: the method is slices. */
const char *tool_slices_check(const struct tool_slices *slices, bool used, bool has_step,
                              bool has_termination);
/* As the renderer takes them. */
struct vr_slices tool_slices_quality(const struct tool_slices *slices, bool has_step);

#endif
