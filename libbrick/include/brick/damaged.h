/* Opening a .brick file that brick_volume_open refuses: what repair reads. The volume is an ordinary one but
 * that its entries may be wrong, and its statistics and provenance empty. */
#ifndef BRICK_DAMAGED_H
#define BRICK_DAMAGED_H

#include <brick/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What of a file, payloads apart, is not as it was written. */
struct brick_damage {
    bool header;     /* what it said could be told all the same */
    bool levels;     /* the level table: it follows from the header */
    bool index;      /* entries that cannot be right are all zero now; any other may be wrong */
    bool stats;      /* none are known */
    bool provenance; /* none is known */
    uint64_t bytes;  /* of the file; brick_volume_file_bytes is what it had when it was complete */
};

/* The header must be right but for one byte, or for bytes that are the same in every file: no other part says
 * what volume it is. BRICK_ERR_MEMORY where the index takes more than memory_bytes. */
int brick_volume_open_damaged(struct brick_volume **volume, const char *path, uint64_t memory_bytes,
                              struct brick_damage *damage, struct brick_error *err);

/* Where the payloads end and the tables begin in the complete file. */
uint64_t brick_volume_payload_end(const struct brick_volume *volume);
/* Bytes of the file as they are. */
int brick_volume_read_bytes(const struct brick_volume *volume, uint64_t offset, void *dst, size_t n,
                            struct brick_error *err);
/* Put an entry right. Not while others use the same one. */
void brick_volume_set_entry(struct brick_volume *volume, uint64_t id, const struct brick_entry *entry);

#ifdef __cplusplus
}
#endif
#endif
