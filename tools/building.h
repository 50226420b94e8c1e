/* What convert and synth share: options of the file's layout, running the build, and its report. */
#ifndef TOOLS_BUILDING_H
#define TOOLS_BUILDING_H

#include <stdbool.h>

#include <brick/build.h>

#include "options.h"

struct tool_building {
    struct brick_build_params params; /* start from brick_build_defaults */
    int downsample;                   /* index in tool_downsample_names */
    uint32_t codec_level;
    bool json, quiet;
};
extern const char *const tool_downsample_names[];

#define TOOL_BUILDING_ROWS(b)                                                                                \
    {"brick",                                                                                                \
     .value = "N",                                                                                           \
     .parse = tool_parse_u32,                                                                                \
     .target = &(b).params.edge,                                                                             \
     .limits = {.min = 8, .max = 256},                                                                       \
     .help = "core edge of a brick in voxels, a multiple of 8"},                                             \
        {"border",                                                                                           \
         .value = "N",                                                                                       \
         .parse = tool_parse_u32,                                                                            \
         .target = &(b).params.border,                                                                       \
         .limits = {.min = 2, .max = 8},                                                                     \
         .help = "voxels repeated around every brick"},                                                      \
        {"macrocell",                                                                                        \
         .value = "N",                                                                                       \
         .parse = tool_parse_u32,                                                                            \
         .target = &(b).params.macrocell,                                                                    \
         .limits = {.min = 4, .max = 16},                                                                    \
         .help = "edge of the cells with a range of their own: 4, 8 or 16"},                                 \
        {"codec", .value = "NAME", .parse = tool_parse_codec, .target = &(b).params.codec,                   \
         .help = "none, lz4, lz4-bitshuffle, zstd, zstd-delta, or zfp (lossy)"},                             \
        {"codec-level",                                                                                      \
         .value = "N",                                                                                       \
         .parse = tool_parse_u32,                                                                            \
         .target = &(b).codec_level,                                                                         \
         .limits = {.min = 1, .max = 9},                                                                     \
         .help = "effort of the codec, 1 (default) to 9"},                                                   \
        {"tolerance", .value = "E", .parse = tool_parse_positive, .target = &(b).params.tolerance,           \
         .help = "zfp: no value is off by more, in physical units"},                                         \
        {"downsample",                                                                                       \
         .value = "HOW",                                                                                     \
         .parse = tool_parse_choice,                                                                         \
         .target = &(b).downsample,                                                                          \
         .limits = {.choices = tool_downsample_names},                                                       \
         .help = "mean, or nearest (labels): how coarser levels are made"},                                  \
        {"memory", .value = "SIZE", .parse = tool_parse_bytes, .target = &(b).params.memory_bytes,           \
         .help = "budget of the buffers, such as 512M"},                                                     \
        TOOL_OPTION_THREADS(&(b).params.threads), TOOL_OPTION_JSON(&(b).json), TOOL_OPTION_QUIET(&(b).quiet)

/* Not of the benchmark. */
#define TOOL_OPTION_RESUME(b)                                                                                \
    {                                                                                                        \
        "resume", .target = &(b).params.resume, .help = "go on where an interrupted conversion stopped"      \
    }

void tool_building_init(struct tool_building *building);

/* -1, or the exit code after saying what options do not go together. */
int tool_building_check(const char *command, const struct tool_building *building);

/* Build path from source with progress; then the summary, notes and JSON. Exit code. */
int tool_build(const char *command, struct tool_building *building, struct brick_source *source,
               const char *path);

/* Does the name end in ending (".brick"), in any case? */
bool tool_ends_in(const char *path, const char *ending);

#endif
