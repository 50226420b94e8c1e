/* What an open file is made of, for the two ways of opening one: all of it right (volume.c), or what is left
 * of it (damaged.c). */
#ifndef BRICK_STORE_OPENED_H
#define BRICK_STORE_OPENED_H

#include <brick/io.h>
#include <brick/volume.h>

#include "layout.h"

struct brick_volume {
    struct brick_io io;
    struct brick_grid grid;
    struct brick_stats stats;
    uint64_t *histogram;
    char *provenance;
    struct brick_entry *entries;
    uint64_t file_bytes, payload_end;
    double tolerance;
};

/* The header's grid and sizes; BRICK_ERR_FORMAT where they are impossible. */
int opened_set_header(struct brick_volume *volume, const struct layout_header *header,
                      struct brick_error *err);
/* Do the header's tables lie one behind the other, each as long as the grid says? */
int opened_check_extents(const struct brick_volume *volume, const struct layout_header *header,
                         struct brick_error *err);

/* One table each: read, held against its checksum and against the grid, kept in the volume. */
int opened_read_levels(struct brick_volume *volume, const struct layout_extent *extent,
                       struct brick_error *err);
int opened_read_index(struct brick_volume *volume, const struct layout_extent *extent, uint64_t payload_end,
                      struct brick_error *err);
int opened_read_stats(struct brick_volume *volume, const struct layout_extent *extent,
                      struct brick_error *err);
int opened_read_provenance(struct brick_volume *volume, const struct layout_extent *extent,
                           struct brick_error *err);

/* Could this be an entry of the file? `expected`: where its payload must start; advanced past it. end: of all
 * payloads. */
bool opened_entry_sane(const struct brick_volume *volume, const struct brick_entry *entry, uint64_t end,
                       uint64_t *expected);

#endif
