/* PNG through libpng, to look at: a rendered picture over a background into a file, sRGB encoded, 8 bits of
 * R, G and B; or plain 8-bit samples into memory. No time and no text goes in, so equal pictures give equal
 * bytes.
 *
 * libpng reports errors by longjmp. Everything that must outlive it is in struct job, which belongs to the
 * caller of the function that calls setjmp. */
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "image_formats.h"

struct job {
    const struct brick_io *io; /* NULL: to memory */
    uint64_t offset;
    unsigned char *memory; /* owned until it is handed out; offset bytes of room are used */
    size_t room;
    const char *name; /* for messages */
    struct brick_error *err;
    int result;
    png_structp png;
    png_infop info;
    png_bytep row;
};

static int append(struct job *job, const unsigned char *data, size_t n)
{
    if (n > job->room - job->offset) {
        size_t room = job->offset + n > SIZE_MAX / 2 ? SIZE_MAX : 2 * (job->offset + n);
        unsigned char *grown = realloc(job->memory, room);
        if (!grown)
            return brick_fail(job->err, BRICK_ERR_MEMORY, "%s: out of memory", job->name);
        job->memory = grown;
        job->room = room;
    }
    memcpy(job->memory + job->offset, data, n);
    return BRICK_OK;
}

static void write_data(png_structp png, png_bytep data, png_size_t n)
{
    struct job *job = png_get_io_ptr(png);
    job->result = job->io ? brick_io_write_at(job->io, job->offset, data, n, job->err) : append(job, data, n);
    if (job->result)
        png_longjmp(png, 1);
    job->offset += n;
}

static void flush_data(png_structp png)
{
    (void)png; /* the registry syncs the whole file */
}

static void on_error(png_structp png, png_const_charp message)
{
    struct job *job = png_get_error_ptr(png);
    job->result = brick_fail(job->err, BRICK_ERR_IO, "%s: libpng: %s", job->name, message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void)png, (void)message; /* a library is silent */
}

/* IEC 61966-2-1, to 8 bits. NaN gives 0. */
static png_byte encode_srgb(double linear)
{
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 255;
    const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (png_byte)(255 * encoded + 0.5);
}

static void fill_row(png_bytep row, const float *rgba, uint32_t width, const double background[3])
{
    for (uint32_t x = 0; x < width; x++)
        for (int i = 0; i < 3; i++)
            row[3 * x + (uint32_t)i] = encode_srgb((double)rgba[4 * x + (uint32_t)i] +
                                                   (1 - (double)rgba[4 * x + 3]) * background[i]);
}

static bool begin(struct job *job)
{
    job->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, job, on_error, on_warning);
    job->info = job->png ? png_create_info_struct(job->png) : NULL;
    if (job->info)
        return true;
    job->result = brick_fail(job->err, BRICK_ERR_MEMORY, "%s: out of memory", job->name);
    return false;
}

static void write_header(struct job *job, uint32_t width, uint32_t height, int colour)
{
    png_set_write_fn(job->png, job, write_data, flush_data);
    png_set_IHDR(job->png, job->info, width, height, 8, colour, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(job->png, job->info, PNG_sRGB_INTENT_RELATIVE);
    png_write_info(job->png, job->info);
}

/* Leaves an error in job->result. */
static void encode_image(struct job *job, const struct brick_image *image,
                         const struct fmt_image_params *params)
{
    if (setjmp(png_jmpbuf(job->png)))
        return;
    write_header(job, image->width, image->height, PNG_COLOR_TYPE_RGB);
    for (uint32_t y = 0; y < image->height; y++) {
        fill_row(job->row, image->rgba + (size_t)y * image->width * 4, image->width, params->background);
        png_write_row(job->png, job->row);
    }
    png_write_end(job->png, job->info);
}

int image_png_write(const struct brick_io *io, const struct brick_image *image,
                    const struct fmt_image_params *params, struct brick_error *err)
{
    struct job job = {.io = io, .name = io->path, .err = err};
    job.row = malloc((size_t)image->width * 3);
    if (!job.row)
        job.result = brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", io->path);
    else if (begin(&job))
        encode_image(&job, image, params);
    png_destroy_write_struct(&job.png, &job.info);
    free(job.row);
    return job.result;
}

static void encode_samples(struct job *job, const struct fmt_samples *samples)
{
    static const int colour[] = {
        [1] = PNG_COLOR_TYPE_GRAY, [3] = PNG_COLOR_TYPE_RGB, [4] = PNG_COLOR_TYPE_RGB_ALPHA};
    if (setjmp(png_jmpbuf(job->png)))
        return;
    write_header(job, samples->width, samples->height, colour[samples->channels]);
    for (uint32_t y = 0; y < samples->height; y++)
        png_write_row(job->png, samples->data + (size_t)y * samples->width * samples->channels);
    png_write_end(job->png, job->info);
}

int image_png_encode(const struct fmt_samples *samples, void **png, size_t *bytes, struct brick_error *err)
{
    struct job job = {.name = "picture", .err = err};
    if (begin(&job))
        encode_samples(&job, samples);
    png_destroy_write_struct(&job.png, &job.info);
    if (job.result) {
        free(job.memory);
        return job.result;
    }
    *png = job.memory;
    *bytes = (size_t)job.offset;
    return BRICK_OK;
}
