/* What is done to samples, many at once: find those that can be visible, look at them, take what shows.
 * Samples of all rays of a tile that go through a brick wait in queues between one and the next, so vectors
 * are full however few samples of a ray get there. */
#ifndef RENDERER_CAST_KERNELS_H
#define RENDERER_CAST_KERNELS_H

#include <stdbool.h>
#include <stdint.h>

#include <brick/type.h>

#include "transfer_table.h"

enum {
    VR_CAST_LANES_MAX = 16,
    VR_CAST_ROUND = 32,  /* samples of a ray that are queued before they are looked at */
    VR_CAST_QUEUE = 512, /* samples that wait at most, and a round: so few stay in a core's first caches */
    VR_CAST_ROOM = VR_CAST_QUEUE + VR_CAST_ROUND + VR_CAST_LANES_MAX
};

/* A brick as it lies in memory. */
struct vr_cast_brick {
    const void *voxels;
    int32_t row, slice;   /* strides in voxels */
    int32_t border;       /* first voxel of the core on each axis */
    const uint32_t *bits; /* of its active macrocells; NULL: all */
    uint32_t words;       /* of bits */
    int32_t bit_row, bit_slice;
    int32_t macro_shift;
};

/* Samples of one ray, a step apart, in one brick. */
struct vr_cast_run {
    uint64_t at[3], step[3]; /* 8.56 fixed point */
    int32_t offset[3];       /* voxel of the brick = whole part + offset */
    uint32_t count, ray;
    float length_mm;
};

/* Samples in active macrocells. voxel: number of the cell's first corner. */
struct vr_cast_queue {
    _Alignas(64) uint32_t ray[VR_CAST_ROOM];
    _Alignas(64) int32_t voxel[VR_CAST_ROOM];
    _Alignas(64) uint32_t at[3][VR_CAST_ROOM]; /* the lower 24 bits are the fraction */
    _Alignas(64) float length_mm[VR_CAST_ROOM];
    uint32_t count;
};

/* Samples that can be visible. */
struct vr_cast_seen {
    _Alignas(64) uint32_t ray[VR_CAST_ROOM];
    _Alignas(64) int32_t voxel[VR_CAST_ROOM];
    _Alignas(64) float value[VR_CAST_ROOM], length_mm[VR_CAST_ROOM], fraction[3][VR_CAST_ROOM];
    _Alignas(64) float depth[VR_CAST_ROOM], alpha[VR_CAST_ROOM]; /* optical; opacity */
    _Alignas(64) float rgb[3][VR_CAST_ROOM];
    uint32_t count;
};

/* Rays that go through a brick side by side, one a lane, which where nothing can be skipped is less work than
 * queues are. Those that go on are first. */
enum { VR_CAST_STEPS = 8, VR_CAST_PACKET = 256, VR_CAST_PACKET_ROOM = VR_CAST_PACKET + VR_CAST_LANES_MAX };
_Static_assert((int)VR_CAST_STEPS *(int)VR_CAST_LANES_MAX <= (int)VR_CAST_ROOM, "looked at in one go");
struct vr_cast_sums {
    _Alignas(64) uint32_t ray[VR_CAST_PACKET_ROOM];
    _Alignas(64) float depth[VR_CAST_PACKET_ROOM];  /* mip: 1 when there is a value */
    _Alignas(64) float rgb[3][VR_CAST_PACKET_ROOM]; /* mip: rgb[0] is the largest value */
    uint32_t count;
};
struct vr_cast_packet {
    struct vr_cast_sums on, ended;
    /* Of those that go on: 8.56 fixed point, low and high words; voxel that the whole parts count from;
     * samples that are left. */
    _Alignas(64) uint32_t at[3][2][VR_CAST_PACKET_ROOM], step[3][2][VR_CAST_PACKET_ROOM];
    _Alignas(64) int32_t voxel[VR_CAST_PACKET_ROOM];
    _Alignas(64) uint32_t left[VR_CAST_PACKET_ROOM];
    _Alignas(64) float length_mm[VR_CAST_PACKET_ROOM];
};

struct vr_cast_field {
    float sign;       /* of the slope: values ascend with the physical ones */
    float visible[2]; /* of other values nothing shows */
    bool nonfinite;   /* voxels may be; their cells are transparent */
};

struct vr_cast_light {
    float normal[3][3]; /* gradient in the level's index space to world */
    float ambient, diffuse, specular, shininess;
    const float *view[3]; /* a ray's direction, by its number */
};

/* A transfer function's pieces row by row: what struct vr_piece has of each, one after the other. */
enum vr_cast_row {
    VR_CAST_START,
    VR_CAST_ORIGIN,
    VR_CAST_SIGMA,
    VR_CAST_SIGMA_SLOPE,
    VR_CAST_RGB,
    VR_CAST_RGB_SLOPE = VR_CAST_RGB + 3,
    VR_CAST_ROWS = VR_CAST_RGB_SLOPE + 3
};
struct vr_cast_pieces {
    const struct vr_transfer_table *table;
    float *row[VR_CAST_ROWS]; /* 64-byte aligned, 64 values at least; row[0] is the memory */
};
int vr_cast_pieces_init(struct vr_cast_pieces *pieces, const struct vr_transfer_table *table,
                        struct brick_error *err);
void vr_cast_pieces_finish(struct vr_cast_pieces *pieces);

struct vr_cast_kernels {
    /* Queue samples of the run in active macrocells (brick->bits is not NULL), in order, until it ends or
     * VR_CAST_ROUND have been queued, or `lanes` - 1 more. */
    void (*scan)(struct vr_cast_queue *queue, const struct vr_cast_brick *brick, struct vr_cast_run *run);
    /* Fill in depth, alpha and rgb from value and length. */
    void (*classify)(struct vr_cast_seen *seen, const struct vr_cast_pieces *pieces);
    /* alpha from depth. */
    void (*opacities)(struct vr_cast_seen *seen);
    /* alpha[i] *= exp(-before[i]) */
    void (*dim)(struct vr_cast_seen *seen, const float *before);
    /* What has been seen of rays i to i + lanes - 1 of a packet that had `rays`: added to their sums, or
     * their largest; then those that have no more samples, or have passed depth_end, to `ended`, the others
     * back to the packet. */
    void (*sum)(struct vr_cast_packet *packet, uint32_t i, uint32_t rays, const struct vr_cast_seen *seen,
                float depth_end);
    void (*largest)(struct vr_cast_packet *packet, uint32_t i, uint32_t rays,
                    const struct vr_cast_seen *seen);
    uint32_t lanes; /* of a packet that are drawn at once */
    struct vr_cast_typed {
        /* Those of the queue that can be visible, in order; place: voxel and fraction are wanted too. */
        void (*look)(struct vr_cast_seen *seen, const struct vr_cast_queue *queue,
                     const struct vr_cast_brick *brick, const struct vr_cast_field *field, bool place);
        /* rgb lit. */
        void (*shade)(struct vr_cast_seen *seen, const struct vr_cast_brick *brick,
                      const struct vr_cast_light *light, bool nonfinite);
        /* Up to VR_CAST_STEPS samples of each of a packet's rays i to i + lanes - 1, one of each after the
         * other; value is NaN where nothing shows, place as above. Returns how many were looked at. */
        uint32_t (*march)(struct vr_cast_seen *seen, struct vr_cast_packet *packet, uint32_t i,
                          const struct vr_cast_brick *brick, const struct vr_cast_field *field, bool place);
    } typed[BRICK_TYPE_STORED_COUNT];
};

/* The i-th table that this processor can run, the best first, the plain one last; NULL beyond. All give the
 * same bits. */
const struct vr_cast_kernels *vr_cast_kernels_table(unsigned i);

/* From here on numbers too small for a normal float are 0 to this thread, as they are to llvmpipe's and most
 * GPUs'; until restore is given what flush returned. Other processors than x86 go on with them. */
unsigned vr_cast_flush(void);
void vr_cast_restore(unsigned kept);

#endif
