/* What a report must read voxels for: three slices through the middle of the volume, as pictures and as maps
 * of its bricks. */
#ifndef TOOLS_SURVEY_H
#define TOOLS_SURVEY_H

#include <stdbool.h>

#include <brick/volume.h>

#define SURVEY_PICTURE_MAX 1024 /* pixels on a side */

/* One brick of a map. */
struct survey_cell {
    bool constant;
    float entropy; /* bits a voxel: of the values of the core's voxels, f32 by their upper 16 bits; constant:
                      0 */
    float size;    /* payload / decoded bytes; constant: 0 */
};

/* Everything is stored as it is shown: row 0 on top; left is the patient's right or front, top the front or
 * the head. */
struct survey_plane {
    int normal, across, down;        /* index axes; across runs from left to right or back */
    bool across_turned, down_turned; /* the highest index comes first */
    uint32_t level;                  /* of the picture: the finest that is small enough */
    uint64_t voxel;                  /* of that level, on the normal axis */
    uint32_t width, height;
    uint8_t *gray;   /* black and white at the window's ends; black where not finite */
    uint64_t layer;  /* of bricks of level 0, on the normal axis */
    uint64_t stride; /* the map shows every stride-th brick */
    uint32_t columns, rows;
    struct survey_cell *cell;
};

struct survey {
    double window[2]; /* physical: black and white */
    double entropy_max;
    uint64_t bricks_mapped; /* on the three maps */
    struct survey_plane plane[3];
};

/* Reads the bricks of the slices in parallel; their number is bounded whatever the volume's size.
 * threads 0: one a core; fewer are used where bricks are so large that they would need much memory. Zero
 * survey before, and finish it also after a failure. */
int survey_init(struct survey *survey, const struct brick_volume *volume, unsigned threads,
                void (*progress)(void *context, uint64_t done, uint64_t total), void *context,
                struct brick_error *err);
void survey_finish(struct survey *survey);

#endif
