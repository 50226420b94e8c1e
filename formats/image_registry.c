/* Pictures by ending, written under PATH.part and renamed when whole, so that a picture under its own name is
 * always complete and a failed write leaves what was there before. */
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "image_formats.h"

const struct fmt_image_params fmt_image_defaults = {{0, 0, 0}};

struct image_format {
    const char *ending, *library, *package;
    /* NULL when the library is not in this build (both), or the format is not read (read). */
    int (*write)(const struct brick_io *io, const struct brick_image *image,
                 const struct fmt_image_params *params, struct brick_error *err);
    int (*read)(struct brick_image *image, const struct brick_io *io, struct brick_error *err);
};

static const struct image_format formats[] = {
#ifdef HAVE_OPENEXR
    {".exr", "OpenEXR", "libopenexr-dev", image_exr_write, image_exr_read},
#else
    {".exr", "OpenEXR", "libopenexr-dev", NULL, NULL},
#endif
#ifdef HAVE_PNG
    {".png", "libpng", "libpng-dev", image_png_write, NULL},
#else
    {".png", "libpng", "libpng-dev", NULL, NULL},
#endif
};

static int find_format(const struct image_format **format, const char *path, struct brick_error *err)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    const char *ending = strrchr(name, '.');
    for (size_t i = 0; ending && ending != name && i < sizeof formats / sizeof *formats; i++)
        if (strcasecmp(ending, formats[i].ending) == 0) {
            *format = &formats[i];
            if (!formats[i].write)
                return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                                  "%s: this build has no %s: install %s (%s on Debian) and build again", path,
                                  formats[i].ending + 1, formats[i].library, formats[i].package);
            return BRICK_OK;
        }
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: not a picture's name: it must end in .exr or .png",
                      path);
}

/* The folder that path is in, as a new string. */
static char *folder_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    if (!slash)
        return strdup(".");
    return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

int fmt_image_check_path(const char *path, struct brick_error *err)
{
    const struct image_format *format;
    struct stat status;
    int result = find_format(&format, path, err);
    if (result)
        return result;
    char *folder = folder_of(path);
    if (!folder)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    if (stat(folder, &status))
        result = brick_fail(err, BRICK_ERR_IO, "%s: cannot be written: folder %s: %s", path, folder,
                            strerror(errno));
    else if (!S_ISDIR(status.st_mode))
        result = brick_fail(err, BRICK_ERR_IO, "%s: cannot be written: %s is not a folder", path, folder);
    else if (access(folder, W_OK | X_OK))
        result = brick_fail(err, BRICK_ERR_IO, "%s: cannot be written: folder %s: %s", path, folder,
                            strerror(errno));
    else if (stat(path, &status) == 0 && S_ISDIR(status.st_mode))
        result = brick_fail(err, BRICK_ERR_IO, "%s: cannot be written: it is a folder", path);
    free(folder);
    return result;
}

int fmt_image_write(const char *path, const struct brick_image *image, const struct fmt_image_params *params,
                    struct brick_error *err)
{
    const struct image_format *format;
    struct brick_part part = {BRICK_IO_CLOSED, NULL};
    int result = fmt_image_check_path(path, err);
    if (result || (result = find_format(&format, path, err)))
        return result;
    if (!image->rgba || image->width < 1 || image->height < 1 || image->width > BRICK_IMAGE_MAX_DIM ||
        image->height > BRICK_IMAGE_MAX_DIM)
        return brick_fail(err, BRICK_ERR_ARGUMENT,
                          "%s: a picture of %ux%u pixels; 1 to %d on a side are possible", path, image->width,
                          image->height, BRICK_IMAGE_MAX_DIM);
    for (int i = 0; i < 3; i++)
        if (!isfinite(params->background[i]))
            return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: the background is not finite", path);
    if (!(result = brick_part_create(&part, path, err)) &&
        !(result = format->write(&part.io, image, params, err)))
        result = brick_part_publish(&part, err);
    brick_part_discard(&part);
    return result;
}

int fmt_png_encode(const struct fmt_samples *samples, void **png, size_t *bytes, struct brick_error *err)
{
    *png = NULL;
    *bytes = 0;
    if (samples->width < 1 || samples->height < 1 || samples->width > BRICK_IMAGE_MAX_DIM ||
        samples->height > BRICK_IMAGE_MAX_DIM)
        return brick_fail(err, BRICK_ERR_ARGUMENT,
                          "a picture of %ux%u pixels; 1 to %d on a side are possible", samples->width,
                          samples->height, BRICK_IMAGE_MAX_DIM);
    if (samples->channels != 1 && samples->channels != 3 && samples->channels != 4)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "a picture of %u channels; 1, 3 and 4 are possible",
                          samples->channels);
#ifdef HAVE_PNG
    return image_png_encode(samples, png, bytes, err);
#else
    return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                      "this build has no png: install libpng (libpng-dev on Debian) and build again");
#endif
}

int fmt_image_read(struct brick_image *image, const char *path, struct brick_error *err)
{
    const struct image_format *format;
    struct brick_io io = BRICK_IO_CLOSED;
    *image = (struct brick_image){0};
    int result = find_format(&format, path, err);
    if (result)
        return result;
    if (!format->read)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: %s is written only; exact pictures are .exr", path,
                          format->ending);
    if ((result = brick_io_open(&io, path, err)))
        return result;
    result = format->read(image, &io, err);
    brick_io_close(&io);
    return result;
}
