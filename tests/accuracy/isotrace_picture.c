/* vr_render_isotrace from file to picture: the same bytes whatever the bricks, the cache, the threads, the
 * skipping and the order of voxels; opacity against closed forms, cuts against the exact picture; and what it
 * refuses. */
#include "isotrace_setting.h"

enum { N = 70, BODY = N * N * N };

/* Two blobs and some noise, oblique, with half as many voxels again on one axis' length. */
static struct brick_volume *make_body(uint32_t edge, uint32_t macrocell, bool with_nan)
{
    static float voxels[BODY];
    struct memory_source source;
    struct brick_build_params params = brick_build_defaults;
    for (int i = 0; i < BODY; i++) {
        double x = i % N, y = i / N % N, z = i / (N * N);
        double a = sqrt(pow(x - 25, 2) + pow(y - 30, 2) + pow(z - 35, 2));
        double b = sqrt(pow(x - 50, 2) + pow(y - 40, 2) + pow(z - 30, 2));
        voxels[i] = (float)(fmax(25 - a, 15 - b) + (double)(noise64(1, (uint64_t)i) % 1000) * 3e-3);
        if (with_nan && noise64(2, (uint64_t)i) % 400 == 0)
            voxels[i] = NAN;
    }
    memory_source_init(&source, BRICK_F32, N, N, N, voxels);
    const double affine[3][4] = {{0.8, -0.35, 0.1, -40}, {0.6, 0.75, -0.2, 7}, {0.05, 0.2, 1.6, 300}};
    memcpy(source.base.geometry.affine, affine, sizeof affine);
    params.edge = edge;
    params.macrocell = macrocell;
    return build_and_open(&source, "body.brick", &params);
}

static void same_bytes_whatever_the_memory(void **state)
{
    static const struct {
        uint32_t edge, macrocell;
        unsigned threads, bricks; /* in the cache; 0: all */
        bool skip;
        enum vr_iso_layout layout;
    } variants[] = {
        {32, 8, 1, 0, true, VR_ISO_BRICKS},  {16, 8, 2, 0, true, VR_ISO_BRICKS},
        {64, 16, 3, 0, true, VR_ISO_BRICKS}, {32, 4, 2, 0, true, VR_ISO_BRICKS},
        {32, 8, 5, 1, true, VR_ISO_BRICKS},  {16, 4, 5, 8, true, VR_ISO_BRICKS},
        {8, 8, 2, 0, true, VR_ISO_BRICKS},   {32, 8, 2, 0, false, VR_ISO_BRICKS},
        {32, 8, 2, 0, true, VR_ISO_TILED},   {16, 8, 2, 0, false, VR_ISO_TILED},
        {32, 8, 2, 0, false, VR_ISO_FLAT},
    };
    const struct vr_iso_surface surfaces[] = {
        {2.0, {0.9, 0.2, 0.1}, 0.3}, {9.0, {0.1, 0.8, 0.2}, 0.5}, {20.0, {0.2, 0.3, 0.9}, 1.0}};
    (void)state;
    for (int picture = 0; picture < 6; picture++) {
        struct brick_image first = {0};
        for (size_t i = 0; i < sizeof variants / sizeof variants[0]; i++) {
            struct brick_volume *volume = make_body(variants[i].edge, variants[i].macrocell, picture % 2);
            const struct brick_grid *grid = brick_volume_grid(volume);
            struct vr_isotracer_params tracer = vr_isotracer_defaults;
            struct vr_isotrace_params params = vr_isotrace_defaults;
            struct vr_scene scene = vr_scene_defaults;
            struct vr_report report;
            struct brick_image image;
            scene.width = 75;
            scene.height = 50;
            scene.level = picture == 2;
            tracer.threads = variants[i].threads;
            tracer.layout = variants[i].layout;
            if (variants[i].bricks)
                tracer.host_cache_bytes = variants[i].bricks * brick_grid_max_payload_bytes(grid);
            params.surfaces = surfaces;
            params.surface_count = 3;
            params.shadows = picture != 0;
            params.skip = variants[i].skip;
            /* 3: the rays of the middle row and column lie in faces of cells and bricks */
            brick_camera_orbit(&scene.camera, grid, picture == 3 ? 0 : 30, picture == 3 ? 0 : 20, 0,
                               picture == 4 ? 90 : 0, 1.5);
            if (picture == 4) /* half of it is cut away, obliquely */
                clip_through(&scene, scene.camera.look_mm, 0.3, 1.0, -0.2);
            if (picture == 5) /* inside */
                for (int a = 0; a < 3; a++)
                    scene.camera.eye_mm[a] = scene.camera.look_mm[a] + (a == 1 ? 2.0 : 0.0);
            render(volume, &tracer, &scene, &params, &image, &report);
            assert_true(report.samples > 0 && report.bricks_active > 0);
            if (!first.rgba) {
                first = image;
            } else {
                assert_memory_equal(first.rgba, image.rgba, 75 * 50 * 4 * sizeof(float));
                brick_image_finish(&image);
            }
            brick_volume_close(&volume);
        }
        brick_image_finish(&first);
    }
}

/* A ramp along y seen along y: each surface is a plane that faces the eye. */
static void opacity_in_closed_form(void **state)
{
    static uint8_t voxels[16 * 16 * 16];
    const struct vr_iso_surface surfaces[] = {/* not in their order on the ray */
                                              {12.5, {0.1, 0.2, 0.9}, 0.75},
                                              {3.0, {0.8, 0.3, 0.1}, 0.5},
                                              {7.25, {0.2, 0.9, 0.4}, 0.25}};
    const int order[] = {1, 2, 0};
    struct memory_source source;
    (void)state;
    for (int i = 0; i < 4096; i++)
        voxels[i] = (uint8_t)(i / 16 % 16);
    memory_source_init(&source, BRICK_U8, 16, 16, 16, voxels);
    struct brick_volume *volume = build_and_open(&source, "ramp.brick", NULL);
    struct vr_isotrace_params params = vr_isotrace_defaults;
    struct vr_scene scene = vr_scene_defaults;
    struct brick_image image;
    scene.width = scene.height = 8;
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 0, 0, 0, 10, 1.0);
    params.surfaces = surfaces;
    params.surface_count = 3;
    render(volume, &vr_isotracer_defaults, &scene, &params, &image, NULL);
    double expect[4] = {0, 0, 0, 0}, through = 1.0;
    for (int k = 0; k < 3; k++) {
        const struct vr_iso_surface *s = &surfaces[order[k]];
        for (int c = 0; c < 3; c++) /* facing 1: ambient 0.2, diffuse 0.7, specular 0.3 */
            expect[c] += through * s->opacity * (0.9 * s->rgb[c] + 0.3);
        through *= 1.0 - s->opacity;
    }
    expect[3] = 1.0 - through;
    for (int i = 0; i < 8 * 8 * 4; i++)
        assert_true(fabs((double)image.rgba[i] - expect[i % 4]) < 2e-7);
    brick_image_finish(&image);
    /* The ray ends behind the second surface: half of 0.75 gets through, and no more than 0.4 may. */
    params.termination = 0.4;
    render(volume, &vr_isotracer_defaults, &scene, &params, &image, NULL);
    assert_true(fabs((double)image.rgba[3] - 0.625) < 1e-7);
    brick_image_finish(&image);
    brick_volume_close(&volume);
}
/* Planes and meshes cut rays where they cut the exact method's, and surfaces have no caps there. */
static void cut_as_in_the_exact_picture(void **state)
{
    enum { W = 90 };
    struct brick_volume *volume = make_body(32, 8, false);
    struct brick_mesh squares = {0};
    const struct vr_mesh mesh = {&squares, {0.2, 0.6, 0.9}};
    (void)state;
    for (int k = 0; k < 3; k++) /* through the body, and beside it */
        add_square(&squares, -20.0 + 25.0 * k, 30.0, 330.0 + 13.0 * k, 9.0 + 30.0 * (k == 1));
    for (int run = 0; run < 8; run++) {
        const int cuts = run % 4;
        struct vr_isotrace_params params = vr_isotrace_defaults;
        struct vr_scene scene = vr_scene_defaults;
        struct brick_image image, exact, whole;
        size_t hits = 0, differing = 0;
        scene.mode = BRICK_MODE_ISO;
        scene.isovalue = 6.3;
        scene.width = scene.height = W;
        brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 40, 25, 0, cuts == 3 ? 120 : 0, 1.0);
        const double *middle = scene.camera.look_mm;
        scene.meshes = &mesh;
        scene.mesh_count = run / 4;
        render(volume, &vr_isotracer_defaults, &scene, &params, &whole, NULL);
        if (cuts >= 1) /* towards the eye and across: the inside of the shell is seen */
            clip_through(&scene, middle, -0.6, 0.7, 0.1);
        if (cuts >= 2) { /* a slab */
            clip_through(&scene, middle, 0.1, 0.2, 1.0);
            clip_through(&scene, (double[3]){middle[0], middle[1], middle[2] + 9.0}, -0.1, -0.2, -1.0);
        }
        render(volume, &vr_isotracer_defaults, &scene, &params, &image, NULL);
        assert_int_equal(brick_image_init(&exact, W, W, NULL), BRICK_OK);
        assert_int_equal(vr_render_exact(volume, &scene, &vr_exact_defaults, &exact, NULL, NULL), BRICK_OK);
        for (size_t i = 0; i < 4 * W * W; i++) {
            assert_true(fabs((double)image.rgba[i] - (double)exact.rgba[i]) < 2e-6);
            hits += i % 4 == 3 && image.rgba[i] > 0.0f;
            differing += image.rgba[i] != whole.rgba[i];
        }
        print_message("%d meshes, %d cuts: %zu pixels hit, %zu channels differ from the whole\n", run / 4,
                      cuts, hits, differing);
        assert_true(hits > 100);
        assert_true(cuts ? differing > 1000 : differing == 0);
        brick_image_finish(&image);
        brick_image_finish(&exact);
        brick_image_finish(&whole);
    }
    brick_volume_close(&volume);
    brick_mesh_finish(&squares);
}

static void bad_requests_are_refused(void **state)
{
    struct brick_volume *volume = make_body(32, 8, false);
    const struct vr_iso_surface good = {5.0, {1, 1, 1}, 1.0};
    struct vr_isotracer *tracer;
    struct brick_image image;
    struct brick_error err;
    (void)state;
    const struct vr_isotracer_params none = {.host_cache_bytes = 1000};
    assert_int_equal(vr_isotracer_create(&tracer, volume, &none, &err), BRICK_ERR_ARGUMENT);
    assert_null(tracer);
    assert_int_equal(vr_isotracer_create(&tracer, volume, &vr_isotracer_defaults, &err), BRICK_OK);
    assert_int_equal(brick_image_init(&image, 8, 8, NULL), BRICK_OK);
    for (int kind = 0; kind < 9; kind++) {
        struct vr_iso_surface surface = good;
        struct vr_isotrace_params params = vr_isotrace_defaults;
        struct vr_scene scene = vr_scene_defaults;
        scene.width = scene.height = 8;
        brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 0, 0, 0, 0, 1.0);
        params.surfaces = &surface;
        params.surface_count = 1;
        switch (kind) {
        case 0:
            break;
        case 1:
            scene.level = brick_volume_grid(volume)->levels;
            break;
        case 2:
            scene.width = 9;
            break;
        case 3:
            surface.opacity = 1.5;
            break;
        case 4:
            surface.isovalue = NAN;
            break;
        case 5:
            params.surface_count = VR_ISO_MAX_SURFACES + 1;
            break;
        case 6:
            params.lit = true; /* in no direction */
            break;
        case 7:
            params.termination = 1.0;
            break;
        default:
            memcpy(scene.camera.look_mm, scene.camera.eye_mm, sizeof scene.camera.look_mm);
        }
        err = (struct brick_error){0};
        int code = vr_render_isotrace(tracer, &scene, &params, &image, NULL, &err);
        assert_int_equal(code, kind ? BRICK_ERR_ARGUMENT : BRICK_OK);
        assert_int_equal(err.code, code);
    }
    brick_image_finish(&image);
    vr_isotracer_destroy(&tracer);
    brick_volume_close(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_bytes_whatever_the_memory),
        cmocka_unit_test(opacity_in_closed_form),
        cmocka_unit_test(cut_as_in_the_exact_picture),
        cmocka_unit_test(bad_requests_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
