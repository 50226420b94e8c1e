/* Why: both programs must draw the same field, transfer function, light and cameras. */
#include "peer_scene.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <brick/checked.h>
#include <cjson/cJSON.h>

static int check_axes(const struct brick_grid *grid, double spacing[3], double origin[3],
                      struct brick_error *err)
{
    for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 3; b++)
            if (a != b && fabs(grid->affine[a][b]) > 1e-9 * fabs(grid->affine[a][a]))
                return brick_fail(
                    err, BRICK_ERR_UNSUPPORTED,
                    "VTK's volume mappers take volumes whose axes are the world's; this one is turned");
        double step = grid->affine[a][a];
        spacing[a] = fabs(step);
        origin[a] = grid->affine[a][3] + (step < 0 ? step * ((double)grid->dims[a] - 1.0) : 0.0);
    }
    if (!(grid->slope > 0))
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "values fall while stored values rise; VTK is given stored ones");
    return BRICK_OK;
}

static void swap(char *a, char *b, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++) {
        char t = a[i];
        a[i] = b[i], b[i] = t;
    }
}

/* Turn x round in every row, y in every slice. */
static void turn(char *slice, const struct brick_grid *grid, size_t voxel)
{
    const size_t nx = (size_t)grid->dims[0], ny = (size_t)grid->dims[1], row = nx * voxel;
    if (grid->affine[0][0] < 0)
        for (size_t y = 0; y < ny; y++)
            for (size_t x = 0; x < nx / 2; x++)
                swap(slice + y * row + x * voxel, slice + y * row + (nx - 1 - x) * voxel, voxel);
    if (grid->affine[1][1] < 0)
        for (size_t y = 0; y < ny / 2; y++)
            swap(slice + y * row, slice + (ny - 1 - y) * row, row);
}

int peer_scene_write_volume(const struct brick_volume *volume, const char *path, double spacing[3],
                            double origin[3], struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const size_t voxel = brick_type_bytes(grid->type);
    const uint64_t nz = grid->dims[2], height = grid->edge;
    uint64_t slice, bytes;
    int code = check_axes(grid, spacing, origin, err);
    if (code)
        return code;
    if (!brick_mul3_u64(grid->dims[0], grid->dims[1], voxel, &slice) ||
        !brick_mul_u64(slice, height, &bytes) || bytes > SIZE_MAX)
        return brick_fail(err, BRICK_ERR_MEMORY, "a row of bricks is larger than memory can be");
    char *slab = malloc((size_t)bytes);
    FILE *file = slab ? fopen(path, "wb") : NULL;
    if (!slab)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for %llu bytes", (unsigned long long)bytes);
    if (!file)
        code = brick_fail(err, BRICK_ERR_IO, "%s: cannot write: %s", path, strerror(errno));
    /* Slabs of the file in its order: from the other end where z is turned round. */
    for (uint64_t done = 0; done < nz && !code;) {
        const bool down = grid->affine[2][2] < 0;
        uint64_t n = nz - done < height ? nz - done : height;
        uint64_t z = down ? nz - done - n : done;
        code = brick_volume_read_box(volume, 0, (uint64_t[]){0, 0, z},
                                     (uint64_t[]){grid->dims[0], grid->dims[1], z + n}, slab, err);
        for (uint64_t i = 0; i < n && !code; i++) {
            char *at = slab + (down ? n - 1 - i : i) * slice;
            turn(at, grid, voxel);
            if (fwrite(at, 1, (size_t)slice, file) != slice)
                code = brick_fail(err, BRICK_ERR_IO, "%s: cannot write: %s", path, strerror(errno));
        }
        done += n;
    }
    if (file && fclose(file) && !code)
        code = brick_fail(err, BRICK_ERR_IO, "%s: cannot write: %s", path, strerror(errno));
    free(slab);
    return code;
}

static void add_camera(cJSON *list, const struct brick_camera *camera)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddItemToObject(json, "eye", cJSON_CreateDoubleArray(camera->eye_mm, 3));
    cJSON_AddItemToObject(json, "look", cJSON_CreateDoubleArray(camera->look_mm, 3));
    cJSON_AddItemToObject(json, "up", cJSON_CreateDoubleArray(camera->up, 3));
    cJSON_AddNumberToObject(json, "fov", camera->fov_deg);
    cJSON_AddNumberToObject(json, "ortho", camera->ortho_height_mm);
    cJSON_AddItemToArray(list, json);
}

struct cJSON *peer_scene_json(const struct brick_volume *volume, const struct vr_scene *scene, double step_mm,
                              const char *volume_path, const double spacing[3], const double origin[3],
                              const struct brick_camera *cameras, size_t count)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_transfer *transfer = scene->transfer;
    const double dims[3] = {(double)grid->dims[0], (double)grid->dims[1], (double)grid->dims[2]};
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "volume", volume_path);
    cJSON_AddItemToObject(json, "dims", cJSON_CreateDoubleArray(dims, 3));
    cJSON_AddStringToObject(json, "type", brick_type_name(grid->type));
    cJSON_AddItemToObject(json, "spacing", cJSON_CreateDoubleArray(spacing, 3));
    cJSON_AddItemToObject(json, "origin", cJSON_CreateDoubleArray(origin, 3));
    cJSON_AddNumberToObject(json, "unit_mm", transfer->unit_mm);
    cJSON_AddNumberToObject(json, "step_mm", step_mm);
    cJSON_AddNumberToObject(json, "isovalue", (scene->isovalue - grid->intercept) / grid->slope);
    cJSON_AddItemToObject(json, "iso_rgb", cJSON_CreateDoubleArray(scene->iso_rgb, 3));
    cJSON_AddNumberToObject(json, "ambient", scene->ambient);
    cJSON_AddNumberToObject(json, "diffuse", scene->diffuse);
    cJSON_AddNumberToObject(json, "specular", scene->specular);
    cJSON_AddNumberToObject(json, "shininess", scene->shininess);
    cJSON *size = cJSON_AddArrayToObject(json, "size");
    cJSON_AddItemToArray(size, cJSON_CreateNumber(scene->width));
    cJSON_AddItemToArray(size, cJSON_CreateNumber(scene->height));
    cJSON *points = cJSON_AddArrayToObject(json, "points");
    for (size_t i = 0; i < transfer->count; i++) {
        const struct brick_transfer_knot *k = &transfer->knots[i];
        const double point[5] = {(k->value - grid->intercept) / grid->slope, k->r, k->g, k->b,
                                 -expm1(-k->sigma * transfer->unit_mm)};
        cJSON_AddItemToArray(points, cJSON_CreateDoubleArray(point, 5));
    }
    cJSON *list = cJSON_AddArrayToObject(json, "cameras");
    for (size_t i = 0; i < count; i++)
        add_camera(list, &cameras[i]);
    return json;
}
