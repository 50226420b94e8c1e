/* Plain pictures, and the difference between two of them. */
#include <brick/image.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>

int brick_image_init(struct brick_image *image, uint32_t width, uint32_t height, struct brick_error *err)
{
    uint64_t floats;
    memset(image, 0, sizeof *image);
    if (width == 0 || height == 0 || width > BRICK_IMAGE_MAX_DIM || height > BRICK_IMAGE_MAX_DIM)
        return brick_fail(err, BRICK_ERR_ARGUMENT,
                          "picture of %u x %u pixels; 1 to %d are allowed on each side", width, height,
                          BRICK_IMAGE_MAX_DIM);
    if (!brick_mul3_u64(width, height, 4, &floats) || floats > SIZE_MAX / sizeof *image->rgba ||
        !(image->rgba = calloc((size_t)floats, sizeof *image->rgba)))
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a picture of %u x %u pixels", width, height);
    image->width = width;
    image->height = height;
    return BRICK_OK;
}

void brick_image_finish(struct brick_image *image)
{
    free(image->rgba);
    memset(image, 0, sizeof *image);
}

static double difference_of(float a, float b)
{
    if (isnan(a) || isnan(b))
        return isnan(a) && isnan(b) ? 0.0 : INFINITY;
    return a == b ? 0.0 : fabs((double)a - (double)b); /* equal infinities differ by nothing */
}

int brick_image_compare(const struct brick_image *a, const struct brick_image *b,
                        struct brick_image_difference *difference, struct brick_error *err)
{
    memset(difference, 0, sizeof *difference);
    if (a->width != b->width || a->height != b->height)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "the pictures differ in size: %u x %u and %u x %u",
                          a->width, a->height, b->width, b->height);
    double total = 0.0;
    for (uint32_t y = 0; y < a->height; y++) {
        double row = 0.0; /* summed by rows, to keep rounding small */
        for (uint32_t x = 0; x < a->width; x++) {
            size_t at = ((size_t)y * a->width + x) * 4;
            int differs = 0;
            for (uint32_t c = 0; c < 4; c++) {
                double d = difference_of(a->rgba[at + c], b->rgba[at + c]);
                row += d * d;
                differs |= d > 0.0;
                if (d > difference->max_abs) {
                    difference->max_abs = d;
                    difference->max_x = x;
                    difference->max_y = y;
                    difference->max_channel = c;
                }
            }
            difference->pixels_differing += (uint64_t)differs;
            bool in_a = a->rgba[at + 3] > 0.0f, in_b = b->rgba[at + 3] > 0.0f;
            difference->covered_only_a += in_a && !in_b;
            difference->covered_only_b += in_b && !in_a;
        }
        total += row;
    }
    difference->rmse = sqrt(total / (4.0 * a->width * a->height));
    difference->psnr_db = difference->rmse > 0.0 ? -20.0 * log10(difference->rmse) : INFINITY;
    return BRICK_OK;
}
