/* One brick's bytes, and its voxels from them: of a complete file, and of one that is still being written. */
#include "payload.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

void brick_scratch_finish(struct brick_scratch *scratch)
{
    free(scratch->data);
    *scratch = (struct brick_scratch){0};
}

/* Store v as n voxels of a type; v is one of its values. */
static void fill(enum brick_type type, void *dst, size_t n, float value)
{
    switch (type) {
    case BRICK_U8:
        memset(dst, (uint8_t)value, n);
        break;
    case BRICK_I8:
        memset(dst, (uint8_t)(int8_t)value, n);
        break;
    case BRICK_U16:
        for (size_t i = 0; i < n; i++)
            ((uint16_t *)dst)[i] = (uint16_t)value;
        break;
    case BRICK_I16:
        for (size_t i = 0; i < n; i++)
            ((int16_t *)dst)[i] = (int16_t)value;
        break;
    default:
        for (size_t i = 0; i < n; i++)
            ((float *)dst)[i] = value;
        break;
    }
}

/* A constant brick's voxels are `value`; its macrocells hold the index's range. */
static int fill_constant(const struct brick_io *io, const struct brick_grid *grid,
                         const struct brick_place *place, uint64_t id, const struct brick_entry *e, void *dst,
                         struct brick_error *err)
{
    static const float lowest[] = {0.0f, -128.0f, 0.0f, -32768.0f, -INFINITY};
    static const float highest[] = {255.0f, 127.0f, 65535.0f, 32767.0f, INFINITY};
    enum brick_type type = grid->type;
    size_t width = brick_type_bytes(type), voxels = brick_place_voxel_bytes(grid, place) / width;
    size_t total = brick_place_payload_bytes(grid, place) / width;
    float values[3] = {0.0f, e->min, e->max};
    memcpy(&values[0], &e->value, sizeof values[0]);
    for (int i = 0; type != BRICK_F32 && i < 3; i++)
        if (!(values[i] >= lowest[type] && values[i] <= highest[type] && values[i] == truncf(values[i])))
            return brick_fail_at(err, BRICK_ERR_FORMAT, BRICK_NO_OFFSET, id,
                                 "%s: brick %llu is a constant %g, not a %s", io->path,
                                 (unsigned long long)id, (double)values[i], brick_type_name(type));
    fill(type, dst, voxels, values[0]);
    for (size_t i = voxels; i < total; i++)
        fill(type, (unsigned char *)dst + i * width, 1, values[1 + (i - voxels) % 2]);
    return BRICK_OK;
}

int payload_fetch(const struct brick_io *io, const struct brick_entry *e, struct brick_scratch *scratch,
                  struct brick_error *err)
{
    if (scratch->bytes < e->bytes) {
        void *grown = realloc(scratch->data, e->bytes);
        if (!grown)
            return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory for it", io->path);
        scratch->data = grown;
        scratch->bytes = e->bytes;
    }
    int code = brick_io_read_at(io, e->offset, scratch->data, e->bytes, err);
    if (!code && XXH3_64bits(scratch->data, e->bytes) != e->checksum)
        code = brick_fail(err, BRICK_ERR_CHECKSUM, "%s: its checksum does not match: the file is damaged",
                          io->path);
    return code;
}

int payload_read(const struct brick_io *io, const struct brick_grid *grid, uint64_t id,
                 const struct brick_entry *e, void *dst, struct brick_scratch *scratch,
                 struct brick_error *err)
{
    struct brick_place place;
    brick_grid_place(grid, id, &place);
    if (e->flags & BRICK_FLAG_CONSTANT)
        return fill_constant(io, grid, &place, id, e, dst, err);
    struct brick_codec_shape shape = brick_codec_shape(grid, &place);
    struct brick_error inner = {0};
    int code = payload_fetch(io, e, scratch, &inner);
    if (!code)
        code = brick_codec_decode((enum brick_codec)e->codec, &shape, scratch->data, e->bytes, dst, &inner);
    if (!code)
        return BRICK_OK;
    return brick_fail_at(
        err, code, e->offset, id, "brick %llu (level %u, %llu,%llu,%llu; %u bytes at %llu): %.400s",
        (unsigned long long)id, place.level, (unsigned long long)place.at[0], (unsigned long long)place.at[1],
        (unsigned long long)place.at[2], e->bytes, (unsigned long long)e->offset, inner.message);
}
