/* Reading one brick, by its index entry. */
#ifndef BRICK_STORE_PAYLOAD_H
#define BRICK_STORE_PAYLOAD_H

#include <brick/io.h>
#include <brick/volume.h>

/* The payload as stored, checked against its checksum, to scratch. */
int payload_fetch(const struct brick_io *io, const struct brick_entry *entry, struct brick_scratch *scratch,
                  struct brick_error *err);
/* As brick_volume_read. */
int payload_read(const struct brick_io *io, const struct brick_grid *grid, uint64_t id,
                 const struct brick_entry *entry, void *dst, struct brick_scratch *scratch,
                 struct brick_error *err);

#endif
