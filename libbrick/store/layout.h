/* The bytes of a .brick file, version 1, and nothing else: docs/FORMAT.md is this header in words. */
#ifndef BRICK_STORE_LAYOUT_H
#define BRICK_STORE_LAYOUT_H

#include <brick/volume.h>

#define LAYOUT_VERSION      1u
#define LAYOUT_HEADER_BYTES 512u
#define LAYOUT_LEVEL_BYTES  104u
#define LAYOUT_ENTRY_BYTES  48u
#define LAYOUT_STATS_BYTES  56u /* and 8 for each bin */
#define LAYOUT_MAX_TEXT     (1u << 20)

enum layout_table { LAYOUT_LEVELS, LAYOUT_INDEX, LAYOUT_STATS, LAYOUT_PROVENANCE, LAYOUT_TABLES };

struct layout_extent {
    uint64_t offset, bytes, checksum;
};

struct layout_header {
    uint64_t file_bytes;
    enum brick_type type;
    uint32_t edge, border, macrocell, levels;
    struct brick_geometry geometry;
    double tolerance; /* physical; 0: lossless */
    struct layout_extent table[LAYOUT_TABLES];
};

/* file: for messages. What decoding finds is well-formed: known version, checksum right, reserved bytes zero.
 */
void layout_put_header(const struct layout_header *header, unsigned char dst[LAYOUT_HEADER_BYTES]);
int layout_get_header(struct layout_header *header, const unsigned char src[LAYOUT_HEADER_BYTES],
                      const char *file, struct brick_error *err);
/* Put right what is wrong, if it is bytes that every header has in common and one more: true when something
 * was. A header that cannot be put right stays as it is. */
bool layout_mend_header(unsigned char bytes[LAYOUT_HEADER_BYTES]);
void layout_put_level(const struct brick_level *level, unsigned char dst[LAYOUT_LEVEL_BYTES]);
void layout_put_entry(const struct brick_entry *entry, unsigned char dst[LAYOUT_ENTRY_BYTES]);
void layout_get_entry(struct brick_entry *entry, const unsigned char src[LAYOUT_ENTRY_BYTES]);
void layout_put_stats(const struct brick_stats *stats, unsigned char *dst); /* LAYOUT_STATS_BYTES + 8 bins */
/* bytes: of the table. histogram: room for (bytes - LAYOUT_STATS_BYTES) / 8 counts. */
int layout_get_stats(struct brick_stats *stats, uint64_t *histogram, const unsigned char *src, uint64_t bytes,
                     enum brick_type type, const char *file, struct brick_error *err);

#endif
