/* vr_render_isotrace from file to picture: the same bytes whatever the bricks, the cache, the threads, the
 * skipping and the order of voxels; opacity, shading and shadows against closed forms; and what it refuses.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <renderer/renderer.h>

#include "../support/memory_source.h"

/* Twice: the second frame knows where in the bricks surfaces are, and a frame of other surfaces in between
 * leaves nothing behind. */
static void render(const struct brick_volume *volume, const struct vr_isotracer_params *tracer_params,
                   const struct vr_scene *scene, const struct vr_isotrace_params *params,
                   struct brick_image *image, struct vr_report *report)
{
    struct vr_isotracer *tracer;
    struct brick_error err;
    struct vr_scene other = *scene;
    struct vr_isotrace_params one = *params;
    struct brick_image again;
    other.isovalue += 1.5;
    one.surface_count = 0;
    assert_int_equal(brick_image_init(image, scene->width, scene->height, NULL), BRICK_OK);
    assert_int_equal(brick_image_init(&again, scene->width, scene->height, NULL), BRICK_OK);
    if (vr_isotracer_create(&tracer, volume, tracer_params, &err) ||
        vr_render_isotrace(tracer, scene, params, image, report, &err))
        fail_msg("%s", err.message);
    for (int frame = 0; frame < 4; frame++) {
        if (vr_render_isotrace(tracer, frame == 1 ? &other : scene, frame == 1 ? &one : params, &again, NULL,
                               &err))
            fail_msg("%s", err.message);
        if (frame != 1)
            assert_memory_equal(image->rgba, again.rgba,
                                (size_t)scene->width * scene->height * 4 * sizeof(float));
    }
    brick_image_finish(&again);
    vr_isotracer_destroy(&tracer);
}

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

/* Keep what lies from a point on in a direction. */
static void clip_through(struct vr_scene *scene, const double point[3], double x, double y, double z)
{
    scene->clip[scene->clip_count++] =
        (struct vr_plane){{x, y, z}, x * point[0] + y * point[1] + z * point[2]};
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

/* An oblique plane of an oblique volume: the normal goes by the inverse transpose, and shading.glsl's formula
 * holds. A light at the eye given as a direction is the headlight. */
static void shading_in_closed_form(void **state)
{
    static float voxels[24 * 24 * 24];
    struct memory_source source;
    (void)state;
    for (int i = 0; i < 24 * 24 * 24; i++)
        voxels[i] = (float)(i % 24 + 2 * (i / 24 % 24) - (i / 576));
    memory_source_init(&source, BRICK_F32, 24, 24, 24, voxels);
    const double affine[3][4] = {{0.9, 0, 0.3, 0}, {0, 0.7, 0, 0}, {0, 0, 1.5, 0}};
    memcpy(source.base.geometry.affine, affine, sizeof affine);
    struct brick_volume *volume = build_and_open(&source, "plane.brick", NULL);
    struct vr_isotrace_params params = vr_isotrace_defaults;
    struct vr_scene scene = vr_scene_defaults;
    struct brick_image image;
    scene.isovalue = 23.0;
    scene.width = scene.height = 3;
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 25, 15, 0, 2, 1.0);
    double inverse[3][4], n[3], view[3], nn = 0, vv = 0, nv = 0;
    brick_affine_invert(affine, inverse);
    for (int i = 0; i < 3; i++) {
        n[i] = inverse[0][i] + 2 * inverse[1][i] - inverse[2][i];
        view[i] = scene.camera.look_mm[i] - scene.camera.eye_mm[i];
        nn += n[i] * n[i];
        vv += view[i] * view[i];
        nv += n[i] * view[i];
        params.light[i] = -view[i];
    }
    double facing = fabs(nv) / sqrt(nn * vv);
    assert_true(facing > 0.2 && facing < 0.98);
    for (int lit = 0; lit < 2; lit++) {
        params.lit = lit;
        render(volume, &vr_isotracer_defaults, &scene, &params, &image, NULL);
        for (int i = 0; i < 9; i++) {
            assert_true(image.rgba[4 * i + 3] == 1.0f);
            for (int c = 0; c < 3; c++)
                assert_true(fabs((double)image.rgba[4 * i + c] -
                                 (scene.iso_rgb[c] * (0.2 + 0.7 * facing) + 0.3 * pow(facing, 20.0))) < 1e-6);
        }
        brick_image_finish(&image);
    }
    brick_volume_close(&volume);
}

/* A small sphere between a large one and the light, both of distances, so hits are off by less than 0.1
 * voxel. */
static void a_sphere_shades_another(void **state)
{
    enum { S = 64, W = 60 };
    static float voxels[S * S * S];
    const double big[3] = {31.5, 31.5, 20}, small[3] = {31.5, 31.5, 50}, r_big = 17, r_small = 6,
                 margin = 0.3;
    struct memory_source source;
    int dark = 0, bright = 0;
    (void)state;
    for (int i = 0; i < S * S * S; i++) {
        double x = i % S, y = i / S % S, z = i / (S * S);
        double a = sqrt(pow(x - big[0], 2) + pow(y - big[1], 2) + pow(z - big[2], 2));
        double b = sqrt(pow(x - small[0], 2) + pow(y - small[1], 2) + pow(z - small[2], 2));
        voxels[i] = (float)fmax(r_big - a, r_small - b);
    }
    memory_source_init(&source, BRICK_F32, S, S, S, voxels);
    struct brick_volume *volume = build_and_open(&source, "spheres.brick", NULL);
    struct vr_isotrace_params params = vr_isotrace_defaults;
    struct vr_scene scene = vr_scene_defaults;
    struct brick_image image;
    struct brick_view view;
    scene.width = scene.height = W;
    scene.specular = 0.0;
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 0, 50, 0, 64, 1.0);
    params.shadows = params.lit = true;
    params.light[2] = 2.0;
    render(volume, &vr_isotracer_defaults, &scene, &params, &image, NULL);
    assert_int_equal(brick_view_init(&view, &scene.camera, brick_volume_grid(volume), W, W, NULL), BRICK_OK);
    for (uint32_t i = 0; i < W * W; i++) {
        struct brick_ray ray;
        double od = 0, oo = 0, sd = 0, ss = 0, p[3];
        brick_view_ray(&view, i % W, i / W, &ray);
        for (int k = 0; k < 3; k++) {
            od += (ray.origin[k] - big[k]) * ray.direction[k];
            oo += pow(ray.origin[k] - big[k], 2);
            sd += (ray.origin[k] - small[k]) * ray.direction[k];
            ss += pow(ray.origin[k] - small[k], 2);
        }
        double disc = od * od - oo + r_big * r_big;
        if (disc < 4.0 || sd * sd - ss + pow(r_small + 1, 2) > 0.0)
            continue; /* no hit on the large one, or not clearly */
        for (int k = 0; k < 3; k++)
            p[k] = ray.origin[k] + (-od - sqrt(disc)) * ray.direction[k];
        double facing = (p[2] - big[2]) / r_big, off = hypot(p[0] - small[0], p[1] - small[1]);
        double red = (double)image.rgba[4 * i], ambient = 0.2 * scene.iso_rgb[0];
        if (facing > 0.1 && off < r_small - margin) {
            assert_true(fabs(red - ambient) < 1e-6);
            dark++;
        } else if (facing > 0.1 && off > r_small + margin) {
            assert_true(fabs(red - ambient - 0.7 * facing * scene.iso_rgb[0]) < 0.03);
            bright++;
        } else if (facing < -0.1) {
            assert_true(fabs(red - ambient) < 1e-6); /* turned away */
        }
    }
    assert_true(dark > 50 && bright > 200);
    /* What is cut away casts no shadow: with the plane between the two the large one is as if it were alone.
     */
    struct brick_image alone;
    for (int i = 0; i < S * S * S; i++) {
        double x = i % S, y = i / S % S, z = i / (S * S);
        voxels[i] = (float)(r_big - sqrt(pow(x - big[0], 2) + pow(y - big[1], 2) + pow(z - big[2], 2)));
    }
    struct brick_volume *single = build_and_open(&source, "sphere.brick", NULL);
    clip_through(&scene, (double[3]){0, 0, 40}, 0, 0, -1);
    brick_image_finish(&image);
    render(volume, &vr_isotracer_defaults, &scene, &params, &image, NULL);
    scene.clip_count = 0;
    render(single, &vr_isotracer_defaults, &scene, &params, &alone, NULL);
    assert_memory_equal(image.rgba, alone.rgba, W * W * 4 * sizeof(float));
    brick_image_finish(&alone);
    brick_volume_close(&single);
    brick_image_finish(&image);
    brick_volume_close(&volume);
}

static void add_square(struct brick_mesh *mesh, double x, double y, double z, double half)
{
    const uint64_t first = mesh->vertices, corners[4] = {first, first + 1, first + 2, first + 3};
    for (int k = 0; k < 4; k++)
        assert_int_equal(brick_mesh_add_vertex(mesh,
                                               (const double[]){x + (k == 1 || k == 2 ? half : -half),
                                                                y + (k > 1 ? half : -half), z},
                                               NULL, NULL, NULL),
                         0);
    assert_int_equal(brick_mesh_add_polygon(mesh, corners, 4, NULL), 0);
}

/* A square above a sphere, both above a floor, the light from above: the square's shadow on the sphere, and
 * both shadows on the floor. The surface is less than 0.1 voxel off. */
static void meshes_and_surfaces_shade_each_other(void **state)
{
    enum { S = 64, W = 90 };
    static float voxels[S * S * S];
    const double middle[3] = {31.5, 31.5, 20}, r = 12, half = 7, floor_z = 1, above = 50, aside = 10,
                 margin = 0.3;
    struct memory_source source;
    struct brick_mesh mesh = {0};
    int count[5] = {0}; /* sphere: dark, bright; floor: bright, the square's shadow, the sphere's */
    (void)state;
    for (int i = 0; i < S * S * S; i++)
        voxels[i] = (float)(r - sqrt(pow(i % S - middle[0], 2) + pow(i / S % S - middle[1], 2) +
                                     pow(i / (S * S) - middle[2], 2)));
    memory_source_init(&source, BRICK_F32, S, S, S, voxels);
    add_square(&mesh, middle[0] + aside, middle[1], above, half);
    add_square(&mesh, middle[0], middle[1], floor_z, 200.0);
    const struct vr_mesh meshes = {&mesh, {0.2, 0.6, 0.9}};
    struct brick_volume *volume = build_and_open(&source, "spheres.brick", NULL);
    struct vr_isotrace_params params = vr_isotrace_defaults;
    struct vr_scene scene = vr_scene_defaults;
    struct brick_image image;
    struct brick_view view;
    scene.width = scene.height = W;
    scene.specular = 0.0;
    scene.meshes = &meshes;
    scene.mesh_count = 1;
    brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 0, 40, 0, 90, 1.0);
    params.shadows = params.lit = true;
    params.light[2] = 2.0;
    render(volume, &vr_isotracer_defaults, &scene, &params, &image, NULL);
    assert_int_equal(brick_view_init(&view, &scene.camera, brick_volume_grid(volume), W, W, NULL), BRICK_OK);
    for (uint32_t i = 0; i < W * W; i++) {
        struct brick_ray ray;
        double od = 0, oo = 0, p[3], q[3];
        const double red = (double)image.rgba[4 * i];
        brick_view_ray(&view, i % W, i / W, &ray);
        for (int k = 0; k < 3; k++) {
            od += (ray.origin[k] - middle[k]) * ray.direction[k];
            oo += pow(ray.origin[k] - middle[k], 2);
        }
        assert_true(image.rgba[4 * i + 3] == 1.0f); /* the floor is everywhere */
        for (int k = 0; k < 3; k++) {
            p[k] = ray.origin[k] + (above - ray.origin[2]) / ray.direction[2] * ray.direction[k];
            q[k] = ray.origin[k] + (floor_z - ray.origin[2]) / ray.direction[2] * ray.direction[k];
        }
        if (fabs(p[0] - middle[0] - aside) < half + 0.01 && fabs(p[1] - middle[1]) < half + 0.01)
            continue; /* the square itself */
        const double disc = od * od - oo + r * r;
        const bool on_floor = disc < -4.0;
        if (!on_floor && disc < 4.0)
            continue;
        for (int k = 0; k < 3; k++)
            p[k] = on_floor ? q[k] : ray.origin[k] + (-od - sqrt(disc)) * ray.direction[k];
        const double facing = on_floor ? 1.0 : (p[2] - middle[2]) / r,
                     rgb = on_floor ? 0.2 : scene.iso_rgb[0];
        const double off = fmax(fabs(p[0] - middle[0] - aside), fabs(p[1] - middle[1])) - half;
        const double below = on_floor ? hypot(p[0] - middle[0], p[1] - middle[1]) - r : 1.0;
        if (fabs(off) < margin || fabs(below) < margin || facing < 0.1)
            continue;
        if (off < 0.0 || below < 0.0)
            assert_true(fabs(red - 0.2 * rgb) < 1e-6);
        else
            assert_true(fabs(red - (0.2 + 0.7 * facing) * rgb) < (on_floor ? 1e-6 : 0.03));
        count[!on_floor ? off > 0.0 : below < 0.0 ? 4 : off < 0.0 ? 3 : 2]++;
    }
    for (int k = 0; k < 5; k++) {
        print_message("%d pixels of kind %d\n", count[k], k);
        assert_true(count[k] > 20);
    }
    brick_image_finish(&image);
    brick_volume_close(&volume);
    brick_mesh_finish(&mesh);
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
        cmocka_unit_test(shading_in_closed_form),
        cmocka_unit_test(a_sphere_shades_another),
        cmocka_unit_test(meshes_and_surfaces_shade_each_other),
        cmocka_unit_test(cut_as_in_the_exact_picture),
        cmocka_unit_test(bad_requests_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
