/* Why: a NRRD array has up to 16 axes of any kind, a volume has three of space. Axes that are not of space
 * may only have size 1; directions and spacings of the others, in the file's space and units, become mm in
 * LPS. */
#include "nrrd_header.h"

#include <ctype.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>
#include <strings.h>

#include "geometry.h"
#include "text.h"

struct axis {
    bool spatial;
    const char *kind;    /* or NULL */
    double direction[3]; /* when the header has directions */
};

struct space {
    const char *name, *code;
    double sign[3]; /* of x, y, z against LPS */
};

/* The oriented spaces. Those without an orientation are taken as LPS. */
static const struct space spaces[] = {
    {"left-posterior-superior", "LPS", {1, 1, 1}},
    {"right-anterior-superior", "RAS", {-1, -1, 1}},
    {"left-anterior-superior", "LAS", {1, -1, 1}},
    {"scanner-xyz", "", {1, 1, 1}},
    {"3D-right-handed", "", {1, 1, 1}},
    {"3D-left-handed", "", {1, 1, 1}},
};

static int bad(const struct nrrd_header *header, const char *field, struct brick_error *err)
{
    return brick_fail(err, BRICK_ERR_FORMAT, "%s: cannot read the NRRD field '%s'", header->path, field);
}

/* "(a,b,c)" of n numbers, the rest zero. Moves *at behind it. */
static bool parse_vector(char **at, unsigned n, double v[3])
{
    char *p = *at;
    while (isspace((unsigned char)*p))
        p++;
    char *close = strchr(p, ')');
    if (*p++ != '(' || !close)
        return false;
    *close = 0;
    *at = close + 1;
    for (unsigned i = 0; i < 3; i++) {
        v[i] = 0.0;
        if (i >= n)
            continue;
        char *comma = strchr(p, ',');
        if ((comma != NULL) != (i + 1 < n))
            return false;
        if (comma)
            *comma = 0;
        if (!fmt_parse_f64(fmt_text_trim(p), &v[i]) || !isfinite(v[i]))
            return false;
        p = comma ? comma + 1 : p;
    }
    return true;
}

/* Millimetres in a unit; 1 for units that are no length, as for none at all. */
static double unit_mm(const char *unit)
{
    static const struct {
        const char *name;
        double mm;
    } units[] = {{"m", 1e3}, {"cm", 10.0}, {"um", 1e-3}, {"micron", 1e-3}, {"nm", 1e-6}, {"\xc2\xb5m", 1e-3}};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strcmp(unit, units[i].name) == 0)
            return units[i].mm;
    return 1.0;
}

/* n quoted strings, to mm each. */
static bool parse_units(char *text, unsigned n, double *mm)
{
    for (unsigned i = 0; i < n; i++) {
        char *open = strchr(text, '"'), *close = open ? strchr(open + 1, '"') : NULL;
        if (!close)
            return false;
        *close = 0;
        mm[i] = unit_mm(open + 1);
        text = close + 1;
    }
    return true;
}

static bool is_space_kind(const char *kind)
{
    return strcasecmp(kind, "domain") == 0 || strcasecmp(kind, "space") == 0 || strcmp(kind, "???") == 0 ||
           strcasecmp(kind, "none") == 0;
}

/* Number of the space's axes and their signs against LPS. */
static int parse_space(struct nrrd_header *header, unsigned *dimension, double sign[3],
                       struct brick_error *err)
{
    const char *name = header->value[NRRD_SPACE], *count = header->value[NRRD_SPACE_DIMENSION];
    *dimension = 3;
    sign[0] = sign[1] = sign[2] = 1.0;
    if (name) {
        for (size_t i = 0; i < sizeof spaces / sizeof *spaces; i++)
            if (strcasecmp(name, spaces[i].name) == 0 ||
                (*spaces[i].code && strcasecmp(name, spaces[i].code) == 0)) {
                memcpy(sign, spaces[i].sign, sizeof spaces[i].sign);
                return BRICK_OK;
            }
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "%s: NRRD space '%.80s' is not left-posterior-superior, right-anterior-superior, "
                          "left-anterior-superior, scanner-xyz or 3D-right-handed",
                          header->path, name);
    }
    uint64_t n;
    if (!count)
        return BRICK_OK;
    if (!fmt_parse_u64(count, &n) || n == 0)
        return bad(header, "space dimension", err);
    if (n > 3)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "%s: a space of %llu dimensions is more than a volume has", header->path,
                          (unsigned long long)n);
    *dimension = (unsigned)n;
    return BRICK_OK;
}

/* What each axis is: directions decide when given, kinds otherwise. */
static int classify(struct nrrd_header *header, unsigned dimension, struct axis *axes,
                    struct brick_error *err)
{
    char *kinds = header->value[NRRD_KINDS], *directions = header->value[NRRD_SPACE_DIRECTIONS];
    for (unsigned a = 0; a < header->axes; a++) {
        struct axis *axis = &axes[a];
        *axis = (struct axis){.spatial = true};
        if (kinds) {
            axis->kind = fmt_text_word(&kinds);
            if (!axis->kind)
                return bad(header, "kinds", err);
            axis->spatial = is_space_kind(axis->kind);
        }
        if (!directions)
            continue;
        directions += strspn(directions, " \t");
        axis->spatial = strncasecmp(directions, "none", 4) != 0;
        if (!axis->spatial)
            directions += 4;
        else if (!parse_vector(&directions, dimension, axis->direction))
            return bad(header, "space directions", err);
    }
    if (kinds && fmt_text_word(&kinds))
        return bad(header, "kinds", err);
    if (directions && fmt_text_word(&directions))
        return bad(header, "space directions", err);
    return BRICK_OK;
}

/* The axes of the volume, in order: *count of them, at most three. */
static int choose(const struct nrrd_header *header, const struct axis *axes, unsigned chosen[NRRD_MAX_AXES],
                  unsigned *count, struct brick_error *err)
{
    *count = 0;
    for (unsigned a = 0; a < header->axes; a++) {
        if (axes[a].spatial)
            chosen[(*count)++] = a;
        else if (header->sizes[a] != 1)
            return brick_fail(
                err, BRICK_ERR_UNSUPPORTED,
                "%s: NRRD axis %u (%.40s, %llu values) is not an axis of space: only one value a voxel "
                "can be read, split the components into files first",
                header->path, a, axes[a].kind ? axes[a].kind : "no direction",
                (unsigned long long)header->sizes[a]);
    }
    for (unsigned i = *count; i-- && *count > 3;)
        if (header->sizes[chosen[i]] == 1) {
            memmove(&chosen[i], &chosen[i + 1], (*count - i - 1) * sizeof *chosen);
            (*count)--;
        }
    if (*count > 3)
        return brick_fail(
            err, BRICK_ERR_UNSUPPORTED,
            "%s: %u NRRD axes are longer than 1: a volume has three (kinds or space directions tell axes "
            "of values apart)",
            header->path, *count);
    return BRICK_OK;
}

int nrrd_axes_place(struct nrrd_header *header, struct brick_geometry *geometry, struct brick_error *err)
{
    struct axis axes[NRRD_MAX_AXES];
    unsigned chosen[NRRD_MAX_AXES], count, dimension;
    double sign[3], origin[3] = {0}, spacing[NRRD_MAX_AXES], unit[NRRD_MAX_AXES], space_unit[3] = {1, 1, 1};
    double directions[3][3] = {{0}};
    int code = parse_space(header, &dimension, sign, err);
    if (!code)
        code = classify(header, dimension, axes, err);
    if (!code)
        code = choose(header, axes, chosen, &count, err);
    if (code)
        return code;

    for (unsigned a = 0; a < NRRD_MAX_AXES; a++)
        spacing[a] = unit[a] = 1.0;
    char *text = header->value[NRRD_SPACE_ORIGIN];
    if (text && !parse_vector(&text, dimension, origin))
        return bad(header, "space origin", err);
    text = header->value[NRRD_SPACE_UNITS];
    if (text && !parse_units(text, dimension, space_unit))
        return bad(header, "space units", err);
    text = header->value[NRRD_SPACINGS];
    if (text && !fmt_parse_f64s(text, spacing, header->axes))
        return bad(header, "spacings", err);
    text = header->value[NRRD_UNITS];
    if (text && !parse_units(text, header->axes, unit))
        return bad(header, "units", err);

    for (unsigned r = 0; r < 3; r++)
        origin[r] *= sign[r] * space_unit[r];
    for (unsigned c = 0; c < 3; c++)
        geometry->dims[c] = c < count ? header->sizes[chosen[c]] : 1;
    for (unsigned c = 0; c < count; c++)
        for (unsigned r = 0; r < 3; r++)
            directions[c][r] = header->value[NRRD_SPACE_DIRECTIONS]
                                   ? axes[chosen[c]].direction[r] * sign[r] * space_unit[r]
                               : r == c ? spacing[chosen[c]] * unit[chosen[c]] * sign[r]
                                        : 0.0;
    fmt_geometry_set_axes(geometry, directions, count, origin);
    return BRICK_OK;
}
