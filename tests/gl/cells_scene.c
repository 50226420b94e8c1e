/* The pictures and the bounds of cells_scene.h. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "basis.h"
#include "cells_scene.h"

#define ROUNDING 1e-5

/* Extinction up to 0.23 a mm. */
const struct brick_transfer_point cells_points[4] = {
    {-1200, 0.2, 0.9, 0.1, 0.05}, {-300, 0.5, 0.1, 1.0, 0.0}, {100, 1, 1, 1, 0.0}, {900, 0.9, 0.5, 0.1, 0.2}};

static const double oblique[3][4] = {{0.9, 0.1, 0.0, 5}, {-0.1, 0.8, 0.05, -3}, {0.0, 0.1, -1.4, 100}};

/* The largest, a mm. */
#define SIGMA 0.2231

/* Of rays so near an outline most are near one of few tetrahedra: in the mean square they matter little. */
#define MISS_MEAN 0.05

static double wave(int i, int nx, int ny)
{
    int x = i % nx, y = i / nx % ny, z = i / nx / ny;
    return 1000 * sin(0.3 * x + 1.1) * cos(0.21 * y + 0.4) * sin(0.17 * z + 1.0);
}

struct brick_volume *wave_volume(struct memory_source *source, enum brick_type type, int nx, int ny, int nz,
                                 void *voxels, double slope, double intercept, uint32_t edge)
{
    for (int i = 0; i < nx * ny * nz; i++) {
        double v = wave(i, nx, ny);
        if (type != BRICK_F32)
            v = rint((v - intercept) / slope);
        store_voxel(type, voxels, (size_t)i, v);
    }
    memory_source_init(source, type, (uint64_t)nx, (uint64_t)ny, (uint64_t)nz, voxels);
    source->base.geometry.slope = slope;
    source->base.geometry.intercept = intercept;
    memcpy(source->base.geometry.affine, oblique, sizeof oblique);
    return volume_of(source, edge);
}

void look(struct vr_scene *scene, const struct brick_volume *volume, double azimuth, double elevation,
          bool perspective)
{
    scene->width = scene->height = EDGE;
    brick_camera_orbit(&scene->camera, brick_volume_grid(volume), azimuth, elevation, 0,
                       perspective ? 0.0 : 70.0, 1.0);
}

struct brick_image exact_of(const struct brick_volume *volume, const struct vr_scene *scene)
{
    struct vr_exact_params params = vr_exact_defaults;
    struct brick_error err = {0};
    struct brick_image image;
    params.field = VR_FIELD_TETRAHEDRA;
    assert_int_equal(brick_image_init(&image, scene->width, scene->height, &err), 0);
    if (vr_render_exact(volume, scene, &params, &image, NULL, &err))
        fail_msg("%s", err.message);
    return image;
}

/* An outline moves by up to half of 1/256 pixel on both axes. Within a fan's triangle the length grows from 0
 * at the outline to all of it at the thick vertex. */
static double miss_mm(const struct brick_volume *volume, const struct vr_scene *scene, bool *edge_on)
{
    struct brick_view view;
    struct vr_lattice q;
    double most = 0.0;
    assert_int_equal(
        brick_view_init(&view, &scene->camera, brick_volume_grid(volume), scene->width, scene->height, NULL),
        0);
    vr_lattice_init(&q, &view, &brick_volume_grid(volume)->level[scene->level]);
    *edge_on = false;
    for (int odd = 0; odd < 2; odd++) {
        struct vr_basis_cell cell;
        vr_basis_cell(&q, (const int[]){0, 0, 0}, odd, &cell);
        for (int i = 0; i < cell.count; i++) {
            const struct vr_basis_tetrahedron *t = &cell.tetrahedron[i];
            *edge_on = *edge_on || t->projection_class > 2;
            for (int k = 0; k < t->triangles; k++) {
                double p[3][2]; /* two on the outline, and the thick one */
                for (int j = 0; j < 3; j++) {
                    int vertex = j == 2 ? t->anchor : t->around[(k + j) % 4];
                    for (int r = 0; r < 2; r++) {
                        const double *row = r ? q.row : q.column;
                        p[j][r] = j == 2 ? t->offset[r] : 0.0;
                        for (int a = 0; a < 3; a++)
                            p[j][r] += row[a] * (t->corner[vertex] >> a & 1);
                    }
                }
                double x = p[1][0] - p[0][0], y = p[1][1] - p[0][1];
                double height = fabs(x * (p[2][1] - p[0][1]) - y * (p[2][0] - p[0][0])) / hypot(x, y);
                most = fmax(most, t->length_mm * fmin(1.0, M_SQRT1_2 / 256.0 / height));
            }
        }
    }
    return most;
}

static void compare(const struct brick_image *image, const struct brick_image *want, double most, double mean,
                    const char *what)
{
    int n = (int)(image->width * image->height);
    double worst = 0.0, seen = 0.0, squares = 0.0;
    for (int i = 0; i < n; i++) {
        double pixel = 0.0;
        for (int c = 0; c < 4; c++)
            pixel = fmax(pixel, fabs((double)image->rgba[4 * i + c] - (double)want->rgba[4 * i + c]));
        squares += pixel * pixel;
        worst = fmax(worst, pixel);
        seen = fmax(seen, (double)want->rgba[4 * i + 3]);
    }
    print_message("%s: worst %.2e, rmse %.2e; at most %.2e, %.2e\n", what, worst, sqrt(squares / n), most,
                  mean);
    assert_true(seen > 0.02);
    assert_true(worst < most);
    assert_true(sqrt(squares / n) < mean);
}

void against_exact(struct vr_renderer *renderer, const struct brick_volume *volume,
                   const struct vr_scene *scene, const char *what)
{
    struct vr_quality quality = vr_quality_defaults;
    struct vr_report report;
    struct brick_image image, want = exact_of(volume, scene);
    quality.method = VR_METHOD_CELLS;
    quality.cells_integration = VR_CELLS_EXACT;
    render(renderer, scene, &quality, &image, &report);
    if (scene->camera.ortho_height_mm > 0.0) {
        bool edge_on; /* basis.c is wrong by that little */
        double miss = SIGMA * miss_mm(volume, scene, &edge_on), rounding = edge_on ? miss : ROUNDING;
        /* Rays with more than two misses are few. */
        compare(&image, &want, 2.0 * miss + rounding, MISS_MEAN * miss + rounding, what);
    } else {
        compare(&image, &want, CELLS_ROUNDING, CELLS_NOISE, what);
    }
    assert_true(report.samples > 0 && report.samples <= report.tetrahedra);
    brick_image_finish(&image);
    brick_image_finish(&want);
}

void fixture_init(struct fixture *f, enum brick_type type, void *voxels)
{
    f->volume = wave_volume(&f->source, type, NX, NY, NZ, voxels, 1, 0, 16);
    f->transfer = transfer_of(cells_points, 4);
    f->renderer = try_renderer(f->volume, VR_CONTEXT_AUTO);
    f->scene = vr_scene_defaults;
    f->scene.transfer = f->transfer;
    f->quality = vr_quality_defaults;
    f->quality.method = VR_METHOD_CELLS;
    look(&f->scene, f->volume, 37, 24, false);
}

void fixture_finish(struct fixture *f)
{
    bool skipped = !f->renderer;
    vr_renderer_destroy(&f->renderer);
    brick_transfer_destroy(&f->transfer);
    brick_volume_close(&f->volume);
    if (skipped)
        skip();
}
