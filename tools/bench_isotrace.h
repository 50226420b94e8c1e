/* Isosurfaces on the CPU as Parker et al. 1998 measure them: `brick bench isotrace`, and the papers' tables.
 */
#ifndef TOOLS_BENCH_ISOTRACE_H
#define TOOLS_BENCH_ISOTRACE_H

#include <renderer/renderer.h>

enum { BENCH_CORES_MAX = 64 };

/* How voxels lie and whether the hierarchy is used (the paper's table 3). */
enum bench_isotrace_variant {
    BENCH_FLAT,
    BENCH_BRICKS,
    BENCH_TILED,
    BENCH_HIERARCHY,
    BENCH_HIERARCHY_TILED,
    BENCH_VARIANTS
};

struct bench_isotrace {
    uint64_t host_cache_bytes;
    unsigned threads; /* 0: one a core */
    uint32_t frames;  /* to take medians of */

    struct vr_iso_profile profile;
    unsigned cores;
    double core_seconds[BENCH_CORES_MAX]; /* for 1, 2, .. cores */
    double seconds[BENCH_VARIANTS];
};

/* Measure a scene of mode iso; the upper three members are given. */
int bench_isotrace_measure(struct bench_isotrace *bench, const struct brick_volume *volume,
                           const struct vr_scene *scene, struct brick_error *err);
/* Percent of all samples of the profile. */
double bench_isotrace_share(const struct vr_iso_profile *profile, uint64_t part);

#endif
