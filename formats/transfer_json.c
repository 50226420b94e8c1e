/* Transfer functions from JSON files. Two forms are told apart by their shape: this project's (an object with
 * "points") and ParaView's colour maps (a list, or an object with "RGBPoints").
 *
 * This project's form is strict, because a misspelt key would quietly change a picture: an unknown key, a key
 * given twice and a value of the wrong kind are errors. What is read here would pass brick_transfer_create;
 * it is checked here too so that the message names the file. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/io.h>

#include "transfer_formats.h"

#define MAX_FILE_BYTES (UINT64_C(16) << 20)

/* The whole file, with a zero byte at the end. */
static int read_text(char **text, size_t *bytes, const char *path, struct brick_error *err)
{
    struct brick_io io = BRICK_IO_CLOSED;
    uint64_t size;
    int result = brick_io_open(&io, path, err);
    if (result)
        return result;
    if ((result = brick_io_size(&io, &size, err)))
        goto fail;
    if (size > MAX_FILE_BYTES) {
        result =
            brick_fail(err, BRICK_ERR_FORMAT, "%s: %llu bytes; transfer functions of up to 16 MiB are read",
                       path, (unsigned long long)size);
        goto fail;
    }
    *text = malloc((size_t)size + 1);
    if (!*text) {
        result = brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
        goto fail;
    }
    (*text)[size] = 0;
    *bytes = (size_t)size;
    if ((result = brick_io_read_at(&io, 0, *text, (size_t)size, err))) {
        free(*text);
        *text = NULL;
    }
fail:
    brick_io_close(&io);
    return result;
}

static int parse_unit(struct brick_transfer_spec *spec, const char *path, const cJSON *unit,
                      struct brick_error *err)
{
    if (cJSON_IsString(unit) && strcmp(unit->valuestring, "voxel") == 0) {
        spec->unit = 1;
        spec->unit_of = BRICK_UNIT_VOXEL;
        return BRICK_OK;
    }
    if (!cJSON_IsNumber(unit) || !isfinite(unit->valuedouble) || !(unit->valuedouble > 0))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: \"unit\" must be a positive number of mm, or \"voxel\"",
                          path);
    spec->unit = unit->valuedouble;
    spec->unit_of = BRICK_UNIT_MM;
    return BRICK_OK;
}

static int parse_values(struct brick_transfer_spec *spec, const char *path, const cJSON *values,
                        struct brick_error *err)
{
    if (!cJSON_IsString(values) ||
        (strcmp(values->valuestring, "physical") != 0 && strcmp(values->valuestring, "range") != 0))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: \"values\" must be \"physical\" or \"range\"", path);
    spec->range_values = strcmp(values->valuestring, "range") == 0;
    return BRICK_OK;
}

static int parse_point(struct brick_transfer_point *point, const char *path, size_t index, const cJSON *item,
                       struct brick_error *err)
{
    double numbers[5];
    int count = 0;
    const cJSON *number;
    if (!cJSON_IsArray(item))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: point %zu is not a list [value, r, g, b, A]", path,
                          index);
    cJSON_ArrayForEach(number, item)
    {
        if (!cJSON_IsNumber(number) || !isfinite(number->valuedouble))
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: point %zu: its entry %d is not a finite number",
                              path, index, count);
        if (count < 5)
            numbers[count] = number->valuedouble;
        count++;
    }
    if (count != 5)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: point %zu has %d numbers, not 5: [value, r, g, b, A]",
                          path, index, count);
    for (int i = 1; i < 5; i++)
        if (numbers[i] < 0 || numbers[i] > 1)
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: point %zu: %c is %g, outside [0, 1]", path, index,
                              "-rgbA"[i], numbers[i]);
    *point = (struct brick_transfer_point){numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]};
    return BRICK_OK;
}

static int parse_points(struct brick_transfer_spec *spec, const char *path, const cJSON *points,
                        struct brick_error *err)
{
    size_t count = 0;
    const cJSON *item;
    if (!cJSON_IsArray(points) || !points->child)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: \"points\" must be a list of [value, r, g, b, A]",
                          path);
    cJSON_ArrayForEach(item, points) count++;
    if (count > BRICK_TRANSFER_MAX_POINTS)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: %zu points; up to %d are read", path, count,
                          BRICK_TRANSFER_MAX_POINTS);
    spec->points = calloc(count, sizeof *spec->points);
    if (!spec->points)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
    cJSON_ArrayForEach(item, points)
    {
        struct brick_transfer_point *point = &spec->points[spec->count];
        const int result = parse_point(point, path, spec->count, item, err);
        if (result)
            return result;
        if (spec->count > 0 && point->value < point[-1].value)
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: point %zu: value %g is below the one before, %g",
                              path, spec->count, point->value, point[-1].value);
        if (spec->count > 1 && point->value == point[-2].value)
            return brick_fail(err, BRICK_ERR_FORMAT,
                              "%s: point %zu: a third point at value %g; two make a jump", path, spec->count,
                              point->value);
        spec->count++;
    }
    return BRICK_OK;
}

static int parse_own(struct brick_transfer_spec *spec, const char *path, const cJSON *object,
                     struct brick_error *err)
{
    static const struct {
        const char *key;
        int (*parse)(struct brick_transfer_spec *, const char *, const cJSON *, struct brick_error *);
    } keys[] = {{"unit", parse_unit}, {"values", parse_values}, {"points", parse_points}};
    enum { KEYS = sizeof keys / sizeof *keys };
    bool given[KEYS] = {false};
    const cJSON *item;
    spec->unit = 1;
    cJSON_ArrayForEach(item, object)
    {
        size_t k = 0;
        while (k < KEYS && strcmp(item->string, keys[k].key) != 0)
            k++;
        if (k == KEYS)
            return brick_fail(err, BRICK_ERR_FORMAT,
                              "%s: unknown key \"%.64s\"; there are \"unit\", \"values\" and \"points\"",
                              path, item->string);
        if (given[k])
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: key \"%s\" is there twice", path, keys[k].key);
        given[k] = true;
        const int result = keys[k].parse(spec, path, item, err);
        if (result)
            return result;
    }
    if (!spec->points)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: has neither \"points\" nor ParaView's \"RGBPoints\"",
                          path);
    return BRICK_OK;
}

static int parse_root(struct brick_transfer_spec *spec, const char *path, const cJSON *root,
                      struct brick_error *err)
{
    if (cJSON_IsArray(root)) {
        const int count = cJSON_GetArraySize(root);
        if (count != 1 || !cJSON_IsObject(root->child))
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: a list of %d; a file with one colour map is read",
                              path, count);
        return transfer_paraview_parse(spec, path, root->child, err);
    }
    if (!cJSON_IsObject(root))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: not a transfer function: no JSON object", path);
    if (cJSON_GetObjectItemCaseSensitive(root, "RGBPoints"))
        return transfer_paraview_parse(spec, path, root, err);
    return parse_own(spec, path, root, err);
}

int fmt_transfer_read(struct brick_transfer_spec *spec, const char *path, struct brick_error *err)
{
    char *text = NULL;
    size_t bytes = 0;
    const char *end = NULL;
    *spec = (struct brick_transfer_spec){0};
    int result = read_text(&text, &bytes, path, err);
    if (result)
        return result;
    cJSON *root = strlen(text) == bytes ? cJSON_ParseWithLengthOpts(text, bytes + 1, &end, 1) : NULL;
    if (root) {
        result = parse_root(spec, path, root, err);
        if (result)
            brick_transfer_spec_finish(spec);
    } else {
        const size_t at =
            end && end >= text && (size_t)(end - text) <= bytes ? (size_t)(end - text) : strlen(text);
        result = brick_fail_at(err, BRICK_ERR_FORMAT, at, BRICK_NO_BRICK, "%s: not JSON, from byte %zu on",
                               path, at);
    }
    cJSON_Delete(root);
    free(text);
    return result;
}
