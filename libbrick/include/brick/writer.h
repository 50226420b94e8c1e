/* Writing a .brick file: bricks in any order of levels, each level's bricks in ascending order.
 *
 * Level 0's payloads go to PATH.part as they come; those of coarser levels wait in a file beside it, and are
 * appended level by level when finishing; then tables, sync, header, sync, rename. Nothing under PATH changes
 * before that, and a writer destroyed unfinished removes what it wrote, unless it was told to leave it. */
#ifndef BRICK_WRITER_H
#define BRICK_WRITER_H

#include <brick/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

struct brick_writer;

int brick_writer_create(struct brick_writer **writer, const char *path, const struct brick_grid *grid,
                        struct brick_error *err);
/* The same, with a journal in PATH.part.journal, and coarser levels in PATH.part.levels: when the writer is
 * killed, or leaves its work, another one of the same grid and identity can resume it. identity: text, one
 * "key: value" a line: everything on which the bricks depend. resume: keep the bricks that are there; without
 * it, or where there are none, the file is begun anew. BRICK_ERR_ARGUMENT, and nothing changed, when they are
 * of another identity. */
int brick_writer_create_journaled(struct brick_writer **writer, const char *path,
                                  const struct brick_grid *grid, const char *identity, bool resume,
                                  struct brick_error *err);
bool brick_writer_is_journaled(const struct brick_writer *writer);
/* The first `kept` bricks of a level were there already: the next one to put is the one after. Each is to be
 * checked before it is relied on, for a power cut may have taken it. */
uint64_t brick_writer_kept(const struct brick_writer *writer, uint32_t level);
/* The index entry of a brick that is kept, or was put; its offset counts from the level's first payload. */
const struct brick_entry *brick_writer_entry(const struct brick_writer *writer, uint64_t id);
/* BRICK_ERR_CHECKSUM, BRICK_ERR_FORMAT: the brick is not what was written. Safe from several threads at once,
 * as is reading it, as brick_volume_read does. */
int brick_writer_check(const struct brick_writer *writer, uint64_t id, struct brick_scratch *scratch,
                       struct brick_error *err);
int brick_writer_read(const struct brick_writer *writer, uint64_t id, void *dst,
                      struct brick_scratch *scratch, struct brick_error *err);
/* Of each level l keep its first limit[l] bricks at most, and nothing that came after the first brick that
 * goes; before any other brick is put. */
int brick_writer_cut(struct brick_writer *writer, const uint64_t limit[], struct brick_error *err);
/* A note in the journal, of any number of parts: for who resumes, what its user needs in order to go on from
 * here. It is kept when all bricks are that were put before it. */
int brick_writer_note_begin(struct brick_writer *writer, struct brick_error *err);
int brick_writer_note_add(struct brick_writer *writer, const void *bytes, size_t n, struct brick_error *err);
int brick_writer_note_end(struct brick_writer *writer, struct brick_error *err);
/* The last note that is kept, until one is begun: its bytes, 0 when there is none; and some of them. */
uint64_t brick_writer_note_bytes(const struct brick_writer *writer);
int brick_writer_note_read(const struct brick_writer *writer, uint64_t at, void *bytes, size_t n,
                           struct brick_error *err);
/* Destroying the writer will leave what can be resumed: that many bricks, of a journaled writer; 0: none. A
 * writer that has resumed leaves its work in any case. */
uint64_t brick_writer_leave(struct brick_writer *writer);
/* What the header says of lossy bricks, see brick_volume_tolerance; 0 unless set. */
void brick_writer_set_tolerance(struct brick_writer *writer, double tolerance);
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
