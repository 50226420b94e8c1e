/* Why: `brick convert`: any readable volume, or a raw file and what to know about it, becomes a .brick file.
 */
#include <string.h>

#include <formats/formats.h>

#include "building.h"
#include "command.h"
#include "message.h"

int cmd_convert(int argc, char **argv)
{
    static const char *const endians[] = {"little", "big", NULL}, *const to[] = {"f32", NULL};
    struct fmt_source_params in = fmt_source_defaults;
    struct tool_building building;
    const char *output = NULL;
    bool to_f32 = false, has_axes = false, has_size = false, has_type = false;
    int endian = 0, to_type = 0, first = 0;
    tool_building_init(&building);

    const struct tool_option options[] = {
        {"output", .letter = 'o', .value = "FILE.brick", .parse = tool_parse_text, .target = &output,
         .required = true, .help = "the file to write (required)"},
        {"size", .value = "NXxNYxNZ", .parse = tool_parse_dims, .target = in.dims, .given = &has_size,
         .help = "raw: voxels on each axis"},
        {"type", .value = "TYPE", .parse = tool_parse_type, .target = &in.type, .given = &has_type,
         .help = "raw: u8 i8 u16 i16 u32 i32 f32 f64"},
        {"endian", .value = "ORDER", .parse = tool_parse_choice, .target = &endian,
         .limits = {.choices = endians}, .help = "raw: little (default) or big"},
        {"skip", .value = "BYTES", .parse = tool_parse_bytes, .target = &in.skip_bytes,
         .help = "raw: bytes before the first voxel"},
        {"spacing", .value = "X,Y,Z", .parse = tool_parse_spacing, .target = in.spacing_mm,
         .given = &in.has_spacing, .help = "distance of voxels in mm"},
        {"origin", .value = "X,Y,Z", .parse = tool_parse_triple, .target = in.origin_mm,
         .given = &in.has_origin, .help = "place of the first voxel in mm, LPS"},
        {"axes", .value = "CODE", .parse = tool_parse_axes, .target = in.axes, .given = &has_axes,
         .help = "where x, y and z of the file point to: one of\nleft or right, posterior or anterior, "
                 "superior or "
                 "inferior\n(default LPS)"},
        {"affine", .value = "A11,..,A34", .parse = tool_parse_affine, .target = in.affine,
         .given = &in.has_affine, .help = "index to mm in LPS: 3 rows of 4, row after row"},
        {"slope", .value = "S", .parse = tool_parse_real, .target = &in.slope, .given = &in.has_slope,
         .help = "value = slope * stored + intercept"},
        {"intercept", .value = "I", .parse = tool_parse_real, .target = &in.intercept,
         .given = &in.has_intercept, .help = "see --slope"},
        {"to", .value = "TYPE", .parse = tool_parse_choice, .target = &to_type, .given = &to_f32,
         .limits = {.choices = to}, .help = "f32: round u32, i32 and f64 values that f32 cannot hold"},
        TOOL_OPTION_RESUME(building),
        TOOL_BUILDING_ROWS(building),
    };
    const struct tool_usage usage = {
        .command = "convert",
        .arguments = "SRC -o FILE.brick [OPTIONS]",
        .summary = "Turn a volume (NRRD, MetaImage, or raw with --size and --type) into a .brick file.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one SRC"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    if (!tool_ends_in(output, ".brick"))
        return tool_misuse("convert", "the output '%s' does not end in .brick", output);
    if (has_size != has_type)
        return tool_misuse("convert", "--size and --type go together");
    if (in.has_affine && (in.has_spacing || in.has_origin || has_axes))
        return tool_misuse("convert", "--affine already says what --spacing, --origin and --axes would");
    if (in.has_slope && in.slope == 0)
        return tool_misuse("convert", "--slope 0 would make all values one");
    in.big_endian = endian == 1;
    building.params.round_to_f32 = to_f32;

    if ((code = tool_building_check("convert", &building)) >= 0)
        return code;

    struct brick_source *source = NULL;
    struct brick_error err = {0};
    if (fmt_source_open(&source, argv[first], &in, &err))
        return tool_fail("convert", &err);
    code = tool_build("convert", &building, source, output);
    brick_source_destroy(&source);
    return code;
}
