/* A plain picture: float32 premultiplied linear RGBA, row 0 on top, no padding. */
#ifndef BRICK_IMAGE_H
#define BRICK_IMAGE_H

#include <stdint.h>

#include <brick/error.h>

#ifdef __cplusplus
extern "C" {
#endif

#define BRICK_IMAGE_MAX_DIM 32768

struct brick_image {
    uint32_t width, height;
    float *rgba; /* width * height * 4, owned */
};

/* 1..BRICK_IMAGE_MAX_DIM on each side; zeroed. */
int brick_image_init(struct brick_image *image, uint32_t width, uint32_t height, struct brick_error *err);
void brick_image_finish(struct brick_image *image);

/* Differences over premultiplied linear RGBA, all four channels; in double. */
struct brick_image_difference {
    double max_abs;
    uint32_t max_x, max_y, max_channel; /* where max_abs is */
    double rmse;
    double psnr_db; /* peak 1; infinite when equal */
    uint64_t pixels_differing;
    uint64_t covered_only_a, covered_only_b; /* alpha is above 0 in that picture only: of isosurfaces, hits */
};
/* BRICK_ERR_ARGUMENT when the sizes differ. A NaN in either counts as an infinite difference unless both are
 * NaN. */
int brick_image_compare(const struct brick_image *a, const struct brick_image *b,
                        struct brick_image_difference *difference, struct brick_error *err);

#ifdef __cplusplus
}
#endif
#endif
