/* Why: PLY (Greg Turk's polygon files), read row by row and no faster than the bytes are there.
 *
 * By this project's own reader, because of the libraries that Debian has: assimp 5.2 crashes on files that
 * are cut off, or never comes back, and the others bring a scene graph or a visualisation toolkit with them.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "colour.h"
#include "mesh_formats.h"
#include "ply_header.h"
#include "text.h"

#define BUFFER_BYTES   65536
#define MAX_WORD_BYTES 64

struct input {
    const struct brick_io *io;
    enum ply_encoding encoding;
    uint64_t offset, bytes; /* of what is behind the buffer; of the file */
    size_t at, count;       /* in the buffer */
    unsigned char buffer[BUFFER_BYTES];
};

static uint64_t left(const struct input *in)
{
    return in->bytes - in->offset + (in->count - in->at);
}

static int fill(struct input *in, struct brick_error *err)
{
    uint64_t more = in->bytes - in->offset, room = BUFFER_BYTES - (in->count - in->at);
    size_t n = (size_t)(more < room ? more : room);
    memmove(in->buffer, in->buffer + in->at, in->count - in->at);
    in->count -= in->at;
    in->at = 0;
    int result = brick_io_read_at(in->io, in->offset, in->buffer + in->count, n, err);
    in->offset += n;
    in->count += n;
    return result;
}

static int ends(const struct input *in, struct brick_error *err)
{
    return brick_fail_at(err, BRICK_ERR_FORMAT, in->bytes, BRICK_NO_BRICK, "%s: the file ends too early",
                         in->io->path);
}

static bool is_space(unsigned char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static int read_word(struct input *in, double *value, struct brick_error *err)
{
    char word[MAX_WORD_BYTES + 1];
    size_t n = 0;
    for (;;) {
        int result = in->at == in->count ? fill(in, err) : BRICK_OK;
        if (result)
            return result;
        bool end = in->at == in->count;
        if (!end && !is_space(in->buffer[in->at])) {
            if (n == MAX_WORD_BYTES)
                break;
            word[n++] = (char)in->buffer[in->at++];
        } else if (n || end) {
            break;
        } else {
            in->at++;
        }
    }
    if (n == 0)
        return ends(in, err);
    word[n] = 0;
    if (n < MAX_WORD_BYTES && memchr(word, 0, n) == NULL && fmt_parse_f64(word, value))
        return BRICK_OK;
    return brick_fail_at(err, BRICK_ERR_FORMAT, in->offset - (in->count - in->at), BRICK_NO_BRICK,
                         "%s: before byte %llu is something that is not a number", in->io->path,
                         (unsigned long long)(in->offset - (in->count - in->at)));
}

static int read_value(struct input *in, enum ply_type type, double *value, struct brick_error *err)
{
    const size_t n = ply_type_bytes[type];
    unsigned char bytes[8];
    if (in->encoding == PLY_ASCII)
        return read_word(in, value, err);
    if (in->count - in->at < n) {
        int result = left(in) < n ? ends(in, err) : fill(in, err);
        if (result)
            return result;
    }
    for (size_t i = 0; i < n; i++) /* to this machine's order */
        bytes[(in->encoding == PLY_BIG) == (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__) ? i : n - 1 - i] =
            in->buffer[in->at + i];
    in->at += n;
#define READ_AS(TYPE)                                                                                        \
    {                                                                                                        \
        TYPE v;                                                                                              \
        memcpy(&v, bytes, sizeof v);                                                                         \
        *value = (double)v;                                                                                  \
    }                                                                                                        \
    break
    switch (type) {
    case PLY_I8:
        READ_AS(int8_t);
    case PLY_U8:
        READ_AS(uint8_t);
    case PLY_I16:
        READ_AS(int16_t);
    case PLY_U16:
        READ_AS(uint16_t);
    case PLY_I32:
        READ_AS(int32_t);
    case PLY_U32:
        READ_AS(uint32_t);
    case PLY_F32:
        READ_AS(float);
    default:
        READ_AS(double);
    }
#undef READ_AS
    return BRICK_OK;
}

/* A count or an index. */
static int read_whole(struct input *in, enum ply_type type, uint64_t *value, struct brick_error *err)
{
    double v;
    int result = read_value(in, type, &v, err);
    if (result)
        return result;
    if (!(v >= 0.0 && v <= UINT32_MAX) || v != floor(v))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: %g where a count or a vertex's number should be",
                          in->io->path, v);
    *value = (uint64_t)v;
    return BRICK_OK;
}

/* Before anything is read of it: can the rest of the file hold the element? */
static int check_rows(const struct input *in, const struct ply_element *element, struct brick_error *err)
{
    uint64_t row = 0;
    for (size_t p = 0; p < element->properties; p++) {
        const struct ply_property *property = &element->property[p];
        row += in->encoding == PLY_ASCII
                   ? 2 /* a digit and a space */
                   : ply_type_bytes[property->count == PLY_NONE ? property->type : property->count];
    }
    if (row && element->rows > (left(in) + 1) / row) /* the last line need not end */
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: %llu rows of %s do not fit the file", in->io->path,
                          (unsigned long long)element->rows, element->name);
    return BRICK_OK;
}

static int skip_list(struct input *in, const struct ply_property *property, struct brick_error *err)
{
    uint64_t count = 0;
    double value;
    int result = read_whole(in, property->count, &count, err);
    for (; !result && count > 0; count--)
        result = read_value(in, property->type, &value, err);
    return result;
}

static int read_property(struct input *in, const struct ply_property *property, double *value,
                         struct brick_error *err)
{
    return property->count == PLY_NONE ? read_value(in, property->type, value, err)
                                       : skip_list(in, property, err);
}

/* The scalar property of that name, or the element's number of properties. */
static size_t find(const struct ply_element *element, const char *name)
{
    size_t p = 0;
    while (p < element->properties &&
           (element->property[p].count != PLY_NONE || strcmp(element->property[p].name, name)))
        p++;
    return p;
}

static bool find_three(const struct ply_element *element, const char *const names[3], size_t at[3])
{
    for (int i = 0; i < 3; i++)
        at[i] = find(element, names[i]);
    return at[0] < element->properties && at[1] < element->properties && at[2] < element->properties;
}

static int read_vertices(struct input *in, const struct ply_element *element, struct brick_mesh *mesh,
                         struct brick_error *err)
{
    size_t position[3], normal[3], colour[3];
    double row[PLY_MAX_PROPERTIES], mm[3], n[3], rgb[3];
    struct brick_error inner;
    bool has_normal = find_three(element, (const char *const[]){"nx", "ny", "nz"}, normal);
    bool has_colour = find_three(element, (const char *const[]){"red", "green", "blue"}, colour);
    int result = BRICK_OK;
    if (!find_three(element, (const char *const[]){"x", "y", "z"}, position))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: its vertices have no x, y and z", in->io->path);
    for (uint64_t v = 0; v < element->rows && !result; v++) {
        for (size_t p = 0; p < element->properties && !result; p++)
            result = read_property(in, &element->property[p], &row[p], err);
        if (result)
            break;
        for (int i = 0; i < 3; i++) {
            mm[i] = row[position[i]];
            if (has_normal)
                n[i] = row[normal[i]];
            if (has_colour) {
                enum ply_type type = element->property[colour[i]].type;
                double full = type == PLY_F32 || type == PLY_F64 ? 1.0
                              : ply_type_bytes[type] == 1        ? 255.0
                                                                 : 65535.0;
                rgb[i] = colour_decode_srgb(fmin(fmax(row[colour[i]] / full, 0.0), 1.0));
            }
        }
        result = brick_mesh_add_vertex(mesh, mm, has_normal ? n : NULL, has_colour ? rgb : NULL, &inner);
        result = fmt_mesh_place(in->io, result, &inner, err);
    }
    return result;
}

static int read_polygon(struct input *in, const struct ply_property *property, struct brick_mesh *mesh,
                        struct brick_error *err)
{
    uint64_t corners[BRICK_MESH_MAX_CORNERS], count = 0;
    struct brick_error inner;
    int result = read_whole(in, property->count, &count, err);
    for (uint64_t k = 0; !result && k < count && k < BRICK_MESH_MAX_CORNERS; k++)
        result = read_whole(in, property->type, &corners[k], err);
    if (result)
        return result;
    result = brick_mesh_add_polygon(mesh, corners, count, &inner);
    return fmt_mesh_place(in->io, result, &inner, err);
}

static int read_faces(struct input *in, const struct ply_element *element, struct brick_mesh *mesh,
                      struct brick_error *err)
{
    size_t list = 0;
    double value;
    int result = BRICK_OK;
    while (list < element->properties && (element->property[list].count == PLY_NONE ||
                                          (strcmp(element->property[list].name, "vertex_indices") &&
                                           strcmp(element->property[list].name, "vertex_index"))))
        list++;
    if (list == element->properties)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: its faces have no list vertex_indices", in->io->path);
    for (uint64_t f = 0; f < element->rows && !result; f++)
        for (size_t p = 0; p < element->properties && !result; p++)
            result = p == list ? read_polygon(in, &element->property[p], mesh, err)
                               : read_property(in, &element->property[p], &value, err);
    return result;
}

static int skip_rows(struct input *in, const struct ply_element *element, struct brick_error *err)
{
    double value;
    int result = BRICK_OK;
    for (uint64_t r = 0; r < element->rows && !result; r++)
        for (size_t p = 0; p < element->properties && !result; p++)
            result = read_property(in, &element->property[p], &value, err);
    return result;
}

/* What comes after the faces is not looked at. */
static int read_elements(struct input *in, const struct ply_header *header, struct brick_mesh *mesh,
                         struct brick_error *err)
{
    for (size_t e = 0; e < header->elements; e++) {
        const struct ply_element *element = &header->element[e];
        int result = check_rows(in, element, err);
        if (result)
            return result;
        if (!strcmp(element->name, "face"))
            return read_faces(in, element, mesh, err);
        result = strcmp(element->name, "vertex") ? skip_rows(in, element, err)
                                                 : read_vertices(in, element, mesh, err);
        if (result)
            return result;
    }
    return BRICK_OK;
}

int fmt_mesh_ply_read(struct brick_mesh *mesh, const struct brick_io *io, struct brick_error *err)
{
    struct ply_header *header = malloc(sizeof *header);
    struct input *in = calloc(1, sizeof *in);
    int result = header && in ? ply_header_read(header, io, err)
                              : brick_fail(err, BRICK_ERR_MEMORY, "%s: no memory to read it", io->path);
    if (!result) {
        in->io = io;
        in->encoding = header->encoding;
        in->offset = header->body;
        result = brick_io_size(io, &in->bytes, err);
    }
    if (!result)
        result = read_elements(in, header, mesh, err);
    free(in);
    free(header);
    return result;
}
