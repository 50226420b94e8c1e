/* Why: info, render and bench all take --tf, and a transfer function needs the volume it is for. */
#include "transfer.h"

#include <string.h>

#include <formats/formats.h>

#include "building.h"

int tool_transfer_load(struct brick_transfer **transfer, const char *name, const struct brick_volume *volume,
                       struct brick_error *err)
{
    struct brick_transfer_spec spec = {0};
    double range[2];
    int code;

    if (!name)
        name = TOOL_TRANSFER_DEFAULT;
    if (strchr(name, '/') || tool_ends_in(name, ".json"))
        code = fmt_transfer_read(&spec, name, err);
    else
        code = brick_transfer_builtin(name, &spec, err);
    if (code)
        return code;
    brick_volume_value_range(volume, range);
    code = brick_transfer_create(transfer, &spec, brick_grid_min_spacing_mm(brick_volume_grid(volume)), range,
                                 err);
    brick_transfer_spec_finish(&spec);
    return code;
}
