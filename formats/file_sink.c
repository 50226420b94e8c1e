/* Why: a file that carries its final name is complete. Everything goes to PATH.part; finish syncs and
 * renames, the data before the header that points to it. */
#include "file_sink.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <brick/io.h>

#include "geometry.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "big-endian hosts need a byte swap before writing");

struct file_sink {
    struct brick_sink base;
    struct brick_part data, side; /* side.path is NULL without a second file */
    uint64_t offset;              /* where the next slice goes */
    uint64_t slice_bytes;
    uint64_t next, slices;
};

static int part_create(struct brick_part *part, const char *path, const char *text, struct brick_error *err)
{
    int code = brick_part_create(part, path, err);
    return code || !text ? code : brick_io_write_at(&part->io, 0, text, strlen(text), err);
}

static void destroy(struct brick_sink *base)
{
    struct file_sink *s = (struct file_sink *)base;
    brick_part_discard(&s->data);
    brick_part_discard(&s->side);
    free(s);
}

static int write_slices(struct brick_sink *base, uint64_t z, uint64_t count, const void *src,
                        struct brick_error *err)
{
    struct file_sink *s = (struct file_sink *)base;
    if (z != s->next || count > s->slices - z)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: slices are written in ascending order, each once",
                          s->data.path);
    int code = brick_io_write_at(&s->data.io, s->offset, src, (size_t)(count * s->slice_bytes), err);
    if (code)
        return code;
    s->offset += count * s->slice_bytes;
    s->next += count;
    return BRICK_OK;
}

static int finish(struct brick_sink *base, struct brick_error *err)
{
    struct file_sink *s = (struct file_sink *)base;
    if (s->next != s->slices)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%s: %llu of %llu slices were written", s->data.path,
                          (unsigned long long)s->next, (unsigned long long)s->slices);
    int code = brick_part_publish(&s->data, err);
    if (code || !s->side.path)
        return code;
    code = brick_part_publish(&s->side, err);
    if (code)
        unlink(s->data.path); /* nobody points to it */
    return code;
}

int fmt_file_sink_create(struct brick_sink **sink, const struct fmt_file_sink_params *params,
                         struct brick_error *err)
{
    uint64_t bytes;
    int code = fmt_geometry_bytes(params->dims, params->type, params->data_path, &bytes, err);
    if (code)
        return code;
    struct file_sink *s = calloc(1, sizeof *s);
    if (!s)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", params->data_path);
    s->base.write = write_slices;
    s->base.finish = finish;
    s->base.destroy = destroy;
    s->data.io = s->side.io = (struct brick_io)BRICK_IO_CLOSED;
    s->slices = params->dims[2];
    s->slice_bytes = bytes / params->dims[2];
    s->offset = params->header ? strlen(params->header) : 0;
    code = part_create(&s->data, params->data_path, params->header, err);
    if (!code && params->side_path)
        code = part_create(&s->side, params->side_path, params->side_header, err);
    if (code)
        destroy(&s->base);
    else
        *sink = &s->base;
    return code;
}
