/* Reading a .brick file. The byte layout is docs/FORMAT.md.
 *
 * Opening reads header and tables (48 bytes of memory a brick for the index); after that any brick is one
 * positioned read. All functions on an open volume are safe from several threads at once. */
#ifndef BRICK_VOLUME_H
#define BRICK_VOLUME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <brick/codec.h>
#include <brick/error.h>
#include <brick/grid.h>
#include <brick/stats.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    BRICK_FLAG_CONSTANT = 1 /* no payload: every stored voxel is `value`, every macrocell [min, max] */
};

/* What the index knows of a brick: 48 bytes in the file and in memory. */
struct brick_entry {
    uint64_t offset;   /* of the payload in the file; 0 when constant */
    uint32_t bytes;    /* of the payload as stored; 0 when constant */
    uint8_t codec;     /* enum brick_codec */
    uint8_t flags;     /* BRICK_FLAG_* */
    uint16_t reserved; /* 0 */
    uint64_t checksum; /* XXH3-64 of the payload's bytes as stored; 0 when constant */
    /* Range of the field over the brick's cells (and of level 0's field below them), in stored values, which
     * f32 holds exactly for every stored type. min > max (+inf, -inf) when no voxel is finite. */
    float min, max;
    uint64_t mask;      /* occupancy: bit i: some cell's hull touches bin i of 64 equal bins of [min, max] */
    uint32_t value;     /* bits of the constant as f32, when constant */
    uint32_t nonfinite; /* NaN and Inf among the core's voxels */
};

struct brick_volume;

/* BRICK_ERR_IO, BRICK_ERR_FORMAT (not a .brick file, truncated, contradictory), BRICK_ERR_CHECKSUM,
 * BRICK_ERR_UNSUPPORTED (a newer version). Sizes are checked against the file's before memory is taken. */
int brick_volume_open(struct brick_volume **volume, const char *path, struct brick_error *err);
void brick_volume_close(struct brick_volume **volume);

const struct brick_grid *brick_volume_grid(const struct brick_volume *volume);
const struct brick_stats *brick_volume_stats(const struct brick_volume *volume);
const char *brick_volume_provenance(const struct brick_volume *volume);
const char *brick_volume_path(const struct brick_volume *volume);
uint64_t brick_volume_file_bytes(const struct brick_volume *volume);
/* How far stored voxels may be from the converted ones, in physical units; 0: not at all. Borders of
 * neighbouring bricks may then differ by twice that. */
double brick_volume_tolerance(const struct brick_volume *volume);
/* id < grid->bricks. Entries of consecutive bricks lie one behind the other. */
const struct brick_entry *brick_volume_entry(const struct brick_volume *volume, uint64_t id);
/* Range of a brick in physical values; false (and lo > hi) when no voxel is finite. */
bool brick_volume_physical_range(const struct brick_volume *volume, uint64_t id, double *lo, double *hi);
/* Smallest and largest physical value of level 0; {0, 0} when none is finite. */
void brick_volume_value_range(const struct brick_volume *volume, double range[2]);

/* Growable scratch memory of one thread, for payloads before decoding. Start from zero. */
struct brick_scratch {
    void *data;
    size_t bytes;
};
void brick_scratch_finish(struct brick_scratch *scratch);

/* Read, check and decode brick id to dst, brick_place_payload_bytes bytes: voxels, x fastest, then (min,max)
 * of each macrocell, x fastest. Constant bricks are filled in. Errors name the brick. */
int brick_volume_read(const struct brick_volume *volume, uint64_t id, void *dst,
                      struct brick_scratch *scratch, struct brick_error *err);

/* Copy voxels [lo, hi) of a level to dst, x fastest, no padding. One decoded brick of memory at a time. */
int brick_volume_read_box(const struct brick_volume *volume, uint32_t level, const uint64_t lo[3],
                          const uint64_t hi[3], void *dst, struct brick_error *err);

#ifdef __cplusplus
}
#endif
#endif
