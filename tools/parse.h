/* Parsers of option values. Strict: the whole text must be the value, nothing before, between or after.
 * They return NULL and fill target, or say in a few words what is wrong. */
#ifndef TOOLS_PARSE_H
#define TOOLS_PARSE_H

#include <stddef.h>
#include <stdint.h>

struct tool_limits {
    double min, max;            /* inclusive; both 0: none */
    const char *const *choices; /* of tool_parse_choice; NULL at the end */
};

typedef const char *tool_parse(const char *text, void *target, const struct tool_limits *limits);

#define TOOL_LIST_MAX 16
struct tool_list {
    const char *item[TOOL_LIST_MAX];
    size_t count;
};

#define TOOL_REALS_MAX 16
struct tool_reals {
    double value[TOOL_REALS_MAX];
    uint32_t count;
};

tool_parse tool_parse_text;     /* const char * */
tool_parse tool_parse_list;     /* struct tool_list: every use adds an item */
tool_parse tool_parse_choice;   /* int: the index in limits->choices */
tool_parse tool_parse_u32;      /* uint32_t, limits */
tool_parse tool_parse_u64;      /* uint64_t */
tool_parse tool_parse_bytes;    /* uint64_t: digits and K, M, G or T, powers of 1024 */
tool_parse tool_parse_real;     /* double, finite, limits */
tool_parse tool_parse_positive; /* double, finite, above 0 */
tool_parse tool_parse_reals;    /* struct tool_reals: "A,B,...", 1 to TOOL_REALS_MAX, limits for each */
tool_parse tool_parse_pair;     /* double[2]: "A,B" */
tool_parse tool_parse_triple;   /* double[3]: "X,Y,Z" */
tool_parse tool_parse_spacing;  /* double[3], each above 0 */
tool_parse tool_parse_plane;    /* double[4]: "A,B,C,D", not all of A, B, C zero */
tool_parse tool_parse_box;      /* double[3][2]: "X0,X1,Y0,Y1,Z0,Z1", each X0 < X1 */
tool_parse tool_parse_affine;   /* double[12] */
tool_parse tool_parse_dims;     /* uint64_t[3]: "NXxNYxNZ", each at least 1 */
tool_parse tool_parse_picture;  /* uint32_t[2]: "WxH" */
tool_parse tool_parse_region;   /* uint64_t[3][2]: "x0:x1,y0:y1,z0:z1", each x0 < x1 */
tool_parse tool_parse_axes;     /* char[4]: one letter from each of LR, PA, SI */
tool_parse tool_parse_type;     /* enum brick_type */
tool_parse tool_parse_codec;    /* enum brick_codec */

#endif
