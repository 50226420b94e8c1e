/* Why: `brick synth`: test volumes of any size, straight into a .brick file or as a file of another format.
 */
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>
#include <formats/formats.h>

#include "building.h"
#include "command.h"
#include "message.h"
#include "progress.h"

#define SLAB_BYTES (UINT64_C(16) << 20)

/* Slices of about SLAB_BYTES at a time from source to sink. */
static int copy_slices(struct brick_source *source, struct brick_sink *sink, bool quiet,
                       struct brick_error *err)
{
    const uint64_t *dims = source->geometry.dims;
    uint64_t slice, bytes;
    void *slab = NULL;
    struct tool_progress progress;
    int code;

    if (!brick_mul3_u64(dims[0], dims[1], brick_type_bytes(source->type), &slice))
        return brick_fail(err, BRICK_ERR_MEMORY, "one slice is larger than memory can be");
    uint64_t count = slice >= SLAB_BYTES ? 1 : SLAB_BYTES / slice;
    if (count > dims[2])
        count = dims[2];
    if (!brick_mul_u64(slice, count, &bytes) || bytes > SIZE_MAX || !(slab = malloc((size_t)bytes)))
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for one slice of %llu bytes",
                          (unsigned long long)slice);
    tool_progress_init(&progress, "synth", slice * dims[2], quiet);
    code = 0;
    for (uint64_t z = 0; z < dims[2] && !code; z += count) {
        uint64_t n = dims[2] - z < count ? dims[2] - z : count;
        code = source->read(source, z, n, slab, err);
        if (!code)
            code = sink->write(sink, z, n, slab, err);
        tool_progress_update(&progress, z + n, dims[2]);
    }
    tool_progress_finish(&progress);
    free(slab);
    return code ? code : sink->finish(sink, err);
}

static int write_foreign(struct brick_source *source, const char *path, bool quiet)
{
    struct brick_sink *sink = NULL;
    struct brick_error err = {0};
    int code = fmt_sink_create(&sink, path, source->type, &source->geometry, &err);
    if (!code)
        code = copy_slices(source, sink, quiet, &err);
    brick_sink_destroy(&sink);
    return code ? tool_fail("synth", &err) : TOOL_DONE;
}

int cmd_synth(int argc, char **argv)
{
    struct fmt_synth_params field = {.type = BRICK_U16, .seed = 1};
    struct tool_building building;
    const char *output = NULL;
    int first = 0;
    tool_building_init(&building);

    const struct tool_option options[] = {
        {"output", .letter = 'o', .value = "FILE", .parse = tool_parse_text, .target = &output,
         .required = true, .help = "the file to write (required): .brick, .raw, .nrrd, .mhd or .mha"},
        {"size", .value = "NXxNYxNZ", .parse = tool_parse_dims, .target = field.dims, .required = true,
         .help = "voxels on each axis (required)"},
        {"type", .value = "TYPE", .parse = tool_parse_type, .target = &field.type,
         .help = "u8 i8 u16 i16 f32 (default u16)"},
        {"seed", .value = "N", .parse = tool_parse_u64, .target = &field.seed,
         .help = "of noise (default 1)"},
        {"value", .value = "V", .parse = tool_parse_real, .target = &field.value,
         .help = "constant: the stored value (default 0)"},
        TOOL_OPTION_RESUME(building),
        TOOL_BUILDING_ROWS(building),
    };
    const struct tool_usage usage = {
        .command = "synth",
        .arguments = "NAME --size NXxNYxNZ -o FILE [OPTIONS]",
        .summary = "Make a test volume: marschner-lobb, ct, ramp, checker, constant or shells.\n"
                   "The same options give the same bytes. Layout options apply to .brick files.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one NAME"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    if (field.type >= BRICK_TYPE_STORED_COUNT)
        return tool_misuse("synth", "--type takes u8 i8 u16 i16 or f32");
    bool known = false;
    for (size_t i = 0; fmt_synth_names[i]; i++)
        known = known || !strcmp(argv[first], fmt_synth_names[i]);
    if (!known)
        return tool_misuse("synth", "unknown field '%s'", argv[first]);
    if ((code = tool_building_check("synth", &building)) >= 0)
        return code;
    field.threads = building.params.threads;

    struct brick_source *source = NULL;
    struct brick_error err = {0};
    if (fmt_synth_open(&source, argv[first], &field, &err))
        return tool_fail("synth", &err);
    code = tool_ends_in(output, ".brick") ? tool_build("synth", &building, source, output)
                                          : write_foreign(source, output, building.quiet);
    brick_source_destroy(&source);
    return code;
}
