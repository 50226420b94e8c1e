/* OpenEXR through its C core: what the renderer made, bit for bit.
 *
 * Written: one part of scanlines, ZIP, channels A B G R as float, premultiplied and linear (OpenEXR's own
 * convention); only the required attributes, so equal pictures give equal bytes. Read: one part of scanlines,
 * R G B and perhaps A, as float or half. The library does its I/O through the callbacks here, so that short
 * writes, the file's size and messages are ours; it prints nothing. */
#include <stdlib.h>
#include <string.h>

#include <openexr.h>

#include "image_formats.h"

static const char *const channel_names[4] = {"R", "G", "B", "A"};

struct stream {
    const struct brick_io *io;
    uint64_t bytes; /* the file's size, when reading */
    struct brick_error *err;
    int failed; /* the first failure, already described in *err */
};

static struct stream *stream_of(exr_const_context_t context)
{
    void *user = NULL;
    if (!context || exr_get_user_data(context, &user) != EXR_ERR_SUCCESS)
        return NULL;
    return user;
}

/* The library has several messages for one failure: the first says most. */
static void on_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    struct stream *stream = stream_of(context);
    if (!stream || stream->failed)
        return;
    const int result = code == EXR_ERR_OUT_OF_MEMORY ? BRICK_ERR_MEMORY : BRICK_ERR_FORMAT;
    stream->failed = brick_fail(stream->err, result, "%s: OpenEXR: %s", stream->io->path, message);
}

static int64_t read_data(exr_const_context_t context, void *user, void *buffer, uint64_t n, uint64_t offset,
                         exr_stream_error_func_ptr_t error)
{
    (void)context, (void)error;
    struct stream *stream = user;
    if (offset >= stream->bytes)
        return 0;
    if (n > stream->bytes - offset)
        n = stream->bytes - offset;
    const int result =
        brick_io_read_at(stream->io, offset, buffer, (size_t)n, stream->failed ? NULL : stream->err);
    if (result) {
        stream->failed = stream->failed ? stream->failed : result;
        return -1;
    }
    return (int64_t)n;
}

static int64_t file_size(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((struct stream *)user)->bytes;
}

static int64_t write_data(exr_const_context_t context, void *user, const void *buffer, uint64_t n,
                          uint64_t offset, exr_stream_error_func_ptr_t error)
{
    (void)context, (void)error;
    struct stream *stream = user;
    const int result =
        brick_io_write_at(stream->io, offset, buffer, (size_t)n, stream->failed ? NULL : stream->err);
    if (result) {
        stream->failed = stream->failed ? stream->failed : result;
        return -1;
    }
    return (int64_t)n;
}

/* What the library's answer means for our caller. */
static int outcome(const struct stream *stream, exr_result_t code, struct brick_error *err)
{
    if (stream->failed)
        return stream->failed;
    if (code == EXR_ERR_SUCCESS)
        return BRICK_OK;
    return brick_fail(err, code == EXR_ERR_OUT_OF_MEMORY ? BRICK_ERR_MEMORY : BRICK_ERR_FORMAT,
                      "%s: OpenEXR: %s", stream->io->path, exr_get_default_error_message(code));
}

/* Address of the float in `rgba` that channel c of pixel (0, y) has. */
static uint8_t *channel_at(const struct brick_image *image, uint32_t y, unsigned c)
{
    return (uint8_t *)(image->rgba + (size_t)y * image->width * 4 + c);
}

static int channel_index(const char *name)
{
    for (int c = 0; c < 4; c++)
        if (strcmp(name, channel_names[c]) == 0)
            return c;
    return -1;
}

static exr_result_t write_header(exr_context_t context, const struct brick_image *image)
{
    int part;
    exr_result_t code = exr_add_part(context, NULL, EXR_STORAGE_SCANLINE, &part);
    if (!code)
        code = exr_initialize_required_attr_simple(context, part, (int32_t)image->width,
                                                   (int32_t)image->height, EXR_COMPRESSION_ZIP);
    for (int c = 3; c >= 0 && !code; c--) /* A B G R: the order they have in the file */
        code = exr_add_channel(context, part, channel_names[c], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC,
                               1, 1);
    return code ? code : exr_write_header(context);
}

/* The library's own step; a struct since a pointer to data cannot be one to a function. */
struct squeeze {
    exr_result_t (*library)(exr_encode_pipeline_t *encoder);
};

/* Readers take a chunk of as many bytes as its pixels for the pixels themselves. The library stores them so
 * where compression makes more of them, but not (in 3.1) where it makes just as many. */
static exr_result_t compress(exr_encode_pipeline_t *encoder)
{
    const struct squeeze *squeeze = encoder->encoding_user_data;
    const exr_result_t code = squeeze->library(encoder);
    if (!code && encoder->compressed_bytes == encoder->packed_bytes)
        memmove(encoder->compressed_buffer, encoder->packed_buffer, encoder->packed_bytes);
    return code;
}

static exr_result_t write_chunks(exr_context_t context, const struct brick_image *image)
{
    struct squeeze squeeze;
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(context, 0, &lines);
    for (uint32_t y = 0; y < image->height && !code; y += (uint32_t)lines) {
        if ((code = exr_write_scanline_chunk_info(context, 0, (int)y, &chunk)))
            break;
        code = y == 0 ? exr_encoding_initialize(context, 0, &chunk, &encoder)
                      : exr_encoding_update(context, 0, &chunk, &encoder);
        if (code)
            break;
        for (int16_t i = 0; i < encoder.channel_count; i++) {
            exr_coding_channel_info_t *channel = &encoder.channels[i];
            channel->user_bytes_per_element = sizeof(float);
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_pixel_stride = 4 * sizeof(float);
            channel->user_line_stride = (int32_t)(image->width * 4 * sizeof(float));
            channel->encode_from_ptr = channel_at(image, y, (unsigned)channel_index(channel->channel_name));
        }
        if (y == 0) {
            if ((code = exr_encoding_choose_default_routines(context, 0, &encoder)))
                break;
            squeeze.library = encoder.compress_fn;
            encoder.compress_fn = compress;
            encoder.encoding_user_data = &squeeze;
        }
        code = exr_encoding_run(context, 0, &encoder);
    }
    exr_encoding_destroy(context, &encoder);
    return code;
}

int image_exr_write(const struct brick_io *io, const struct brick_image *image,
                    const struct fmt_image_params *params, struct brick_error *err)
{
    (void)params; /* the background is for pictures without alpha */
    struct stream stream = {.io = io, .err = err};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t context = NULL;
    setup.error_handler_fn = on_error;
    setup.user_data = &stream;
    setup.write_fn = write_data;
    setup.zip_level = 4;
    exr_result_t code = exr_start_write(&context, io->path, EXR_WRITE_FILE_DIRECTLY, &setup);
    if (!code && !(code = write_header(context, image)))
        code = write_chunks(context, image);
    if (context) { /* writes the table of chunks */
        const exr_result_t finish = exr_finish(&context);
        code = code ? code : finish;
    }
    const int result = outcome(&stream, code, err);
    /* Whatever the library could not do to a new file is not the fault of its bytes. */
    return result == BRICK_ERR_FORMAT ? BRICK_ERR_IO : result;
}

/* Everything about a picture that can be judged before memory is taken. */
static int check_header(exr_const_context_t context, const struct stream *stream, uint32_t *width,
                        uint32_t *height, bool *has_alpha, struct brick_error *err)
{
    const char *path = stream->io->path;
    int parts = 0;
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t data, display;
    const exr_attr_chlist_t *channels = NULL;
    exr_result_t code;
    if ((code = exr_get_count(context, &parts)) || (code = exr_get_storage(context, 0, &storage)) ||
        (code = exr_get_compression(context, 0, &compression)) ||
        (code = exr_get_data_window(context, 0, &data)) ||
        (code = exr_get_display_window(context, 0, &display)) ||
        (code = exr_get_channels(context, 0, &channels)))
        return outcome(stream, code, err);
    if (parts != 1)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: %d parts; only pictures of one part are read",
                          path, parts);
    if (storage != EXR_STORAGE_SCANLINE)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: %s; only plain scanline pictures are read", path,
                          storage == EXR_STORAGE_TILED ? "tiled" : "deep");
    if (compression > EXR_COMPRESSION_B44A)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: DWA compression is lossy and not read", path);
    if (memcmp(&data, &display, sizeof data) != 0)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: cropped: its data and display windows differ",
                          path);
    const int64_t w = (int64_t)data.max.x - data.min.x + 1, h = (int64_t)data.max.y - data.min.y + 1;
    if (w < 1 || h < 1 || w > BRICK_IMAGE_MAX_DIM || h > BRICK_IMAGE_MAX_DIM)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: %lldx%lld pixels; 1 to %d on a side are possible", path,
                          (long long)w, (long long)h, BRICK_IMAGE_MAX_DIM);
    unsigned found = 0;
    uint64_t pixel_bytes = 0;
    for (int i = 0; i < channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *channel = &channels->entries[i];
        const int c = channel_index(channel->name.str);
        pixel_bytes += channel->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
        if (c < 0)
            continue; /* another layer's, depth, ... */
        if (channel->pixel_type == EXR_PIXEL_UINT || channel->x_sampling != 1 || channel->y_sampling != 1)
            return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                              "%s: channel %s is %s; only float and half are read", path, channel->name.str,
                              channel->pixel_type == EXR_PIXEL_UINT ? "of integers" : "subsampled");
        found |= 1u << c;
    }
    if ((found & 7) != 7)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: has no channels R, G and B", path);
    /* zlib cannot shrink below 1/1032, and nothing read here does better than twice that. */
    if ((uint64_t)w * (uint64_t)h * pixel_bytes / 2064 > stream->bytes)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: %llu bytes are too few for %lldx%lld pixels", path,
                          (unsigned long long)stream->bytes, (long long)w, (long long)h);
    *width = (uint32_t)w;
    *height = (uint32_t)h;
    *has_alpha = found & 8;
    return BRICK_OK;
}

/* IEEE 754 half to single: exact, NaN payloads kept. */
static uint32_t single_from_half(uint32_t half)
{
    const uint32_t sign = (half & 0x8000) << 16, magnitude = half & 0x7fff;
    if (magnitude >= 0x7c00) /* infinity, NaN */
        return sign | 0x7f800000 | (magnitude & 0x3ff) << 13;
    if (magnitude >= 0x400)
        return sign | ((magnitude << 13) + ((127u - 15u) << 23));
    const float denormal = (float)magnitude * 0x1p-24f;
    uint32_t bits;
    memcpy(&bits, &denormal, sizeof bits);
    return sign | bits;
}

/* Where a chunk goes. */
struct target {
    const struct brick_image *image;
    uint32_t y;
};

/* Samples of a decompressed chunk: little-endian, line by line, in a line channel by channel. Done here
 * because the library's own unpacking of four interleaved half channels swaps them (3.1.5). */
static exr_result_t unpack(exr_decode_pipeline_t *decoder)
{
    const struct target *target = decoder->decoding_user_data;
    const uint32_t width = target->image->width, lines = (uint32_t)decoder->chunk.height;
    const uint8_t *src = decoder->unpacked_buffer;
    uint64_t line_bytes = 0;
    for (int16_t i = 0; i < decoder->channel_count; i++)
        line_bytes += (uint64_t)decoder->channels[i].bytes_per_element * width;
    if (!src || line_bytes * lines != decoder->chunk.unpacked_size)
        return EXR_ERR_CORRUPT_CHUNK;
    for (uint32_t line = 0; line < lines; line++)
        for (int16_t i = 0; i < decoder->channel_count; i++) {
            const exr_coding_channel_info_t *channel = &decoder->channels[i];
            const int c = channel_index(channel->channel_name);
            uint8_t *dst = c < 0 ? NULL : channel_at(target->image, target->y + line, (unsigned)c);
            const bool half = channel->data_type == EXR_PIXEL_HALF;
            for (uint32_t x = 0; dst && x < width; x++, dst += 4 * sizeof(float)) {
                const uint8_t *at = src + (size_t)x * (half ? 2 : 4);
                const uint32_t low = (uint32_t)at[0] | (uint32_t)at[1] << 8;
                const uint32_t bits =
                    half ? single_from_half(low) : low | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
                memcpy(dst, &bits, sizeof bits);
            }
            src += (size_t)channel->bytes_per_element * width;
        }
    return EXR_ERR_SUCCESS;
}

static exr_result_t read_chunks(exr_const_context_t context, const struct brick_image *image)
{
    exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    exr_attr_box2i_t window;
    struct target target = {image, 0};
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(context, 0, &lines);
    if (!code)
        code = exr_get_data_window(context, 0, &window);
    for (; target.y < image->height && !code; target.y += (uint32_t)lines) {
        const int32_t y = window.min.y + (int32_t)target.y;
        if ((code = exr_read_scanline_chunk_info(context, 0, y, &chunk)))
            break;
        /* A chunk that claims other lines than asked for would be unpacked beyond the picture. */
        if (chunk.height < 1 || (uint32_t)chunk.height > image->height - target.y ||
            (uint32_t)chunk.width != image->width || chunk.start_y != y) {
            code = EXR_ERR_CORRUPT_CHUNK;
            break;
        }
        code = target.y == 0 ? exr_decoding_initialize(context, 0, &chunk, &decoder)
                             : exr_decoding_update(context, 0, &chunk, &decoder);
        if (!code && target.y == 0)
            code = exr_decoding_choose_default_routines(context, 0, &decoder);
        decoder.unpack_and_convert_fn = unpack;
        decoder.decoding_user_data = &target;
        if (!code)
            code = exr_decoding_run(context, 0, &decoder);
    }
    exr_decoding_destroy(context, &decoder);
    return code;
}

int image_exr_read(struct brick_image *image, const struct brick_io *io, struct brick_error *err)
{
    struct stream stream = {.io = io, .err = err};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t context = NULL;
    uint32_t width = 0, height = 0;
    bool has_alpha = false;
    int result = brick_io_size(io, &stream.bytes, err);
    if (result)
        return result;
    setup.error_handler_fn = on_error;
    setup.user_data = &stream;
    setup.read_fn = read_data;
    setup.size_fn = file_size;
    setup.max_image_width = setup.max_image_height = BRICK_IMAGE_MAX_DIM;
    setup.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const exr_result_t code = exr_start_read(&context, io->path, &setup);
    if ((result = outcome(&stream, code, err)))
        goto fail;
    if ((result = check_header(context, &stream, &width, &height, &has_alpha, err)) ||
        (result = brick_image_init(image, width, height, err)))
        goto fail;
    if ((result = outcome(&stream, read_chunks(context, image), err))) {
        brick_image_finish(image);
        goto fail;
    }
    for (size_t i = 0; !has_alpha && i < (size_t)width * height; i++)
        image->rgba[4 * i + 3] = 1;
fail:
    if (context)
        exr_finish(&context);
    return result;
}
