/* Picture formats: what image_registry.c (endings, temporary names) asks of a format. */
#ifndef FORMATS_IMAGE_FORMATS_H
#define FORMATS_IMAGE_FORMATS_H

#include <brick/io.h>

#include <formats/formats.h>

/* Write a whole picture to a new, empty file. On failure the caller removes it. */
int image_exr_write(const struct brick_io *io, const struct brick_image *image,
                    const struct fmt_image_params *params, struct brick_error *err);
int image_png_write(const struct brick_io *io, const struct brick_image *image,
                    const struct fmt_image_params *params, struct brick_error *err);
/* samples were checked. */
int image_png_encode(const struct fmt_samples *samples, void **png, size_t *bytes, struct brick_error *err);
/* image is initialised on success only. */
int image_exr_read(struct brick_image *image, const struct brick_io *io, struct brick_error *err);

#endif
