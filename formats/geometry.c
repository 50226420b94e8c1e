/* Why: every source ends in the same affine, index -> mm in LPS, and the caller's overrides mean the same for
 * all. What a usable geometry is, brick_grid_init decides; here it is only asked. */
#include "geometry.h"

#include <math.h>
#include <string.h>

const struct brick_geometry fmt_geometry_identity = {
    .dims = {1, 1, 1},
    .affine = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
    .slope = 1.0,
    .intercept = 0.0,
};

int fmt_geometry_bytes(const uint64_t dims[3], enum brick_type type, const char *path, uint64_t *bytes,
                       struct brick_error *err)
{
    uint64_t total = brick_type_bytes(type);
    for (int a = 0; a < 3; a++) {
        if (dims[a] == 0)
            return brick_fail(err, BRICK_ERR_FORMAT,
                              "%s: axis %d has size 0, every axis needs at least one voxel", path, a);
        if (dims[a] > BRICK_MAX_DIM || __builtin_mul_overflow(total, dims[a], &total) ||
            total > INT64_MAX / 2)
            return brick_fail(err, BRICK_ERR_FORMAT, "%s: size %llu x %llu x %llu is beyond any file", path,
                              (unsigned long long)dims[0], (unsigned long long)dims[1],
                              (unsigned long long)dims[2]);
    }
    *bytes = total;
    return BRICK_OK;
}

static double norm(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Make v a unit vector; false when it has no direction. */
static bool normalize(double v[3])
{
    double n = norm(v);
    if (!(n > 0.0) || !isfinite(n))
        return false;
    for (int r = 0; r < 3; r++)
        v[r] /= n;
    return true;
}

void fmt_geometry_set_axes(struct brick_geometry *geometry, double directions[3][3], unsigned axes,
                           const double origin_mm[3])
{
    if (axes == 1) {
        /* The patient axis least along the only direction, less its part along it. */
        double along[3] = {directions[0][0], directions[0][1], directions[0][2]};
        int least = 1;
        if (normalize(along)) {
            for (int r = 0; r < 3; r++)
                if (fabs(along[r]) < fabs(along[least]))
                    least = r;
            for (int r = 0; r < 3; r++)
                directions[1][r] = (r == least) - along[least] * along[r];
        }
        if (!normalize(directions[1]))
            memcpy(directions[1], (double[3]){0, 1, 0}, sizeof directions[1]);
    }
    if (axes <= 2) {
        const double *a = directions[0], *b = directions[1];
        for (int r = 0; r < 3; r++)
            directions[2][r] = a[(r + 1) % 3] * b[(r + 2) % 3] - a[(r + 2) % 3] * b[(r + 1) % 3];
        if (!normalize(directions[2]))
            memcpy(directions[2], (double[3]){0, 0, 1}, sizeof directions[2]);
    }
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++)
            geometry->affine[r][c] = directions[c][r] + 0.0; /* a mirrored 0 is 0, not -0 */
        geometry->affine[r][3] = origin_mm[r] + 0.0;
    }
}

void fmt_geometry_spacing(const double affine[3][4], double spacing_mm[3])
{
    for (int c = 0; c < 3; c++)
        spacing_mm[c] = norm((double[3]){affine[0][c], affine[1][c], affine[2][c]});
}

int fmt_geometry_override(struct brick_geometry *geometry, const struct fmt_source_params *params,
                          struct brick_error *err)
{
    if (params->has_slope)
        geometry->slope = params->slope;
    if (params->has_intercept)
        geometry->intercept = params->intercept;
    if (params->has_affine) {
        if (params->has_spacing || params->has_origin || params->axes[0])
            return brick_fail(err, BRICK_ERR_ARGUMENT,
                              "an affine says everything: give it, or spacing, origin and axes, not both");
        memcpy(geometry->affine, params->affine, sizeof geometry->affine);
        return BRICK_OK;
    }
    double spacing[3], known[3];
    fmt_geometry_spacing(geometry->affine, known);
    for (int c = 0; c < 3; c++) {
        spacing[c] = params->has_spacing ? params->spacing_mm[c] : known[c];
        if (params->has_spacing && !(spacing[c] > 0.0 && isfinite(spacing[c])))
            return brick_fail(err, BRICK_ERR_ARGUMENT, "spacing %g is not a positive length", spacing[c]);
    }
    double origin[3];
    for (int r = 0; r < 3; r++)
        origin[r] = params->has_origin ? params->origin_mm[r] : geometry->affine[r][3];
    if (params->axes[0])
        return brick_affine_from_axes(params->axes, spacing, origin, geometry->affine, err);
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3 && params->has_spacing; c++)
            geometry->affine[r][c] = geometry->affine[r][c] / known[c] * spacing[c];
        geometry->affine[r][3] = origin[r];
    }
    return BRICK_OK;
}

int fmt_geometry_check(const struct brick_geometry *geometry, const char *path, struct brick_error *err)
{
    struct brick_grid grid;
    struct brick_error why;
    /* Any stored type and layout will do; the largest bricks leave the most room. */
    if (brick_grid_init(&grid, BRICK_U8, geometry, 256, 2, 16, &why))
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: %s (say --spacing with --axes, or --affine)", path,
                          why.message);
    return BRICK_OK;
}
