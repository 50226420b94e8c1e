/* Why: what a user types becomes a number here, or a usage error; nothing is guessed. Every parser consumes
 * its whole text, and a target is written only when the value is good. */
#include "parse.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <brick/codec.h>
#include <brick/grid.h>
#include <brick/image.h>
#include <brick/type.h>

/* Digits at *at; moves *at past them. False for no digits or more than 64 bits. */
static bool scan_u64(const char **at, uint64_t *value)
{
    const char *p = *at;
    uint64_t v = 0;
    if (!isdigit((unsigned char)*p))
        return false;
    for (; isdigit((unsigned char)*p); p++)
        if (__builtin_mul_overflow(v, UINT64_C(10), &v) ||
            __builtin_add_overflow(v, (uint64_t)(*p - '0'), &v))
            return false;
    *at = p;
    *value = v;
    return true;
}

static bool scan_real(const char **at, double *value)
{
    char *end;
    if (!**at || isspace((unsigned char)**at))
        return false;
    errno = 0;
    double v = strtod(*at, &end);
    if (end == *at || !isfinite(v))
        return false;
    *at = end;
    *value = v;
    return true;
}

static bool scan_char(const char **at, char c)
{
    if (**at != c)
        return false;
    (*at)++;
    return true;
}

/* n reals with commas between, and the text's end after them. */
static bool scan_reals(const char *text, double *values, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if ((i && !scan_char(&text, ',')) || !scan_real(&text, &values[i]))
            return false;
    return !*text;
}

static bool outside(double value, const struct tool_limits *limits)
{
    return (limits->min != 0 || limits->max != 0) && !(value >= limits->min && value <= limits->max);
}

const char *tool_parse_text(const char *text, void *target, const struct tool_limits *limits)
{
    (void)limits;
    if (!*text)
        return "is empty";
    *(const char **)target = text;
    return NULL;
}

const char *tool_parse_list(const char *text, void *target, const struct tool_limits *limits)
{
    struct tool_list *list = target;
    (void)limits;
    if (!*text)
        return "is empty";
    if (list->count == TOOL_LIST_MAX)
        return "is one too many";
    list->item[list->count++] = text;
    return NULL;
}

const char *tool_parse_choice(const char *text, void *target, const struct tool_limits *limits)
{
    for (int i = 0; limits->choices[i]; i++)
        if (!strcmp(text, limits->choices[i])) {
            *(int *)target = i;
            return NULL;
        }
    return "is none of them";
}

const char *tool_parse_u32(const char *text, void *target, const struct tool_limits *limits)
{
    uint64_t v;
    if (!scan_u64(&text, &v) || *text)
        return "is no whole number";
    if (v > UINT32_MAX || outside((double)v, limits))
        return "is out of range";
    *(uint32_t *)target = (uint32_t)v;
    return NULL;
}

const char *tool_parse_u64(const char *text, void *target, const struct tool_limits *limits)
{
    uint64_t v;
    (void)limits;
    if (!scan_u64(&text, &v) || *text)
        return "is no whole number below 2^64";
    *(uint64_t *)target = v;
    return NULL;
}

const char *tool_parse_bytes(const char *text, void *target, const struct tool_limits *limits)
{
    static const char units[] = "KMGT";
    uint64_t v;
    (void)limits;
    if (!scan_u64(&text, &v))
        return "is no size";
    const char *unit = *text ? strchr(units, *text) : NULL;
    if (unit) {
        text++;
        if (__builtin_mul_overflow(v, UINT64_C(1) << (10 * (unit - units + 1)), &v))
            return "is too large";
    }
    if (*text)
        return "is no size (digits and K, M, G or T)";
    *(uint64_t *)target = v;
    return NULL;
}

const char *tool_parse_real(const char *text, void *target, const struct tool_limits *limits)
{
    double v;
    if (!scan_reals(text, &v, 1))
        return "is no number";
    if (outside(v, limits))
        return "is out of range";
    *(double *)target = v;
    return NULL;
}

const char *tool_parse_positive(const char *text, void *target, const struct tool_limits *limits)
{
    double v;
    (void)limits;
    if (!scan_reals(text, &v, 1))
        return "is no number";
    if (!(v > 0))
        return "is not above 0";
    *(double *)target = v;
    return NULL;
}

const char *tool_parse_reals(const char *text, void *target, const struct tool_limits *limits)
{
    struct tool_reals v = {.count = 0};
    do {
        if (v.count == TOOL_REALS_MAX)
            return "has more than 16 numbers";
        if (!scan_real(&text, &v.value[v.count]))
            return "is not one number or several with commas between";
        if (outside(v.value[v.count++], limits))
            return "is out of range";
    } while (scan_char(&text, ','));
    if (*text)
        return "is not one number or several with commas between";
    memcpy(target, &v, sizeof v);
    return NULL;
}

const char *tool_parse_pair(const char *text, void *target, const struct tool_limits *limits)
{
    double v[2];
    (void)limits;
    if (!scan_reals(text, v, 2))
        return "is not two numbers with a comma between";
    memcpy(target, v, sizeof v);
    return NULL;
}

const char *tool_parse_triple(const char *text, void *target, const struct tool_limits *limits)
{
    double v[3];
    if (!scan_reals(text, v, 3))
        return "is not three numbers with commas between";
    if (outside(v[0], limits) || outside(v[1], limits) || outside(v[2], limits))
        return "is out of range";
    memcpy(target, v, sizeof v);
    return NULL;
}

const char *tool_parse_spacing(const char *text, void *target, const struct tool_limits *limits)
{
    double v[3];
    (void)limits;
    if (!scan_reals(text, v, 3))
        return "is not three numbers with commas between";
    if (!(v[0] > 0 && v[1] > 0 && v[2] > 0))
        return "is not above 0 on every axis";
    memcpy(target, v, sizeof v);
    return NULL;
}

const char *tool_parse_plane(const char *text, void *target, const struct tool_limits *limits)
{
    double v[4];
    (void)limits;
    if (!scan_reals(text, v, 4))
        return "is not four numbers with commas between";
    if (v[0] == 0 && v[1] == 0 && v[2] == 0)
        return "has a normal of zero";
    memcpy(target, v, sizeof v);
    return NULL;
}

const char *tool_parse_box(const char *text, void *target, const struct tool_limits *limits)
{
    double v[6];
    (void)limits;
    if (!scan_reals(text, v, 6))
        return "is not six numbers with commas between";
    if (!(v[0] < v[1] && v[2] < v[3] && v[4] < v[5]))
        return "has an end that is not above its start";
    memcpy(target, v, sizeof v);
    return NULL;
}

const char *tool_parse_affine(const char *text, void *target, const struct tool_limits *limits)
{
    double v[12];
    (void)limits;
    if (!scan_reals(text, v, 12))
        return "is not twelve numbers with commas between";
    memcpy(target, v, sizeof v);
    return NULL;
}

const char *tool_parse_dims(const char *text, void *target, const struct tool_limits *limits)
{
    uint64_t v[3];
    (void)limits;
    for (int i = 0; i < 3; i++)
        if ((i && !scan_char(&text, 'x')) || !scan_u64(&text, &v[i]))
            return "is not a size such as 256x256x108";
    if (*text)
        return "is not a size such as 256x256x108";
    for (int i = 0; i < 3; i++) {
        if (!v[i])
            return "has an axis of 0 voxels";
        if (v[i] > BRICK_MAX_DIM)
            return "has an axis of more than 2^40 voxels";
    }
    memcpy(target, v, sizeof v);
    return NULL;
}

const char *tool_parse_picture(const char *text, void *target, const struct tool_limits *limits)
{
    uint64_t v[2];
    (void)limits;
    if (!scan_u64(&text, &v[0]) || !scan_char(&text, 'x') || !scan_u64(&text, &v[1]) || *text)
        return "is not a size such as 512x512";
    if (!v[0] || !v[1] || v[0] > BRICK_IMAGE_MAX_DIM || v[1] > BRICK_IMAGE_MAX_DIM)
        return "is out of range (1 to 32768 pixels a side)";
    uint32_t size[2] = {(uint32_t)v[0], (uint32_t)v[1]};
    memcpy(target, size, sizeof size);
    return NULL;
}

const char *tool_parse_region(const char *text, void *target, const struct tool_limits *limits)
{
    uint64_t v[3][2];
    (void)limits;
    for (int i = 0; i < 3; i++)
        if ((i && !scan_char(&text, ',')) || !scan_u64(&text, &v[i][0]) || !scan_char(&text, ':') ||
            !scan_u64(&text, &v[i][1]))
            return "is not a region such as 0:64,0:64,10:20";
    if (*text)
        return "is not a region such as 0:64,0:64,10:20";
    for (int i = 0; i < 3; i++)
        if (v[i][0] >= v[i][1])
            return "is empty (the end of each axis is not included)";
    memcpy(target, v, sizeof v);
    return NULL;
}

const char *tool_parse_axes(const char *text, void *target, const struct tool_limits *limits)
{
    static const double one[3] = {1, 1, 1}, zero[3] = {0, 0, 0};
    double affine[3][4];
    (void)limits;
    if (strlen(text) != 3 || brick_affine_from_axes(text, one, zero, affine, NULL))
        return "is not a code such as LPS, with one letter from each of LR, PA and SI";
    memcpy(target, text, 4);
    return NULL;
}

const char *tool_parse_type(const char *text, void *target, const struct tool_limits *limits)
{
    enum brick_type type = brick_type_from_name(text);
    (void)limits;
    if (type == BRICK_TYPE_COUNT)
        return "is none of u8 i8 u16 i16 u32 i32 f32 f64";
    *(enum brick_type *)target = type;
    return NULL;
}

const char *tool_parse_codec(const char *text, void *target, const struct tool_limits *limits)
{
    enum brick_codec codec = brick_codec_from_name(text);
    (void)limits;
    if (codec == BRICK_CODEC_COUNT)
        return "is none of none, lz4, lz4-bitshuffle, zstd, zstd-delta and zfp";
    *(enum brick_codec *)target = codec;
    return NULL;
}
