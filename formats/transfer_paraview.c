/* ParaView's colour maps: "RGBPoints" (x, r, g, b, ...) in sRGB, interpolated in "ColorSpace", and "Points"
 * (x, opacity, midpoint, sharpness, ...).
 *
 * The two curves are cut at the union of their control points and, between those, finely enough that straight
 * lines in linear RGB follow them; the limits from the left and the right of each cut give one control point,
 * or two for a jump. Opacity curves are VTK's vtkPiecewiseFunction. A map without Points is opaque
 * everywhere, as in ParaView. The file has no unit of length (ParaView keeps its ScalarOpacityUnitDistance
 * elsewhere): opacity is per voxel edge. Values are taken as physical, as they stand; ParaView rescales a map
 * to the data only when asked. Names, NaN colours and other keys that do not shape the curves are skipped. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "colour.h"
#include "transfer_formats.h"

enum {
    CUTS_IN_ALL = 512,      /* at least so many pieces over a whole colour map */
    CUTS_PER_HERMITE = 512, /* of a sharpened opacity segment */
    MAX_NODES = 4096
};

/* A control point of either curve: x and three numbers (r, g, b; or opacity, midpoint, sharpness). */
struct node {
    double x, v[3];
};

#define MAX_VALUE 1e300 /* so that differences stay finite */

struct curve {
    struct node *nodes;
    size_t count;
};

enum side { LEFT, RIGHT };

static int parse_curve(struct curve *curve, const char *path, const char *key, const cJSON *list,
                       struct brick_error *err)
{
    const cJSON *number;
    size_t count = 0;
    if (!cJSON_IsArray(list))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: \"%s\" is not a list", path, key);
    cJSON_ArrayForEach(number, list) count++;
    if (count == 0 || count % 4 != 0 || count / 4 > MAX_NODES)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: \"%s\" has %zu numbers; it takes 1 to %d times four",
                          path, key, count, MAX_NODES);
    curve->nodes = calloc(count / 4, sizeof *curve->nodes);
    if (!curve->nodes)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    size_t i = 0;
    cJSON_ArrayForEach(number, list)
    {
        struct node *node = &curve->nodes[i / 4];
        if (!cJSON_IsNumber(number) || !(fabs(number->valuedouble) <= MAX_VALUE))
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: \"%s\": point %zu: not a finite number", path, key,
                              i / 4);
        if (i % 4 == 0)
            node->x = number->valuedouble;
        else
            node->v[i % 4 - 1] = number->valuedouble;
        if (i % 4 != 0 && (number->valuedouble < 0 || number->valuedouble > 1))
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: \"%s\": point %zu: %g is outside [0, 1]", path, key,
                              i / 4, number->valuedouble);
        i++;
    }
    curve->count = count / 4;
    for (i = 1; i < curve->count; i++) {
        const struct node *node = &curve->nodes[i];
        if (node->x < node[-1].x)
            return brick_fail(err, BRICK_ERR_FORMAT,
                              "%s: \"%s\": point %zu: value %g is below the one before, %g", path, key, i,
                              node->x, node[-1].x);
        if (i > 1 && node->x == node[-2].x)
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: \"%s\": point %zu: a third point at value %g", path,
                              key, i, node->x);
    }
    return BRICK_OK;
}

static bool is_true(const cJSON *map, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(map, key);
    return cJSON_IsTrue(item) || (cJSON_IsNumber(item) && item->valuedouble != 0);
}

static int parse_space(enum colour_space *space, const char *path, const cJSON *map, struct brick_error *err)
{
    static const struct {
        const char *name;
        enum colour_space space;
    } spaces[] = {{"RGB", COLOUR_RGB},
                  {"HSV", COLOUR_HSV},
                  {"Lab", COLOUR_LAB},
                  {"CIELAB", COLOUR_LAB},
                  {"Diverging", COLOUR_DIVERGING},
                  {"Step", COLOUR_STEP}};
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(map, "ColorSpace");
    *space = COLOUR_RGB; /* VTK's when it is not said */
    if (!item)
        return BRICK_OK;
    for (size_t i = 0; cJSON_IsString(item) && i < sizeof spaces / sizeof *spaces; i++)
        if (strcasecmp(item->valuestring, spaces[i].name) == 0) {
            *space = spaces[i].space;
            if (*space == COLOUR_HSV && is_true(map, "HSVWrap"))
                *space = COLOUR_HSV_WRAP;
            return BRICK_OK;
        }
    return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                      "%s: ColorSpace %.32s is not known; there are RGB, HSV, Lab, Diverging and Step", path,
                      cJSON_IsString(item) ? item->valuestring : "(no text)");
}

/* The two nodes that x lies between, seen from one side, and where; the same node twice beyond the ends. */
static double locate(const struct curve *curve, double x, enum side side, const struct node **from,
                     const struct node **to)
{
    size_t i = 0; /* how many nodes lie below x, or at it when x is seen from the right */
    while (i < curve->count && (curve->nodes[i].x < x || (side == RIGHT && curve->nodes[i].x == x)))
        i++;
    *from = &curve->nodes[i > 0 ? i - 1 : 0];
    *to = &curve->nodes[i < curve->count ? i : curve->count - 1];
    return *from == *to ? 0 : (x - (*from)->x) / ((*to)->x - (*from)->x);
}

/* Linear RGB at x. */
static void colour_at(const struct curve *curve, enum colour_space space, double x, enum side side,
                      double rgb[3])
{
    const struct node *from, *to;
    const double t = locate(curve, x, side, &from, &to);
    if (from == to || (t <= 0 && space != COLOUR_STEP))
        memcpy(rgb, from->v, 3 * sizeof *rgb);
    else if (t >= 1)
        memcpy(rgb, to->v, 3 * sizeof *rgb);
    else
        colour_interpolate(space, from->v, to->v, t, rgb);
    for (int i = 0; i < 3; i++)
        rgb[i] = colour_decode_srgb(rgb[i]);
}

static bool is_step(const struct node *node)
{
    return node->v[2] > 0.99;
}

static bool is_hermite(const struct node *node)
{
    return node->v[2] >= 0.01 && !is_step(node);
}

/* Where a segment passes half-way: VTK keeps it off the ends. */
static double middle_of(const struct node *from, const struct node *to)
{
    return from->x + fmin(fmax(from->v[1], 0.00001), 0.99999) * (to->x - from->x);
}

/* vtkPiecewiseFunction: the segment's first node has its midpoint and sharpness. The midpoint is where half
 * the way is done; sharpness bends the line to a Hermite curve, above 0.99 to a step. */
static double opacity_at(const struct curve *curve, double x, enum side side)
{
    const struct node *from, *to;
    if (curve->count == 0)
        return 1;
    locate(curve, x, side, &from, &to);
    if (from == to || (side == RIGHT && x == from->x && !is_step(from)))
        return from->v[0];
    if (side == LEFT && x == to->x && !is_step(from))
        return to->v[0];
    const double middle = middle_of(from, to), sharpness = from->v[2];
    const double first = from->v[0], second = to->v[0];
    if (is_step(from))
        return x > middle || (x == middle && side == RIGHT) ? second : first;
    double t =
        x < middle ? 0.5 * (x - from->x) / (middle - from->x) : 0.5 + 0.5 * (x - middle) / (to->x - middle);
    if (is_hermite(from)) {
        const double power = 1 + 10 * sharpness;
        t = t < 0.5 ? 0.5 * pow(2 * t, power) : 1 - 0.5 * pow(2 - 2 * t, power);
        /* Hermite basis with the slope (1 - sharpness)(second - first) at both ends, as a share of the way.
         */
        t = t * t * (3 - 2 * t) + (1 - sharpness) * t * (1 - t) * (1 - 2 * t);
    }
    return first + (second - first) * fmin(fmax(t, 0), 1);
}

struct cuts {
    double *x;
    size_t count, room;
};

static void cut_evenly(struct cuts *cuts, double from, double to, size_t pieces)
{
    for (size_t i = 1; i < pieces && cuts->count < cuts->room; i++)
        cuts->x[cuts->count++] = from + (to - from) * ((double)i / (double)pieces);
}

static size_t colour_pieces(const struct curve *colour, enum colour_space space)
{
    if (space == COLOUR_STEP || colour->count < 2)
        return 1;
    const size_t pieces = (CUTS_IN_ALL + colour->count - 2) / (colour->count - 1);
    return (pieces + 1) / 2 * 2; /* even: Diverging bends half-way */
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Every x at which the result needs a control point, ascending, each once. */
static int make_cuts(struct cuts *cuts, const char *path, const struct curve *colour, enum colour_space space,
                     const struct curve *opacity, struct brick_error *err)
{
    const size_t pieces = colour_pieces(colour, space);
    size_t hermite = 0;
    for (size_t i = 0; i < opacity->count; i++)
        hermite += is_hermite(&opacity->nodes[i]);
    cuts->room = colour->count * pieces + 2 * opacity->count + hermite * CUTS_PER_HERMITE;
    if (cuts->room > BRICK_TRANSFER_MAX_POINTS)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: needs %zu control points; %d are possible", path,
                          cuts->room, BRICK_TRANSFER_MAX_POINTS);
    cuts->x = malloc(cuts->room * sizeof *cuts->x);
    if (!cuts->x)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    for (size_t i = 0; i < colour->count; i++) {
        cuts->x[cuts->count++] = colour->nodes[i].x;
        if (i + 1 < colour->count)
            cut_evenly(cuts, colour->nodes[i].x, colour->nodes[i + 1].x, pieces);
    }
    for (size_t i = 0; i < opacity->count; i++) {
        const struct node *node = &opacity->nodes[i];
        cuts->x[cuts->count++] = node->x;
        if (i + 1 == opacity->count || (node->v[1] == 0.5 && node->v[2] < 0.01))
            continue;
        const double middle = middle_of(node, node + 1);
        cuts->x[cuts->count++] = middle;
        if (is_hermite(node)) {
            cut_evenly(cuts, node->x, middle, CUTS_PER_HERMITE / 2);
            cut_evenly(cuts, middle, node[1].x, CUTS_PER_HERMITE / 2);
        }
    }
    qsort(cuts->x, cuts->count, sizeof *cuts->x, compare_doubles);
    size_t kept = 1;
    for (size_t i = 1; i < cuts->count; i++)
        if (cuts->x[i] != cuts->x[kept - 1])
            cuts->x[kept++] = cuts->x[i];
    cuts->count = kept;
    return BRICK_OK;
}

static struct brick_transfer_point point_at(const struct curve *colour, enum colour_space space,
                                            const struct curve *opacity, double x, enum side side)
{
    double rgb[3];
    colour_at(colour, space, x, side, rgb);
    return (struct brick_transfer_point){x, rgb[0], rgb[1], rgb[2], opacity_at(opacity, x, side)};
}

int transfer_paraview_parse(struct brick_transfer_spec *spec, const char *path, const cJSON *map,
                            struct brick_error *err)
{
    struct curve colour = {0}, opacity = {0};
    struct cuts cuts = {0};
    enum colour_space space;
    const cJSON *rgb_points = cJSON_GetObjectItemCaseSensitive(map, "RGBPoints");
    const cJSON *points = cJSON_GetObjectItemCaseSensitive(map, "Points");
    int result;
    if (!rgb_points)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "%s: a colour map without \"RGBPoints\" (of categories?)", path);
    if (is_true(map, "UseLogScale"))
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: colour maps on a log scale are not read", path);
    if ((result = parse_space(&space, path, map, err)) ||
        (result = parse_curve(&colour, path, "RGBPoints", rgb_points, err)) ||
        (points && !cJSON_IsNull(points) && (result = parse_curve(&opacity, path, "Points", points, err))) ||
        (result = make_cuts(&cuts, path, &colour, space, &opacity, err)))
        goto fail;
    spec->points = calloc(2 * cuts.count, sizeof *spec->points);
    if (!spec->points) {
        result = brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
        goto fail;
    }
    for (size_t i = 0; i < cuts.count; i++) {
        const struct brick_transfer_point left = point_at(&colour, space, &opacity, cuts.x[i], LEFT);
        const struct brick_transfer_point right = point_at(&colour, space, &opacity, cuts.x[i], RIGHT);
        if (left.r != right.r || left.g != right.g || left.b != right.b || left.a != right.a)
            spec->points[spec->count++] = left;
        spec->points[spec->count++] = right;
    }
    if (spec->count > BRICK_TRANSFER_MAX_POINTS)
        result = brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: needs %zu control points; %d are possible", path,
                            spec->count, BRICK_TRANSFER_MAX_POINTS);
    spec->unit = 1;
    spec->unit_of = BRICK_UNIT_VOXEL;
fail:
    free(cuts.x);
    free(opacity.nodes);
    free(colour.nodes);
    return result;
}
