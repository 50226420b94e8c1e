/* The light on vr_render_isotrace's surfaces and meshes, and their shadows, against closed forms. */
#include "isotrace_setting.h"

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

/* From the front at an elevation, the picture so many mm high and `size` pixels; without highlights, the
 * light from above. */
static void render_from_above(const struct brick_volume *volume, double elevation, double height,
                              uint32_t size, struct vr_scene *scene, struct vr_isotrace_params *params,
                              struct brick_view *view, struct brick_image *image)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    *params = vr_isotrace_defaults;
    params->shadows = params->lit = true;
    params->light[2] = 2.0;
    scene->width = scene->height = size;
    scene->specular = 0.0;
    brick_camera_orbit(&scene->camera, grid, 0, elevation, 0, height, 1.0);
    render(volume, &vr_isotracer_defaults, scene, params, image, NULL);
    assert_int_equal(brick_view_init(view, &scene->camera, grid, size, size, NULL), BRICK_OK);
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
    struct vr_isotrace_params params;
    struct vr_scene scene = vr_scene_defaults;
    struct brick_image image;
    struct brick_view view;
    render_from_above(volume, 50, 64, W, &scene, &params, &view, &image);
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
    struct vr_isotrace_params params;
    struct vr_scene scene = vr_scene_defaults;
    struct brick_image image;
    struct brick_view view;
    scene.meshes = &meshes;
    scene.mesh_count = 1;
    render_from_above(volume, 40, 90, W, &scene, &params, &view, &image);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shading_in_closed_form),
        cmocka_unit_test(a_sphere_shades_another),
        cmocka_unit_test(meshes_and_surfaces_shade_each_other),
    };
    return cmocka_run_group_tests_name("isotrace_light", tests, NULL, NULL);
}
