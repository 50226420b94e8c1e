/* What a PLY header says: elements, each a table of rows; each row has the element's properties, scalars and
 * lists, in order. Private to formats/. */
#ifndef FORMATS_PLY_HEADER_H
#define FORMATS_PLY_HEADER_H

#include <stddef.h>
#include <stdint.h>

#include <brick/error.h>
#include <brick/io.h>

enum ply_type { PLY_I8, PLY_U8, PLY_I16, PLY_U16, PLY_I32, PLY_U32, PLY_F32, PLY_F64, PLY_NONE };
extern const uint8_t ply_type_bytes[PLY_NONE];

enum ply_encoding { PLY_ASCII, PLY_LITTLE, PLY_BIG };

#define PLY_MAX_NAME       32
#define PLY_MAX_PROPERTIES 64
#define PLY_MAX_ELEMENTS   16

struct ply_property {
    char name[PLY_MAX_NAME];
    enum ply_type type;  /* of the value, or of a list's items */
    enum ply_type count; /* of a list's length; PLY_NONE: a scalar */
};

struct ply_element {
    char name[PLY_MAX_NAME];
    uint64_t rows;
    struct ply_property property[PLY_MAX_PROPERTIES];
    size_t properties; /* at least one where there are rows */
};

struct ply_header {
    enum ply_encoding encoding;
    struct ply_element element[PLY_MAX_ELEMENTS];
    size_t elements;
    uint64_t body; /* byte where the first row begins */
};

int ply_header_read(struct ply_header *header, const struct brick_io *io, struct brick_error *err);

#endif
