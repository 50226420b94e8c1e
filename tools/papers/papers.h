/* The papers' tables again (`brick bench papers`): what they are measured on, and a function a paper. */
#ifndef TOOLS_PAPERS_PAPERS_H
#define TOOLS_PAPERS_PAPERS_H

#include <stdbool.h>

#include <renderer/renderer.h>

/* A scan, or a synthetic body of the size of one of a paper's. */
struct paper_volume {
    const char *name;
    struct brick_volume *volume;
    struct brick_transfer *transfer;
    double iso[2];    /* of outer and inner surface: skin and bone where there are such */
    uint64_t dims[3]; /* of a body; 0: of a file */
    char path[4096];
};
enum {
    PAPER_BODY_SMALL,
    PAPER_BODY_MEDIUM,
    PAPER_BODY_LARGE,
    PAPER_BODY_HUGE,
    PAPER_CT,
    PAPER_MRI,
    PAPER_LOBB,
    PAPER_VOLUMES
};

struct papers {
    const char *folder;
    uint32_t frames; /* to take medians of */
    struct vr_renderer_params renderer;
    struct paper_volume volume[PAPER_VOLUMES]; /* volume NULL: not there */
};

/* Open a volume, making it first where it is a body. A scan that was not given stays closed: volume NULL. */
int paper_volume_open(struct papers *papers, int kind, struct brick_error *err);
/* Close it, and remove a body. */
void paper_volume_close(struct papers *papers, int kind);

/* Print tables, append them to papers.txt, and write each one's files. */
struct paper_table;
int paper_tables_show(const struct papers *papers, const struct paper_table *const tables[], size_t count,
                      struct brick_error *err);

/* The scene of a volume, from an azimuth, at 512 x 512, parallel where told (projected cells). */
void paper_scene(const struct paper_volume *volume, enum brick_mode mode, double azimuth, bool parallel,
                 struct vr_scene *scene);

/* One of the ways to draw a volume; quality comes as the default. */
typedef void paper_way(const struct paper_volume *volume, size_t way, struct vr_scene *scene,
                       struct vr_quality *quality);
struct paper_time {
    double seconds;          /* median */
    struct vr_report report; /* of the last frame */
};
/* Open a volume and time the ways in turns, each frame from another side; the first, which loads and
 * compiles, not counted. Nothing is timed where paper_volume_open leaves it closed. */
enum { PAPER_WAYS = 8 };
int paper_measure(struct papers *papers, int kind, paper_way *way, size_t ways, struct paper_time *times,
                  struct brick_error *err);

/* Each makes its tables in the folder and prints them. */
int paper_krueger(struct papers *papers, struct brick_error *err);
int paper_maximo(struct papers *papers, struct brick_error *err);
int paper_parker(struct papers *papers, struct brick_error *err);
int paper_scharsach(struct papers *papers, struct brick_error *err);
int paper_wilson(struct papers *papers, struct brick_error *err);

#endif
