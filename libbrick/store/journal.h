/* What a killed writer leaves for the next one: whose bricks these are, and the index entries of level 0's
 * bricks that are in PATH.part. A file beside it, gone when the volume is complete.
 *
 * Layout, numbers as in a .brick file: 8 bytes that name it, bytes and checksum of the identity, the identity
 * (text, one "key: value" a line); then blocks of the count of entries, their checksum (its seed is the first
 * brick's number), and the entries, offsets counted from the first payload. */
#ifndef BRICK_STORE_JOURNAL_H
#define BRICK_STORE_JOURNAL_H

#include <brick/io.h>

#include "layout.h"

#define JOURNAL_BLOCK_ENTRIES 64u
#define JOURNAL_BLOCK_BYTES   16u /* and the entries */

struct journal {
    struct brick_io io; /* closed: nothing is written down */
    uint64_t start;     /* of the first block */
    uint64_t end;       /* of the last */
    uint64_t entries;   /* in blocks */
    uint64_t payload;   /* bytes of the bricks that are not */
    size_t waiting;     /* entries that are not */
    unsigned char block[JOURNAL_BLOCK_BYTES + JOURNAL_BLOCK_ENTRIES * LAYOUT_ENTRY_BYTES];
};

/* An empty one, over whatever is there. */
int journal_create(struct journal *journal, const char *path, const char *identity, struct brick_error *err);
/* Go on with one: its first *count entries, at most `most`, whose offsets were checked to lie one behind the
 * other. Where there is none, or one whose writer was killed before anything was in it, it is created.
 * BRICK_ERR_ARGUMENT when it is of another identity; part: the file that it belongs to, for messages. */
int journal_open(struct journal *journal, const char *path, const char *identity, const char *part,
                 struct brick_entry *entries, uint64_t most, uint64_t *count, struct brick_error *err);
/* Of the next brick, whose payload is written. Now and then, what waits is written. */
int journal_put(struct journal *journal, const struct brick_entry *entry, struct brick_error *err);
int journal_flush(struct journal *journal, struct brick_error *err);
/* Only the first `count` of `entries` count any more. */
int journal_cut(struct journal *journal, const struct brick_entry *entries, uint64_t count,
                struct brick_error *err);
void journal_close(struct journal *journal);

#endif
