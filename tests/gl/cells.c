/* Projected cells against the exact integral of the same field, and against themselves: for every type,
 * through the volume's rim, cut, at coarser levels, with voxels that are not finite, and from small caches.
 *
 * Two kinds of error are allowed. Rounding: scalars and lengths that the rasteriser interpolates, right to
 * some 1e-6 of a voxel's step, and sums of some 100 float32 terms: ROUNDING. And where a ray passes within
 * 1/256 pixel of a tetrahedron's outline, since corners are rounded to that: a tetrahedron then counts that
 * the ray misses, or not one that it meets, by its length so near to where it is 0: miss_mm. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "basis.h"
#include "gl_scene.h"

#define NX   37
#define NY   30
#define NZ   41
#define EDGE 64

#define ROUNDING 1e-5

/* Extinction up to 0.23 a mm. */
static const struct brick_transfer_point points[] = {
    {-1200, 0.2, 0.9, 0.1, 0.05}, {-300, 0.5, 0.1, 1.0, 0.0}, {100, 1, 1, 1, 0.0}, {900, 0.9, 0.5, 0.1, 0.2}};

static const double oblique[3][4] = {{0.9, 0.1, 0.0, 5}, {-0.1, 0.8, 0.05, -3}, {0.0, 0.1, -1.4, 100}};

/* The largest, a mm. */
#define SIGMA 0.2231

/* Of rays so near an outline most are near one of few tetrahedra: in the mean square they matter little. */
#define MISS_MEAN 0.05

/* An outline moves by up to half of 1/256 pixel on both axes. Within a fan's triangle the length grows from 0
 * at the outline to all of it at the thick vertex. */
static double miss_mm(const struct brick_volume *volume, const struct vr_scene *scene, bool *edge_on)
{
    struct brick_view view;
    struct vr_projection q;
    double most = 0.0;
    assert_int_equal(
        brick_view_init(&view, &scene->camera, brick_volume_grid(volume), scene->width, scene->height, NULL),
        0);
    vr_projection_init(&q, &view, &brick_volume_grid(volume)->level[scene->level]);
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

static void look(struct vr_scene *scene, const struct brick_volume *volume, double azimuth, double elevation)
{
    scene->width = scene->height = EDGE;
    brick_camera_orbit(&scene->camera, brick_volume_grid(volume), azimuth, elevation, 0, 70.0, 1.0);
}

static struct brick_image exact_of(const struct brick_volume *volume, const struct vr_scene *scene)
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

static void compare(const struct brick_image *image, const struct brick_image *want, double rounding,
                    double miss, const char *what)
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
    print_message("%s: worst %.2e, rmse %.2e; a miss %.2e\n", what, worst, sqrt(squares / n), miss);
    assert_true(seen > 0.02);
    assert_true(worst < 2.0 * miss + rounding); /* rays with more than two are few */
    assert_true(sqrt(squares / n) < MISS_MEAN * miss + rounding);
}

static void against_exact(struct vr_renderer *renderer, const struct brick_volume *volume,
                          const struct vr_scene *scene, const char *what)
{
    struct vr_quality quality = vr_quality_defaults;
    struct vr_report report;
    struct brick_image image, want = exact_of(volume, scene);
    quality.method = VR_METHOD_CELLS;
    quality.cells_integration = VR_CELLS_EXACT;
    render(renderer, scene, &quality, &image, &report);
    bool edge_on;
    double miss = SIGMA * miss_mm(volume, scene, &edge_on);
    compare(&image, &want, edge_on ? miss : ROUNDING, miss,
            what); /* edge on: basis.c is wrong by that little */
    assert_true(report.samples > 0 && report.samples <= report.tetrahedra);
    brick_image_finish(&image);
    brick_image_finish(&want);
}

static double wave(int i, int nx, int ny)
{
    int x = i % nx, y = i / nx % ny, z = i / nx / ny;
    return 1000 * sin(0.3 * x + 1.1) * cos(0.21 * y + 0.4) * sin(0.17 * z + 1.0);
}

/* A volume of waves on oblique axes; voxels is room for it. */
static struct brick_volume *wave_volume(struct memory_source *source, enum brick_type type, int nx, int ny,
                                        int nz, void *voxels, double slope, double intercept, uint32_t edge)
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

static void test_types(void **state)
{
    static float voxels[NX * NY * NZ];
    static const struct {
        enum brick_type type;
        double slope, intercept;
        int azimuth, elevation;
    } cases[] = {{BRICK_U8, 8, -1024, 37, 24},   {BRICK_I8, 8, 0, 0, 0},     {BRICK_U16, 1, -1024, 215, -40},
                 {BRICK_I16, -0.7, 12.3, 90, 0}, {BRICK_F32, 1, 0, 45, 35},  {BRICK_I16, 1, 0, 0, 90},
                 {BRICK_U16, -1, 2000, 300, 5},  {BRICK_F32, 1, 0, 180, -90}};
    bool skipped = false;
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases && !skipped; i++) {
        struct memory_source source;
        struct vr_scene scene = vr_scene_defaults;
        struct brick_volume *volume =
            wave_volume(&source, cases[i].type, NX, NY, NZ, voxels, cases[i].slope, cases[i].intercept, 16);
        struct brick_transfer *transfer = transfer_of(points, 4);
        struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
        scene.transfer = transfer;
        look(&scene, volume, cases[i].azimuth, cases[i].elevation);
        if (renderer)
            against_exact(renderer, volume, &scene, brick_type_name(cases[i].type));
        skipped = !renderer;
        vr_renderer_destroy(&renderer);
        brick_transfer_destroy(&transfer);
        brick_volume_close(&volume);
    }
    if (skipped)
        skip();
}

/* Volumes of one voxel on an axis are all rim; coarser levels of odd sizes stick out of level 0's box. */
static void test_thin_and_levels(void **state)
{
    static float voxels[NX * NY * NZ];
    static const int sizes[][3] = {{1, NY, NZ}, {NX, 1, NZ}, {NX, NY, 1}, {NX, NY, NZ}};
    bool skipped = false;
    (void)state;
    for (int i = 0; i < 4 && !skipped; i++) {
        struct memory_source source;
        struct vr_scene scene = vr_scene_defaults;
        struct brick_volume *volume =
            wave_volume(&source, BRICK_I16, sizes[i][0], sizes[i][1], sizes[i][2], voxels, 1, 0, 8);
        struct brick_transfer *transfer = transfer_of(points, 4);
        struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
        scene.transfer = transfer;
        look(&scene, volume, 25, 15);
        if (renderer && i < 3)
            against_exact(renderer, volume, &scene, "thin");
        for (scene.level = 1; renderer && i == 3 && scene.level < brick_volume_grid(volume)->levels;
             scene.level++)
            against_exact(renderer, volume, &scene, "coarser level");
        skipped = !renderer;
        vr_renderer_destroy(&renderer);
        brick_transfer_destroy(&transfer);
        brick_volume_close(&volume);
    }
    if (skipped)
        skip();
}

/* What a test of one volume has. */
struct fixture {
    struct memory_source source;
    struct brick_volume *volume;
    struct brick_transfer *transfer;
    struct vr_renderer *renderer; /* NULL: skip */
    struct vr_scene scene;
    struct vr_quality quality;
};

static void fixture_init(struct fixture *f, enum brick_type type, void *voxels)
{
    f->volume = wave_volume(&f->source, type, NX, NY, NZ, voxels, 1, 0, 16);
    f->transfer = transfer_of(points, 4);
    f->renderer = try_renderer(f->volume, VR_CONTEXT_AUTO);
    f->scene = vr_scene_defaults;
    f->scene.transfer = f->transfer;
    f->quality = vr_quality_defaults;
    f->quality.method = VR_METHOD_CELLS;
    look(&f->scene, f->volume, 37, 24);
}

static void fixture_finish(struct fixture *f)
{
    bool skipped = !f->renderer;
    vr_renderer_destroy(&f->renderer);
    brick_transfer_destroy(&f->transfer);
    brick_volume_close(&f->volume);
    if (skipped)
        skip();
}

/* A box with a corner cut off, planes that rays run along, the eye inside. */
static void test_clip(void **state)
{
    static float voxels[NX * NY * NZ];
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    if (f.renderer) {
        const double *centre = f.scene.camera.look_mm;
        for (int i = 0; i < 6; i++) {
            double sign = i < 3 ? 1.0 : -1.0;
            f.scene.clip[i].normal[i % 3] = sign;
            f.scene.clip[i].offset_mm = sign * centre[i % 3] - 7.3;
        }
        f.scene.clip[5] =
            (struct vr_plane){{-1, 0.7, 0.4}, -centre[0] + 0.7 * centre[1] + 0.4 * centre[2] - 3};
        f.scene.clip_count = 6;
        against_exact(f.renderer, f.volume, &f.scene, "clip planes");
        look(&f.scene, f.volume, 0, 0);
        against_exact(f.renderer, f.volume, &f.scene, "clip planes along rays");
        f.scene.clip_count = 0;
        look(&f.scene, f.volume, 37, 24);
        for (int i = 0; i < 3; i++)
            f.scene.camera.eye_mm[i] = 0.02 * f.scene.camera.eye_mm[i] + 0.98 * centre[i];
        against_exact(f.renderer, f.volume, &f.scene, "eye inside");
    }
    fixture_finish(&f);
}

static void test_nonfinite(void **state)
{
    static float voxels[NX * NY * NZ];
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_F32, voxels);
    brick_volume_close(&f.volume);
    vr_renderer_destroy(&f.renderer);
    for (uint64_t i = 0; i < 200; i++)
        voxels[noise64(3, i) % (NX * NY * NZ)] = i % 3 ? (i % 3 == 1 ? NAN : INFINITY) : 1e4f;
    f.volume = volume_of(&f.source, 16);
    f.renderer = try_renderer(f.volume, VR_CONTEXT_AUTO);
    if (f.renderer) {
        struct brick_image image, all;
        against_exact(f.renderer, f.volume, &f.scene, "not finite");
        render(f.renderer, &f.scene, &f.quality, &image, NULL);
        f.quality.skip = false;
        render(f.renderer, &f.scene, &f.quality, &all, NULL);
        assert_same_image(&image, &all, "no skipping, not finite");
        brick_image_finish(&image);
        brick_image_finish(&all);
    }
    fixture_finish(&f);
}

/* The same bytes from a cache of two bricks, in parts, and with nothing skipped; for other bricks the same
 * but for tetrahedra that a ray passes within 1/256 pixel, whose order is not determined. */
static void test_memory(void **state)
{
    static float voxels[NX * NY * NZ];
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    if (f.renderer) {
        struct vr_renderer_params params = vr_renderer_defaults;
        struct vr_renderer *small = NULL;
        struct brick_image image, other;
        struct vr_report report, few;
        struct brick_image_difference d;
        f.scene.width = 1030; /* more than one part */
        f.scene.height = 40;
        render(f.renderer, &f.scene, &f.quality, &image, &report);
        params.gpu_cache_bytes = params.host_cache_bytes = 2 * 20 * 20 * 20 * sizeof(int16_t);
        assert_int_equal(vr_renderer_create(&small, f.volume, &params, NULL), 0);
        render(small, &f.scene, &f.quality, &other, &few);
        assert_same_image(&image, &other, "a cache of two bricks");
        assert_true(few.passes > report.passes && few.gpu_cache_bytes <= params.gpu_cache_bytes);
        assert_int_equal(few.samples, report.samples);
        brick_image_finish(&other);
        vr_renderer_destroy(&small);

        f.quality.skip = false;
        render(f.renderer, &f.scene, &f.quality, &other, &few);
        assert_same_image(&image, &other, "no skipping");
        assert_true(few.samples > report.samples);
        brick_image_finish(&other);
        f.quality.skip = true;

        vr_renderer_destroy(&f.renderer);
        brick_volume_close(&f.volume);
        f.volume = volume_of(&f.source, 32);
        f.renderer = try_renderer(f.volume, VR_CONTEXT_AUTO);
        render(f.renderer, &f.scene, &f.quality, &other, &few);
        assert_int_equal(brick_image_compare(&image, &other, &d, NULL), 0);
        print_message("bricks of 32: %g\n", d.max_abs);
        assert_true(d.max_abs < 1e-5);
        assert_int_equal(few.samples, report.samples);
        brick_image_finish(&image);
        brick_image_finish(&other);
    }
    fixture_finish(&f);
}

/* Where the transfer function has no knot between a tetrahedron's ends partial pre-integration is exact but
 * for its table, and the ends' mean scalar has the mean colour; exponentials by table are off by 2e-6 each.
 */
static void test_integrations(void **state)
{
    static float voxels[NX * NY * NZ];
    static const struct brick_transfer_point straight[] = {{-1100, 0.1, 0.9, 0.2, 0.0},
                                                           {1100, 0.9, 0.2, 0.6, 0.01}};
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    if (f.renderer) {
        struct brick_transfer *transfer = transfer_of(straight, 2);
        struct brick_image image[VR_CELLS_INTEGRATIONS];
        struct brick_image_difference d;
        f.scene.transfer = transfer;
        assert_int_equal(transfer->count, 2);
        for (int i = 0; i < VR_CELLS_INTEGRATIONS; i++) {
            f.quality.cells_integration = (enum vr_cells_integration)i;
            render(f.renderer, &f.scene, &f.quality, &image[i], NULL);
        }
        static const struct {
            int a, b;
            double limit;
        } pairs[] = {
            {VR_CELLS_PREFIX, VR_CELLS_EXACT, 2e-6},   /* rounding: depths are far below 0.1 */
            {VR_CELLS_PSI, VR_CELLS_EXACT, 2e-5},      /* some 100 times the table's error, times colour */
            {VR_CELLS_SCALAR, VR_CELLS_AVERAGE, 4e-6}, /* rounding */
            {VR_CELLS_EXP, VR_CELLS_AVERAGE, 3e-4},    /* some 150 times 1.9e-6 */
            {VR_CELLS_AVERAGE, VR_CELLS_EXACT, 2e-4}}; /* depth^2 / 12 of the colour's change, summed */
        for (int i = 0; i < 5; i++) {
            assert_int_equal(brick_image_compare(&image[pairs[i].a], &image[pairs[i].b], &d, NULL), 0);
            print_message("integration %d and %d: %.2g\n", pairs[i].a, pairs[i].b, d.max_abs);
            assert_true(d.max_abs < pairs[i].limit && d.max_abs > 0.0);
        }
        for (int i = 0; i < VR_CELLS_INTEGRATIONS; i++)
            brick_image_finish(&image[i]);
        brick_transfer_destroy(&transfer);
    }
    fixture_finish(&f);
}

static void refuse(const struct fixture *f, int code, const char *mention)
{
    struct brick_error err = {0};
    struct brick_image image;
    assert_int_equal(brick_image_init(&image, f->scene.width, f->scene.height, &err), 0);
    assert_int_equal(vr_render(f->renderer, &f->scene, &f->quality, &image, NULL, &err), code);
    assert_non_null(strstr(err.message, mention));
    brick_image_finish(&image);
}

static void test_refusals(void **state)
{
    static float voxels[NX * NY * NZ];
    struct fixture f;
    (void)state;
    fixture_init(&f, BRICK_I16, voxels);
    if (f.renderer) {
        f.scene.mode = BRICK_MODE_SHADED;
        refuse(&f, BRICK_ERR_UNSUPPORTED, "dvr only");
        f.scene.mode = BRICK_MODE_DVR;
        f.scene.camera.ortho_height_mm = 0.0;
        f.scene.camera.fov_deg = 30.0;
        refuse(&f, BRICK_ERR_UNSUPPORTED, "parallel projection");
        f.scene.camera.ortho_height_mm = 70.0;
        f.quality.cells_integration = VR_CELLS_INTEGRATIONS;
        refuse(&f, BRICK_ERR_ARGUMENT, "integration");
    }
    fixture_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types),    cmocka_unit_test(test_thin_and_levels),
        cmocka_unit_test(test_clip),     cmocka_unit_test(test_nonfinite),
        cmocka_unit_test(test_memory),   cmocka_unit_test(test_integrations),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests_name("cells", tests, NULL, NULL);
}
