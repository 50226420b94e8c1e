/* Slices: the picture depends on the volume and the scene only, whatever bricks, caches, skipping and the
 * order of drawing; it is right from inside and at clip planes; and ending early changes no channel by more
 * than it may. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "gl_scene.h"

#define NX   70
#define NY   61
#define NZ   83
#define SIZE 41

static const struct brick_transfer_point points[] = {
    {150, 0.2, 0.1, 0.1, 0.0}, {300, 0.9, 0.3, 0.1, 0.1}, {500, 0.1, 0.9, 0.1, 0.02}, {900, 1, 1, 0.9, 0.7}};
/* Peaks between transparent values, narrower than what a voxel's way changes. */
static const struct brick_transfer_point peaks[] = {
    {205, 1, 0, 0, 0.0},   {211, 0.9, 0.3, 0.1, 0.6}, {214, 0, 0, 1, 0.0}, {500.5, 0, 1, 0, 0.0},
    {500.5, 0, 1, 0, 0.8}, {503, 1, 1, 0, 0.2},       {503, 1, 1, 0, 0.0}};
static int16_t voxels[NX * NY * NZ];

/* Blobs in empty space, with some noise. */
static int16_t blobs(int i)
{
    double x = i % NX, y = i / NX % NY, z = i / NX / NY;
    double v = 1100.0 * sin(0.11 * x + 0.3) * sin(0.13 * y) * cos(0.09 * z) - 150.0;
    return (int16_t)(v < 0.0 ? 0.0 : v + (double)(noise64(3, (uint64_t)i) % 40));
}

/* Blocks from face to face of macrocells, in some bricks of 16: what shows between two values shows where a
 * slab leads out of a block, or into it, often into a brick where nothing shows, or not just there. */
static int16_t blocks(int i)
{
    const uint64_t x = (uint64_t)(i % NX), y = (uint64_t)(i / NX % NY), z = (uint64_t)(i / NX / NY);
    const bool brick = noise64(7, (z / 16 * 16 + y / 16) * 16 + x / 16) % 3;
    const bool block = noise64(8, (z / 8 * 32 + y / 8) * 32 + x / 8) % 2;
    const bool inside = x % 8 && y % 8 && z % 8;
    return brick && block && inside ? (int16_t)(900 + noise64(11, (uint64_t)i) % 100) : 0;
}

static void fill(struct memory_source *source, int16_t (*field)(int))
{
    for (int i = 0; i < NX * NY * NZ; i++)
        voxels[i] = field(i);
    memory_source_init(source, BRICK_I16, NX, NY, NZ, voxels);
    /* Voxels that are not cubes, and an axis that runs backwards. */
    source->base.geometry.affine[0][0] = -0.8;
    source->base.geometry.affine[2][2] = 1.3;
}

#define VIEWS 6
static void camera_of(int view, const struct brick_grid *grid, struct brick_camera *camera)
{
    const double *m[3] = {grid->affine[0], grid->affine[1], grid->affine[2]};
    brick_camera_orbit(camera, grid, 35, 25, 0, view == 1 ? 90 : 0, 1.0); /* 0, 1: oblique */
    if (view < 2)
        return;
    for (int a = 0; a < 3; a++) /* at a corner of bricks, looking at another */
        camera->look_mm[a] = m[a][a] * 32 + m[a][3];
    switch (view) {
    case 2: /* along edges of bricks, rays in their faces */
        for (int a = 0; a < 3; a++)
            camera->eye_mm[a] = camera->look_mm[a] - (a == 1 ? 200.0 : 0.0);
        camera->ortho_height_mm = 41 * 0.8;
        break;
    case 3: /* the diagonal through corners of bricks */
        for (int a = 0; a < 3; a++)
            camera->eye_mm[a] = camera->look_mm[a] - 100.0 * m[a][a];
        camera->ortho_height_mm = 80;
        break;
    case 4: /* inside, at a corner */
        for (int a = 0; a < 3; a++)
            camera->eye_mm[a] = camera->look_mm[a];
        camera->look_mm[1] -= 10.0;
        camera->fov_deg = 110.0;
        break;
    default: /* inside a brick, almost along an axis */
        for (int a = 0; a < 3; a++)
            camera->eye_mm[a] = m[a][a] * 40.3 + m[a][3];
        camera->look_mm[1] += 30.0;
        camera->fov_deg = 75.0;
    }
}

/* One oblique, one along a face of bricks. */
static void set_clip(struct vr_scene *scene)
{
    scene->clip[0] = (struct vr_plane){{0.3, -0.5, 0.4}, -12.0};
    scene->clip[1] = (struct vr_plane){{0.0, 0.0, -2.0}, -2.0 * 1.3 * 64};
    scene->clip_count = 2;
}

/* Kinds of slices: mode and what else may matter. From SLABS on pre-integrated. */
#define SLABS 8
#define KINDS 13
static void kind_of(int kind, struct vr_scene *scene, struct vr_quality *quality)
{
    static const enum brick_mode modes[KINDS] = {
        BRICK_MODE_DVR, BRICK_MODE_SHADED, BRICK_MODE_MIP,    BRICK_MODE_DVR, BRICK_MODE_DVR,
        BRICK_MODE_DVR, BRICK_MODE_DVR,    BRICK_MODE_SHADED, BRICK_MODE_DVR, BRICK_MODE_SHADED,
        BRICK_MODE_DVR, BRICK_MODE_SHADED, BRICK_MODE_SHADED};
    scene->mode = modes[kind];
    quality->method = VR_METHOD_SLICES;
    quality->slices.planes = 0;
    quality->step_vox = kind == 6 ? 40.0 : 0.7; /* a few slices, thicker than bricks */
    quality->slices.back_to_front = kind == 3 || kind == 11;
    if (kind == 4) {
        quality->classification = VR_CLASSIFY_PRE;
        quality->slices.classified_bits = 8;
        quality->slices.framebuffer = VR_FRAMEBUFFER_8;
    }
    if (kind == 5 || kind == 7) {
        quality->slices.interpolation = VR_INTERPOLATION_POINT;
        quality->slices.framebuffer = VR_FRAMEBUFFER_16F;
    }
    if (kind < SLABS)
        return;
    quality->classification = VR_CLASSIFY_PREINTEGRATED;
    quality->step_vox = 0.4;
    if (kind == 10)
        quality->slices.framebuffer = VR_FRAMEBUFFER_8;
    if (kind == 10 || kind == 12) /* as thick as they may be */
        quality->slices.planes = VR_PLANES_PAPER;
    if (kind == 12)
        quality->slices.interpolation = VR_INTERPOLATION_POINT;
    if (kind == 10 || kind == 11)
        set_clip(scene);
}

static void draw_all(struct vr_renderer *renderer, const struct brick_grid *grid,
                     const struct brick_transfer *transfer, int from, int to, bool skip,
                     struct brick_image *images, bool first, const char *what)
{
    for (int kind = from; kind < to; kind++)
        for (int view = 0; view < VIEWS; view++) {
            struct vr_scene scene = vr_scene_defaults;
            struct vr_quality quality = vr_quality_defaults;
            struct brick_image image, *kept = &images[kind * VIEWS + view];
            char line[160];
            kind_of(kind, &scene, &quality);
            quality.skip = skip;
            scene.transfer = transfer;
            scene.width = scene.height = SIZE;
            camera_of(view, grid, &scene.camera);
            render(renderer, &scene, &quality, first ? kept : &image, NULL);
            if (first)
                continue;
            snprintf(line, sizeof line, "%s, kind %d, view %d", what, kind, view);
            assert_same_image(&image, kept, line);
            brick_image_finish(&image);
        }
}

/* Kinds `from` up to `to`. */
static void check(int16_t (*field)(int), struct brick_transfer *transfer, int from, int to)
{
    static const uint32_t edges[] = {16, 32, 64};
    struct brick_image images[KINDS * VIEWS] = {{0}};
    struct memory_source source;
    bool drawn = false;
    fill(&source, field);
    for (int e = 0; e < 3; e++) {
        struct brick_volume *volume = volume_of(&source, edges[e]);
        for (int kind = 0; kind < 4; kind++) { /* plenty, no skipping, little memory, OSMesa */
            struct vr_renderer_params params = vr_renderer_defaults;
            char line[64];
            if (kind == 2) /* room for a few bricks of colours, 4 bytes a voxel */
                params.gpu_cache_bytes = slots_bytes(volume, edges[e] == 64 ? 2 : 16);
            if (kind == 3 && e > 0)
                continue;
            if (kind == 3)
                params.context = VR_CONTEXT_OSMESA;
            struct vr_renderer *renderer = renderer_of(volume, &params);
            if (!renderer)
                continue;
            snprintf(line, sizeof line, "bricks of %u, way %d", edges[e], kind);
            draw_all(renderer, brick_volume_grid(volume), transfer, from, to, kind != 1, images, !drawn,
                     line);
            drawn = true;
            vr_renderer_destroy(&renderer);
        }
        brick_volume_close(&volume);
    }
    brick_transfer_destroy(&transfer);
    for (int i = 0; i < KINDS * VIEWS; i++)
        brick_image_finish(&images[i]);
    if (!drawn)
        skip();
}

static void bricks_and_caches(void **state)
{
    (void)state;
    check(blobs, transfer_of(points, 4), 0, SLABS);
}

static void slabs_from_brick_to_brick(void **state)
{
    (void)state;
    check(blocks, transfer_of(peaks, sizeof peaks / sizeof *peaks), SLABS, KINDS);
}

/* Lit slabs read bricks around visible ones, and those around these never. */
static void reads_no_more(void **state)
{
    struct memory_source source;
    (void)state;
    fill(&source, blocks);
    for (int i = 0; i < NX * NY * NZ / 2; i++)
        voxels[i] = 0;
    struct brick_volume *volume = volume_of(&source, 16);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    struct brick_transfer *transfer = transfer_of(peaks, sizeof peaks / sizeof *peaks);
    for (int turn = 0; turn < 3 && renderer; turn++) {
        struct vr_scene scene = vr_scene_defaults;
        struct vr_quality quality = vr_quality_defaults;
        struct brick_image image;
        struct vr_report report;
        kind_of(SLABS + 1, &scene, &quality);
        scene.transfer = transfer;
        scene.width = scene.height = SIZE;
        camera_of(0, brick_volume_grid(volume), &scene.camera);
        render(renderer, &scene, &quality, &image, &report);
        brick_image_finish(&image);
        if (turn)
            assert_true(report.bricks_loaded == 0);
        else
            assert_true(report.bricks_loaded > report.bricks_active &&
                        report.bricks_loaded < report.bricks_total);
    }
    end_or_skip(&renderer, &transfer, &volume);
}

/* Against exact, from everywhere and with clip planes: second order, and as wrong as that at most. Steps of
 * `longest` voxel edges, and its halves. */
static void check_order(enum vr_classification classification, double longest)
{
    struct memory_source source;
    struct brick_error err = {0};
    fill(&source, blobs);
    struct brick_volume *volume = volume_of(&source, 16);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    struct brick_transfer *transfer = transfer_of(points, 4);
    for (int round = 0; round < 2 * VIEWS && renderer; round++) {
        const int view = round % VIEWS;
        struct vr_scene scene = vr_scene_defaults;
        struct vr_quality quality = vr_quality_defaults;
        struct brick_image exact, image;
        struct brick_image_difference d;
        double rmse[4];
        scene.transfer = transfer;
        scene.width = scene.height = SIZE;
        camera_of(view, brick_volume_grid(volume), &scene.camera);
        if (round >= VIEWS)
            set_clip(&scene);
        assert_int_equal(brick_image_init(&exact, SIZE, SIZE, &err), 0);
        if (vr_render_exact(volume, &scene, &vr_exact_defaults, &exact, NULL, &err))
            fail_msg("%s", err.message);
        for (int i = 0; i < 4; i++) {
            quality.method = VR_METHOD_SLICES;
            quality.termination = 0.0;
            quality.slices.planes = 0;
            quality.classification = classification;
            quality.step_vox = ldexp(longest, -i);
            render(renderer, &scene, &quality, &image, NULL);
            assert_int_equal(brick_image_compare(&image, &exact, &d, &err), 0);
            brick_image_finish(&image);
            rmse[i] = d.rmse;
        }
        brick_image_finish(&exact);
        print_message("view %d%s: rmse %.2e %.2e %.2e %.2e\n", view, scene.clip_count ? ", clipped" : "",
                      rmse[0], rmse[1], rmse[2], rmse[3]);
        /* Kinks at cell faces and control points leave some of the factor of 4 a halving to chance. */
        assert_true(rmse[0] / rmse[3] > 27.0);
        assert_true(rmse[3] < 1e-3);
    }
    end_or_skip(&renderer, &transfer, &volume);
}

static void converges(void **state)
{
    (void)state;
    check_order(VR_CLASSIFY_POST, 1.0);
}

/* From view 4 slanted rays pass a voxel between slices that far apart. */
static void slabs_converge(void **state)
{
    (void)state;
    check_order(VR_CLASSIFY_PREINTEGRATED, 0.44);
}

/* Rays that end early, and bricks that are then hidden. */
static void ends_early(void **state)
{
    static const double thresholds[] = {1e-4, 1e-2, 0.3};
    struct memory_source source;
    struct brick_error err = {0};
    (void)state;
    fill(&source, blobs);
    struct brick_volume *volume = volume_of(&source, 16);
    struct vr_renderer *renderer = try_renderer(volume, VR_CONTEXT_AUTO);
    struct brick_transfer *transfer = transfer_of(points, 4);
    for (int i = 0; i < 3 && renderer; i++) {
        struct vr_scene scene = vr_scene_defaults;
        struct vr_quality quality = vr_quality_defaults;
        struct brick_image image, whole;
        struct brick_image_difference d;
        struct vr_report report, all;
        scene.transfer = transfer;
        scene.width = scene.height = SIZE;
        camera_of(0, brick_volume_grid(volume), &scene.camera);
        quality.method = VR_METHOD_SLICES;
        quality.slices.planes = 1000;
        quality.termination = 0.0;
        render(renderer, &scene, &quality, &whole, &all);
        quality.termination = thresholds[i];
        render(renderer, &scene, &quality, &image, &report);
        assert_int_equal(brick_image_compare(&image, &whole, &d, &err), 0);
        print_message("%g: %g off, %llu of %llu samples\n", thresholds[i], d.max_abs,
                      (unsigned long long)report.samples, (unsigned long long)all.samples);
        assert_true(d.max_abs <= thresholds[i]);
        assert_true(report.samples < all.samples);
        brick_image_finish(&image);
        brick_image_finish(&whole);
    }
    end_or_skip(&renderer, &transfer, &volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bricks_and_caches), cmocka_unit_test(slabs_from_brick_to_brick),
        cmocka_unit_test(reads_no_more),     cmocka_unit_test(converges),
        cmocka_unit_test(slabs_converge),    cmocka_unit_test(ends_early),
    };
    return cmocka_run_group_tests_name("slices_invariance", tests, NULL, NULL);
}
