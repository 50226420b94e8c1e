/* Why: `brick export`: voxels of a level, or of a region of it, back into a file that other programs read, at
 * the same place in the world. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>
#include <brick/volume.h>
#include <formats/formats.h>

#include "command.h"
#include "message.h"
#include "options.h"
#include "progress.h"

#define SLAB_BYTES (UINT64_C(256) << 20)

struct request {
    const char *output;
    uint32_t level;
    bool has_region, quiet;
    uint64_t region[3][2]; /* [lo, hi) in voxels of the level */
};

/* Voxel i of the part is voxel lo + i of the level, which is voxel scale * (lo + i) + offset of level 0. */
static void part_geometry(struct brick_geometry *part, const struct brick_grid *grid, uint32_t level,
                          const uint64_t lo[3], const uint64_t hi[3])
{
    const struct brick_level *of = &grid->level[level];
    part->slope = grid->slope;
    part->intercept = grid->intercept;
    for (int row = 0; row < 3; row++) {
        part->affine[row][3] = grid->affine[row][3];
        for (int axis = 0; axis < 3; axis++) {
            double first = of->scale[axis] * (double)lo[axis] + of->offset[axis];
            part->affine[row][axis] = grid->affine[row][axis] * of->scale[axis];
            part->affine[row][3] += grid->affine[row][axis] * first;
        }
    }
    for (int axis = 0; axis < 3; axis++)
        part->dims[axis] = hi[axis] - lo[axis];
}

/* Slabs of one brick's height that end at brick faces, so that a brick is decoded once; lower ones when
 * slices are very large. */
static int copy_box(const struct brick_volume *volume, uint32_t level, const uint64_t lo[3],
                    const uint64_t hi[3], struct brick_sink *sink, bool quiet, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    uint64_t slice, bytes, height = grid->edge;
    struct tool_progress progress;
    void *slab = NULL;

    if (!brick_mul3_u64(hi[0] - lo[0], hi[1] - lo[1], brick_type_bytes(grid->type), &slice))
        return brick_fail(err, BRICK_ERR_MEMORY, "one slice is larger than memory can be; use --region");
    if (height > SLAB_BYTES / slice)
        height = slice >= SLAB_BYTES ? 1 : SLAB_BYTES / slice;
    if (!brick_mul_u64(slice, height, &bytes) || bytes > SIZE_MAX || !(slab = malloc((size_t)bytes)))
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a slice of %llu bytes; use --region",
                          (unsigned long long)slice);
    tool_progress_init(&progress, "export", slice * (hi[2] - lo[2]), quiet);
    int code = 0;
    for (uint64_t z = lo[2]; z < hi[2] && !code;) {
        uint64_t end = (z / height + 1) * height;
        end = end < hi[2] ? end : hi[2];
        code = brick_volume_read_box(volume, level, (const uint64_t[3]){lo[0], lo[1], z},
                                     (const uint64_t[3]){hi[0], hi[1], end}, slab, err);
        if (!code)
            code = sink->write(sink, z - lo[2], end - z, slab, err);
        z = end;
        tool_progress_update(&progress, z - lo[2], hi[2] - lo[2]);
    }
    tool_progress_finish(&progress);
    free(slab);
    return code ? code : sink->finish(sink, err);
}

static int export(const struct brick_volume *volume, const struct request *request, struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    struct brick_geometry geometry;
    struct brick_sink *sink = NULL;
    uint64_t lo[3], hi[3];

    if (request->level >= grid->levels)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%s has levels 0 to %u, not %u", brick_volume_path(volume),
                          grid->levels - 1, request->level);
    const uint64_t *dims = grid->level[request->level].dims;
    for (int axis = 0; axis < 3; axis++) {
        lo[axis] = request->has_region ? request->region[axis][0] : 0;
        hi[axis] = request->has_region ? request->region[axis][1] : dims[axis];
        if (hi[axis] > dims[axis])
            return brick_fail(err, BRICK_ERR_ARGUMENT, "the region ends at %c = %llu, level %u at %llu",
                              "xyz"[axis], (unsigned long long)hi[axis], request -> level,
                              (unsigned long long)dims[axis]);
    }
    part_geometry(&geometry, grid, request->level, lo, hi);
    int code = fmt_sink_create(&sink, request->output, grid->type, &geometry, err);
    if (!code)
        code = copy_box(volume, request->level, lo, hi, sink, request->quiet, err);
    brick_sink_destroy(&sink);
    return code;
}

int cmd_export(int argc, char **argv)
{
    struct request request = {0};
    int first = 0;
    const struct tool_option options[] = {
        {"output", .letter = 'o', .value = "DST", .parse = tool_parse_text, .target = &request.output,
         .required = true, .help = "the file to write (required): .raw, .nrrd, .mhd or .mha"},
        {"level", .value = "L", .parse = tool_parse_u32, .target = &request.level,
         .help = "0 is full resolution (default)"},
        {"region", .value = "x0:x1,y0:y1,z0:z1", .parse = tool_parse_region, .target = request.region,
         .given = &request.has_region, .help = "voxels of the level, the ends not included (default: all)"},
        TOOL_OPTION_QUIET(&request.quiet),
    };
    const struct tool_usage usage = {
        .command = "export",
        .arguments = "FILE -o DST [OPTIONS]",
        .summary = "Write the voxels of a .brick file in the format that DST's ending names.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;

    struct brick_volume *volume = NULL;
    struct brick_error err = {0};
    code = brick_volume_open(&volume, argv[first], &err);
    if (!code)
        code = export(volume, &request, &err);
    brick_volume_close(&volume);
    return code ? tool_fail("export", &err) : TOOL_DONE;
}
