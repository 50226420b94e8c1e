/* Writing a .brick file: bricks in any order of levels, each level's bricks in ascending order.
 *
 * Level 0's payloads go to PATH.part as they come; those of coarser levels wait in memory, as far as that is
 * allowed, then in scratch files beside it, and are appended level by level when finishing; then tables,
 * sync, header, sync, rename. Nothing under PATH changes before that, and a writer destroyed unfinished
 * removes what it wrote. */
#ifndef BRICK_WRITER_H
#define BRICK_WRITER_H

#include <brick/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

struct brick_writer;

int brick_writer_create(struct brick_writer **writer, const char *path, const struct brick_grid *grid,
                        struct brick_error *err);
/* What the header says of lossy bricks, see brick_volume_tolerance; 0 unless set. */
void brick_writer_set_tolerance(struct brick_writer *writer, double tolerance);
/* Allow payloads of coarser levels to wait in this much memory (0 until called; before the first brick). */
void brick_writer_keep(struct brick_writer *writer, uint64_t bytes);
/* entry's range, mask, codec, flags, value and nonfinite are the caller's; offset, bytes and checksum are the
 * writer's. payload is NULL and bytes 0 for a constant brick. Within a level ids must ascend by one. */
int brick_writer_put(struct brick_writer *writer, uint64_t id, const struct brick_entry *entry,
                     const void *payload, size_t bytes, struct brick_error *err);
/* Every brick must have been put. On success *file_bytes is the file's size. */
int brick_writer_finish(struct brick_writer *writer, const struct brick_stats *stats, const char *provenance,
                        uint64_t *file_bytes, struct brick_error *err);
void brick_writer_destroy(struct brick_writer **writer);

#ifdef __cplusplus
}
#endif
#endif
