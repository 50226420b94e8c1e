/* Why: films. A camera's file is read strictly: a name that is not known is an error, not a camera that looks
 * elsewhere. */
#include "cameras.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#define FILE_BYTES_MAX ((size_t)16 << 20)

static int cameras_init(struct tool_cameras *cameras, size_t n, struct brick_error *err)
{
    *cameras = (struct tool_cameras){calloc(n, sizeof *cameras->item), n};
    return cameras->item ? BRICK_OK : brick_fail(err, BRICK_ERR_MEMORY, "no memory for %zu cameras", n);
}

void tool_cameras_finish(struct tool_cameras *cameras)
{
    free(cameras->item);
    *cameras = (struct tool_cameras){0};
}

int tool_cameras_turntable(struct tool_cameras *cameras, const struct brick_grid *grid,
                           const struct tool_view *view, uint32_t n, struct brick_error *err)
{
    int code = cameras_init(cameras, n, err);
    for (uint32_t i = 0; !code && i < n; i++)
        brick_camera_orbit(&cameras->item[i], grid, view->azimuth + 360.0 * i / n, view->elevation,
                           view->fov_deg, view->ortho_height_mm, view->aspect);
    return code;
}

static int read_text(const char *path, char **text, struct brick_error *err)
{
    FILE *file = fopen(path, "rb");
    size_t bytes = 0;
    int code = BRICK_OK;
    *text = NULL;
    if (!file)
        return brick_fail(err, BRICK_ERR_IO, "%s: %s", path, strerror(errno));
    if (!(*text = malloc(FILE_BYTES_MAX + 1)))
        code = brick_fail(err, BRICK_ERR_MEMORY, "%s: no memory to read it", path);
    else if ((bytes = fread(*text, 1, FILE_BYTES_MAX + 1, file)), ferror(file))
        code = brick_fail(err, BRICK_ERR_IO, "%s: it cannot be read: %s", path, strerror(errno));
    else if (bytes > FILE_BYTES_MAX || memchr(*text, 0, bytes))
        code = brick_fail(err, BRICK_ERR_FORMAT, "%s: not a list of cameras", path);
    else
        (*text)[bytes] = 0;
    fclose(file);
    return code;
}

static bool take_number(const cJSON *item, double *value)
{
    if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble))
        return false;
    *value = item->valuedouble;
    return true;
}

static bool take_triple(const cJSON *item, double value[3])
{
    if (!cJSON_IsArray(item) || cJSON_GetArraySize(item) != 3)
        return false;
    for (int a = 0; a < 3; a++)
        if (!take_number(cJSON_GetArrayItem(item, a), &value[a]))
            return false;
    return true;
}

/* What is wrong with it, or NULL. */
static const char *take_camera(const cJSON *json, const struct brick_grid *grid, const struct tool_view *view,
                               struct brick_camera *camera)
{
    struct tool_view v = *view;
    double eye[3], look[3], up[3] = {0, 0, 1};
    bool has_orbit = false, has_eye = false, has_look = false, has_up = false, has_fov = false,
         has_ortho = false;
    if (!cJSON_IsObject(json))
        return "is not an object";
    for (const cJSON *item = json->child; item; item = item->next) {
        const char *name = item->string;
        bool good = false;
        if (!strcmp(name, "azimuth"))
            good = has_orbit = take_number(item, &v.azimuth);
        else if (!strcmp(name, "elevation"))
            good = has_orbit = take_number(item, &v.elevation);
        else if (!strcmp(name, "eye"))
            good = has_eye = take_triple(item, eye);
        else if (!strcmp(name, "look"))
            good = has_look = take_triple(item, look);
        else if (!strcmp(name, "up"))
            good = has_up = take_triple(item, up);
        else if (!strcmp(name, "fov"))
            good = has_fov = take_number(item, &v.fov_deg) && v.fov_deg >= 0.001 && v.fov_deg <= 179.0;
        else if (!strcmp(name, "ortho"))
            good = has_ortho = take_number(item, &v.ortho_height_mm) && v.ortho_height_mm > 0.0;
        if (!good)
            return "has a value that is not azimuth, elevation, fov or ortho (a number in range), or eye, "
                   "look or up (three numbers)";
    }
    if (!has_orbit && !has_eye)
        return "has neither azimuth or elevation nor eye";
    if (has_orbit && (has_eye || has_look || has_up))
        return "has both azimuth or elevation and eye, look or up";
    if (has_fov && has_ortho)
        return "has both fov and ortho";
    if (has_fov)
        v.ortho_height_mm = 0.0;
    brick_camera_orbit(camera, grid, v.azimuth, v.elevation, v.fov_deg, v.ortho_height_mm, v.aspect);
    if (has_eye) {
        memcpy(camera->eye_mm, eye, sizeof eye);
        memcpy(camera->up, up, sizeof up);
        if (has_look)
            memcpy(camera->look_mm, look, sizeof look);
    }
    return NULL;
}

int tool_cameras_load(struct tool_cameras *cameras, const char *path, const struct brick_grid *grid,
                      const struct tool_view *view, struct brick_error *err)
{
    char *text;
    cJSON *json = NULL;
    int code = read_text(path, &text, err);
    *cameras = (struct tool_cameras){0};
    if (!code && !(json = cJSON_ParseWithOpts(text, NULL, true)))
        code = brick_fail(err, BRICK_ERR_FORMAT, "%s: not JSON", path);
    if (!code && (!cJSON_IsArray(json) || !json->child))
        code = brick_fail(err, BRICK_ERR_FORMAT, "%s: not a list of cameras", path);
    if (!code)
        code = cameras_init(cameras, (size_t)cJSON_GetArraySize(json), err);
    size_t i = 0;
    for (const cJSON *item = json ? json->child : NULL; item && !code; item = item->next, i++) {
        const char *wrong = take_camera(item, grid, view, &cameras->item[i]);
        if (wrong)
            code = brick_fail(err, BRICK_ERR_FORMAT, "%s: camera %zu %s", path, i, wrong);
    }
    if (code)
        tool_cameras_finish(cameras);
    cJSON_Delete(json);
    free(text);
    return code;
}
