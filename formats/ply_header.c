/* Why: a PLY header is a small language, and everything that the body can do wrong follows from it. */
#include "ply_header.h"

#include <string.h>

#include "text.h"

const uint8_t ply_type_bytes[PLY_NONE] = {1, 1, 2, 2, 4, 4, 4, 8};

static enum ply_type type_of(const char *name)
{
    static const char *const names[PLY_NONE][2] = {
        [PLY_I8] = {"char", "int8"},      [PLY_U8] = {"uchar", "uint8"},     [PLY_I16] = {"short", "int16"},
        [PLY_U16] = {"ushort", "uint16"}, [PLY_I32] = {"int", "int32"},      [PLY_U32] = {"uint", "uint32"},
        [PLY_F32] = {"float", "float32"}, [PLY_F64] = {"double", "float64"},
    };
    for (int t = 0; name && t < PLY_NONE; t++)
        if (!strcmp(name, names[t][0]) || !strcmp(name, names[t][1]))
            return (enum ply_type)t;
    return PLY_NONE;
}

static bool take_name(char dst[PLY_MAX_NAME], const char *word)
{
    size_t n = word ? strlen(word) : 0;
    if (n == 0 || n >= PLY_MAX_NAME)
        return false;
    memcpy(dst, word, n + 1);
    return true;
}

static bool take_format(struct ply_header *header, char *at)
{
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    const char *name = fmt_text_word(&at), *version = name ? fmt_text_word(&at) : NULL;
    for (int e = 0; version && !strcmp(version, "1.0") && e < 3; e++)
        if (!strcmp(name, names[e])) {
            header->encoding = (enum ply_encoding)e;
            return true;
        }
    return false;
}

static bool take_element(struct ply_header *header, char *at)
{
    if (header->elements == PLY_MAX_ELEMENTS)
        return false;
    struct ply_element *element = &header->element[header->elements++];
    *element = (struct ply_element){0};
    const char *name = fmt_text_word(&at), *rows = name ? fmt_text_word(&at) : NULL;
    return take_name(element->name, name) && rows && fmt_parse_u64(rows, &element->rows) &&
           !fmt_text_word(&at);
}

static bool take_property(struct ply_header *header, char *at)
{
    struct ply_element *element = header->elements ? &header->element[header->elements - 1] : NULL;
    if (!element || element->properties == PLY_MAX_PROPERTIES)
        return false;
    struct ply_property *property = &element->property[element->properties++];
    const char *word = fmt_text_word(&at);
    property->count = PLY_NONE;
    if (word && !strcmp(word, "list")) {
        property->count = type_of(fmt_text_word(&at));
        if (property->count >= PLY_F32)
            return false;
        word = fmt_text_word(&at);
    }
    property->type = type_of(word);
    return property->type != PLY_NONE && take_name(property->name, fmt_text_word(&at)) && !fmt_text_word(&at);
}

/* 1 at the end, 0 to go on, -1 when the line makes no sense. */
static int take_line(struct ply_header *header, char *line, bool *has_format)
{
    char *at = line;
    const char *word = fmt_text_word(&at);
    if (!word || !strcmp(word, "comment") || !strcmp(word, "obj_info"))
        return 0;
    if (!strcmp(word, "end_header"))
        return *has_format ? 1 : -1;
    if (!strcmp(word, "format"))
        return (*has_format = take_format(header, at)) ? 0 : -1;
    if (!strcmp(word, "element"))
        return take_element(header, at) ? 0 : -1;
    if (!strcmp(word, "property"))
        return take_property(header, at) ? 0 : -1;
    return -1;
}

static int check_elements(const struct ply_header *header, const char *path, struct brick_error *err)
{
    for (size_t e = 0; e < header->elements; e++)
        if (header->element[e].rows && !header->element[e].properties)
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: element %s has rows of nothing", path,
                              header->element[e].name);
    return BRICK_OK;
}

int ply_header_read(struct ply_header *header, const struct brick_io *io, struct brick_error *err)
{
    struct fmt_text text;
    char *line;
    bool has_format = false;
    *header = (struct ply_header){0};
    int result = fmt_text_load(&text, io, err);
    if (result)
        return result;
    int state = fmt_text_line(&text, &line, err);
    if (state == 1 && strcmp(fmt_text_trim(line), "ply"))
        state = brick_fail(err, BRICK_ERR_FORMAT, "%s: not a PLY file", io->path);
    while (state == 1) {
        int taken;
        if ((state = fmt_text_line(&text, &line, err)) != 1)
            break;
        if ((taken = take_line(header, line, &has_format)) < 0)
            state = brick_fail(err, BRICK_ERR_FORMAT, "%s: line %u of the header makes no sense", io->path,
                               text.line);
        if (taken > 0)
            break;
    }
    header->body = text.at;
    if (state == 0)
        state = brick_fail(err, BRICK_ERR_FORMAT, "%s: the header does not end", io->path);
    fmt_text_finish(&text);
    return state < 0 ? state : check_elements(header, io->path, err);
}
