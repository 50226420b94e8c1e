/* --tf: the name of a built-in transfer function, or a JSON file. */
#ifndef TOOLS_TRANSFER_H
#define TOOLS_TRANSFER_H

#include <brick/transfer.h>
#include <brick/volume.h>

#define TOOL_TRANSFER_DEFAULT "gray"

/* A name with a / or ending in .json is a file. NULL: TOOL_TRANSFER_DEFAULT. */
int tool_transfer_load(struct brick_transfer **transfer, const char *name, const struct brick_volume *volume,
                       struct brick_error *err);

#endif
