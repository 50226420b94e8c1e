/* What a killed writer leaves for the next one: whose bricks these are, the index entries of those whose
 * payloads are written, and notes of the writer's user, all in the order in which they came. A file beside
 * PATH.part, gone when the volume is complete.
 *
 * Layout, numbers as in a .brick file: 8 bytes that name it, bytes and checksum of the identity, the identity
 * (text, one "key: value" a line); then blocks of what they are, how many bytes follow, their checksum, and
 * these. What: a level's number, and its next entries follow, offsets counted from the level's first payload;
 * or JOURNAL_NOTE. The checksum's seed is 256 times where the block begins, and what it is. */
#ifndef BRICK_STORE_JOURNAL_H
#define BRICK_STORE_JOURNAL_H

#include <brick/io.h>

#include "layout.h"

#define JOURNAL_BLOCK_ENTRIES 64u
#define JOURNAL_BLOCK_BYTES   24u /* and what follows */
#define JOURNAL_NOTE          255u

struct XXH3_state_s;

struct journal {
    struct brick_io io; /* closed: nothing is written down */
    const struct brick_grid *grid;
    uint64_t start;                    /* of the first block */
    uint64_t end;                      /* of the last */
    uint64_t bricks[BRICK_MAX_LEVELS]; /* of each level, in blocks */
    uint64_t note, note_bytes;         /* the last note: where its bytes begin, and how many; 0: none */
    uint64_t payload;                  /* bytes of the bricks that are not in blocks */
    size_t waiting;                    /* entries that are not, all of one level */
    uint32_t level;                    /* theirs */
    struct XXH3_state_s *hash;         /* of the note that is being written */
    unsigned char block[JOURNAL_BLOCK_BYTES + JOURNAL_BLOCK_ENTRIES * LAYOUT_ENTRY_BYTES];
};

/* An empty one, over whatever is there. The grid is the caller's and stays. */
int journal_create(struct journal *journal, const char *path, const struct brick_grid *grid,
                   const char *identity, struct brick_error *err);
/* Go on with one. Where there is none, or one whose writer was killed before anything was in it, it is
 * created. BRICK_ERR_ARGUMENT when it is of another identity; part: the file that it belongs to, for
 * messages. */
int journal_open(struct journal *journal, const char *path, const struct brick_grid *grid,
                 const char *identity, const char *part, struct brick_error *err);
/* Read what is in one that was opened: journal->bricks[l] entries of each level l to where the grid has them,
 * whose offsets were checked to lie one behind the other. It is cut before the first block that is not whole,
 * or has a brick of a level l that is not among its first `limit[l]`. */
int journal_read(struct journal *journal, struct brick_entry *entries, const uint64_t limit[],
                 struct brick_error *err);
/* Of a level's next brick, whose payload is written. Now and then, what waits is written. */
int journal_put(struct journal *journal, uint32_t level, const struct brick_entry *entry,
                struct brick_error *err);
int journal_flush(struct journal *journal, struct brick_error *err);
/* A note, in as many parts as it takes; it counts from when it is ended. */
int journal_note_begin(struct journal *journal, struct brick_error *err);
int journal_note_add(struct journal *journal, const void *bytes, size_t n, struct brick_error *err);
int journal_note_end(struct journal *journal, struct brick_error *err);
/* Bytes of the last one, from its byte `at` on. */
int journal_note_read(const struct journal *journal, uint64_t at, void *bytes, size_t n,
                      struct brick_error *err);
void journal_close(struct journal *journal);

#endif
