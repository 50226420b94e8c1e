/* Opaque meshes in the raycaster, with OpenGL and without, and in isotrace, against the exact pictures, and
 * with clip planes too. */
#include "cut_setting.h"

/* A sphere of 2 n x n quadrangles, halved, with normals and colours if wanted. */
static void make_sphere(struct brick_mesh *mesh, const double centre[3], double radius, int n, bool rich)
{
    *mesh = (struct brick_mesh){0};
    for (int i = 0; i <= n; i++)
        for (int j = 0; j < 2 * n; j++) {
            double a = M_PI * i / n, b = M_PI * j / n, at[3];
            const double normal[3] = {sin(a) * cos(b), sin(a) * sin(b), cos(a)};
            const double colour[3] = {0.5 + 0.5 * sin(5 * b), 0.5 + 0.5 * cos(7 * a), 0.3};
            for (int k = 0; k < 3; k++)
                at[k] = centre[k] + radius * normal[k];
            assert_int_equal(
                brick_mesh_add_vertex(mesh, at, rich ? normal : NULL, rich ? colour : NULL, NULL), 0);
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < 2 * n; j++) {
            uint64_t p = (uint64_t)(i * 2 * n + j), q = (uint64_t)(i * 2 * n + (j + 1) % (2 * n));
            uint64_t below = (uint64_t)(2 * n);
            const uint64_t low[3] = {p + below, q + below, q}, high[3] = {p, p + below, q};
            if (i < n - 1)
                assert_int_equal(brick_mesh_add_polygon(mesh, low, 3, NULL), 0);
            if (i > 0)
                assert_int_equal(brick_mesh_add_polygon(mesh, high, 3, NULL), 0);
        }
}

/* Is pixel p beside one of another colour? */
static bool on_edge(const struct brick_image *mask, uint32_t p)
{
    int x = (int)(p % mask->width), y = (int)(p / mask->width);
    for (int k = 0; k < 9; k++) {
        int u = x + k % 3 - 1, v = y + k / 3 - 1;
        if (u >= 0 && v >= 0 && u < (int)mask->width && v < (int)mask->height &&
            memcmp(mask->rgba + 4 * (v * (int)mask->width + u), mask->rgba + 4 * p, 4 * sizeof(float)))
            return true;
    }
    return false;
}

/* Both pictures agree within `bound`, but where the rasteriser's grid of 1/256 pixel gives a pixel's centre
 * to a triangle that it is just outside of. On the mesh's outline that is one thing or another, so on few
 * pixels of it; inside it is a neighbour, less than 1/256 pixel away: on few pixels too, and by little. */
static void compare_but_grid(const struct brick_image *image, const struct brick_image *exact,
                             const struct brick_image *mask, double bound, const char *what)
{
    uint32_t pixels = image->width * image->height, outline = 0, other = 0, neighbours = 0;
    for (uint32_t p = 0; p < pixels; p++) {
        bool edge = on_edge(mask, p);
        double worst = 0.0;
        for (int c = 0; c < 4; c++)
            worst = fmax(worst, fabs((double)image->rgba[4 * p + c] - (double)exact->rgba[4 * p + c]));
        outline += edge;
        other += edge && worst > bound;
        neighbours += !edge && worst > bound;
        if (!edge && worst > 4e-4)
            fail_msg("%s: pixel %u,%u is %g off", what, p % image->width, p / image->width, worst);
    }
    print_message("%s: %u of %u pixels of the outline differ, and %u others\n", what, other, outline,
                  neighbours);
    assert_true(other <= 2 + outline / 32 && neighbours <= pixels / 64);
}

/* Without a rasteriser's grid: within `bound` everywhere. */
static void compare_all(const struct brick_image *image, const struct brick_image *exact, double bound,
                        const char *what)
{
    for (uint32_t i = 0; i < 4 * image->width * image->height; i++)
        if (!(fabs((double)image->rgba[i] - (double)exact->rgba[i]) <= bound))
            fail_msg("%s: pixel %u,%u is %g, not %g", what, i / 4 % image->width, i / 4 / image->width,
                     (double)image->rgba[i], (double)exact->rgba[i]);
}

static void look_from(struct setting *s, int side)
{
    static const double angles[6][2] = {{0, 0}, {90, 0}, {180, 0}, {270, 0}, {0, 90}, {0, -90}};
    brick_camera_orbit(&s->scene.camera, brick_volume_grid(s->volume), angles[side][0], angles[side][1], 0,
                       70, 1.0);
    /* Off the sphere's symmetry, so that no pixel's centre is exactly on an edge. */
    for (int i = 0; i < 3; i++) {
        s->scene.camera.eye_mm[i] += 0.0173 * (i + 1);
        s->scene.camera.look_mm[i] += 0.0173 * (i + 1);
    }
}

/* Matter that is the same everywhere before, around and behind a sphere: alpha and colour tell how far it is.
 */
static void mesh_depth(void **state)
{
    struct setting s;
    struct brick_mesh spheres[3];
    (void)state;
    begin(&s, same, 100.0);
    struct vr_renderer *caster = try_renderer(s.volume, VR_CONTEXT_CPU);
    make_sphere(&spheres[0], (const double[]){5, 20, 31}, 17.0, 24, true);
    make_sphere(&spheres[1], (const double[]){40, 30, 24}, 9.0, 40, true);
    make_sphere(&spheres[2], (const double[]){-95, 24, -60}, 30.0, 30, true); /* far from the volume */
    struct brick_mesh smooth = spheres[1];
    const struct vr_mesh meshes[3] = {
        {&spheres[0], {0.1, 0.2, 0.9}}, {&smooth, {0.9, 0.8, 0.1}}, {&spheres[2], {0.5, 0.5, 0.5}}};
    smooth.colour = NULL;
    s.scene.meshes = meshes;
    s.scene.mesh_count = 3;
    for (int view = 0; view < 11; view++) {
        struct brick_image image, exact, mask;
        struct brick_transfer *none = transfer_of((const struct brick_transfer_point[]){{0, 0, 0, 0, 0}}, 1);
        char what[40];
        bool lit = view % 2;
        struct brick_mesh plain = spheres[0], far = spheres[2];
        const struct vr_mesh flat[3] = {{&plain, {0.0, 0.0, 1.0}}, meshes[1], {&far, {1.0, 0.0, 0.0}}};
        s.scene.width = s.scene.height = SIZE;
        if (view < 6)
            look_from(&s, view);
        else
            brick_camera_orbit(&s.scene.camera, brick_volume_grid(s.volume), 37 * view, 11 * view - 60, 40, 0,
                               1.0);
        if (view == 8) { /* inside a sphere, and both partly behind the eye */
            memcpy(s.scene.camera.eye_mm, (const double[]){12, 22, 30}, sizeof s.scene.camera.eye_mm);
            s.scene.camera.fov_deg = 120;
        }
        if (view == 9) { /* in two parts */
            look_from(&s, 1);
            s.scene.width = 1100;
            s.scene.height = 24;
            s.scene.camera.ortho_height_mm = 2;
        }
        if (view == 10) { /* the far one too, in tiles without a brick */
            look_from(&s, 0);
            s.scene.width = s.scene.height = 256;
            s.scene.camera.ortho_height_mm = 300;
        }
        s.scene.transfer = none; /* where each is seen, flat */
        s.scene.meshes = flat;
        s.scene.ambient = 1.0;
        s.scene.diffuse = s.scene.specular = 0.0;
        plain.colour = far.colour = NULL;
        draw_exact(&s, &mask, NULL);
        s.scene.transfer = s.transfer;
        s.scene.meshes = meshes;
        s.scene.ambient = lit ? 0.2 : 1.0;
        s.scene.diffuse = lit ? 0.7 : 0.0;
        s.scene.specular = lit ? 0.3 : 0.0;
        draw_exact(&s, &exact, NULL);
        snprintf(what, sizeof what, "view %d", view);
        /* Unlit, sums of up to 150 pieces in float32; lit, a highlight's exponent multiplies the error of
         * pow's logarithm by 20. */
        const double bound = lit ? 5e-5 : 9e-6;
        if (s.renderer) {
            draw(&s, &image);
            compare_but_grid(&image, &exact, &mask, bound, what);
            brick_image_finish(&image);
        }
        render(caster, &s.scene, &s.quality, &image, NULL);
        compare_all(&image, &exact, bound, what);
        brick_image_finish(&image);
        brick_image_finish(&exact);
        brick_image_finish(&mask);
        brick_transfer_destroy(&none);
    }
    vr_renderer_destroy(&caster);
    brick_mesh_finish(&spheres[0]);
    brick_mesh_finish(&spheres[1]);
    brick_mesh_finish(&spheres[2]);
    end(&s);
}

/* A sphere half inside an isosurface, from six sides: which is before the other, against the exact picture;
 * they may differ where both are in one place. */
static void half_inside(void **state)
{
    struct setting s;
    struct brick_mesh sphere;
    static double surface_mm[SIZE * SIZE];
    const double centre[3] = {30, 33, 20};
    (void)state;
    begin(&s, ball, 100.0);
    make_sphere(&sphere, centre, 8.0, 64, false);
    const struct vr_mesh mesh = {&sphere, {0, 0, 1}};
    s.scene.mode = BRICK_MODE_ISO;
    s.scene.isovalue = 400.0; /* a radius of 12 */
    s.scene.transfer = NULL;
    s.scene.iso_rgb[0] = 1.0, s.scene.iso_rgb[1] = s.scene.iso_rgb[2] = 0.0;
    s.scene.ambient = 1.0;
    s.scene.diffuse = s.scene.specular = 0.0;
    s.quality.step_vox = 0.25;
    for (int side = 0; s.renderer && side < 6; side++) {
        struct brick_image image, exact, mask;
        struct brick_view view;
        int surface = 0, ball_before = 0;
        look_from(&s, side);
        s.scene.camera.ortho_height_mm = 45;
        s.scene.mesh_count = 0;
        draw_exact(&s, &mask, surface_mm);
        s.scene.meshes = &mesh;
        s.scene.mesh_count = 1;
        draw_exact(&s, &exact, NULL);
        draw(&s, &image);
        assert_int_equal(
            brick_view_init(&view, &s.scene.camera, brick_volume_grid(s.volume), SIZE, SIZE, NULL), 0);
        for (uint32_t p = 0; p < SIZE * SIZE; p++) {
            bool red = image.rgba[4 * p] > 0.5f, blue = image.rgba[4 * p + 2] > 0.5f;
            surface += red;
            ball_before += blue;
            if (memcmp(image.rgba + 4 * p, exact.rgba + 4 * p, 4 * sizeof(float)) == 0)
                continue;
            struct brick_ray ray;
            double along = 0.0, off2 = 0.0;
            brick_view_ray(&view, p % SIZE, p / SIZE, &ray);
            for (int i = 0; i < 3; i++)
                along += (centre[i] - ray.origin[i]) * ray.direction[i];
            for (int i = 0; i < 3; i++)
                off2 += pow(ray.origin[i] + along * ray.direction[i] - centre[i], 2);
            /* The polyhedron is within 8 (1 - cos(pi / 64)) of the sphere; along a ray that passes the centre
             * at 7.9, that over cos(asin(7.9 / 8)). */
            double mesh_mm = along - sqrt(fmax(64.0 - off2, 0.0));
            bool near_each_other = fabs(mesh_mm - surface_mm[p]) < 0.062;
            if (!near_each_other && !(off2 > 7.9 * 7.9) && !on_edge(&mask, p))
                fail_msg("side %d, pixel %u,%u: mesh at %g, surface at %g", side, p % SIZE, p / SIZE, mesh_mm,
                         surface_mm[p]);
        }
        print_message("side %d: %d pixels of the surface, %d of the mesh\n", side, surface, ball_before);
        /* From some sides it is hidden, from others it is before. */
        assert_true(surface > 500 && ball_before > 50);
        brick_image_finish(&image);
        brick_image_finish(&exact);
        brick_image_finish(&mask);
    }
    brick_mesh_finish(&sphere);
    end(&s);
}

/* With planes and a mesh as without: the same bytes for any bricks, any cache, with and without skipping, by
 * both methods that march rays and both set-ups of them. */
static void memory_invariance(void **state)
{
    static float voxels[N * N * N];
    struct memory_source source;
    struct brick_mesh sphere;
    struct brick_image images[WAYS] = {{0}};
    const struct brick_transfer_point points[] = {{100, 0.9, 0.3, 0.1, 0.0}, {1000, 0.2, 0.9, 0.8, 0.2}};
    struct brick_transfer *transfer = transfer_of(points, 2);
    bool drawn = false;
    (void)state;
    for (int i = 0; i < N * N * N; i++)
        voxels[i] = (float)(ball(i % N, i / N % N, i / N / N) + (double)(noise64(1, (uint64_t)i) % 100));
    memory_source_init(&source, BRICK_F32, N, N, N, voxels);
    make_sphere(&sphere, (const double[]){30, 33, 20}, 8.0, 12, false);
    const struct vr_mesh mesh = {&sphere, {0.2, 0.4, 0.9}};
    for (int memory = 0; memory < 4; memory++) {
        struct brick_volume *volume = volume_of(&source, memory & 1 ? 32 : 16);
        struct vr_renderer_params params = vr_renderer_defaults;
        if (memory & 2)
            params.gpu_cache_bytes = slots_bytes(volume, 8);
        struct vr_renderer *renderer = renderer_of(volume, &params);
        for (int run = 0; renderer && run < 4 * WAYS; run++) {
            const int way = run / 4;
            struct vr_scene scene = vr_scene_defaults;
            struct vr_quality quality = vr_quality_defaults;
            struct brick_image image;
            char line[80];
            set_way(way, &scene, &quality);
            scene.transfer = transfer;
            scene.isovalue = 500.0;
            scene.width = scene.height = SIZE;
            scene.meshes = &mesh;
            scene.mesh_count = 1;
            scene.clip[0] = plane_at(1, -1, 0.4, 6.1);
            scene.clip_count = 1;
            quality.skip = memory & 1;
            quality.method = run & 1 ? VR_METHOD_MULTIPASS : VR_METHOD_RAYCAST;
            quality.setup = run & 2 ? VR_SETUP_GEOMETRY : VR_SETUP_BOX;
            quality.pass_steps = memory & 2 ? 7 : 64;
            brick_camera_orbit(&scene.camera, brick_volume_grid(volume), 40, 20, 0, 0, 1.0);
            render(renderer, &scene, &quality, &image, NULL);
            drawn = true;
            if (!images[way].rgba) {
                images[way] = image;
                continue;
            }
            snprintf(line, sizeof line, "memory %d, way %d, hand %d", memory, way, run % 4);
            assert_same_image(&image, &images[way], line);
            brick_image_finish(&image);
        }
        vr_renderer_destroy(&renderer);
        brick_volume_close(&volume);
    }
    for (int i = 0; i < WAYS; i++)
        brick_image_finish(&images[i]);
    brick_mesh_finish(&sphere);
    brick_transfer_destroy(&transfer);
    if (!drawn)
        skip();
}

static void draw_number(struct setting *s, uint64_t number, struct brick_image *image)
{
    s->scene.meshes_number = number;
    draw(s, image);
}

/* Meshes of one number are taken over once; others are seen, and so are those without a number. */
static void changed_meshes(void **state)
{
    struct setting s;
    struct brick_mesh spheres[2];
    (void)state;
    begin(&s, ball, 100.0);
    make_sphere(&spheres[0], (const double[]){30, 13, 20}, 8.0, 12, true);
    make_sphere(&spheres[1], (const double[]){10, 12, 30}, 8.0, 12, true);
    const struct vr_mesh meshes[2] = {{&spheres[0], {0.2, 0.4, 0.9}}, {&spheres[1], {0.9, 0.4, 0.2}}};
    s.scene.meshes = meshes;
    s.scene.mesh_count = 1;
    if (s.renderer) {
        struct brick_image first, image, changed;
        draw_number(&s, 1, &first);
        for (uint64_t v = 0; v < spheres[0].vertices; v++)
            spheres[0].colour[v][2] = 1.0f - spheres[0].colour[v][0];
        draw_number(&s, 1, &image);
        assert_same_image(&image, &first, "the same number");
        brick_image_finish(&image);
        draw_number(&s, 2, &changed);
        assert_true(memcmp(changed.rgba, first.rgba, (size_t)4 * SIZE * SIZE * sizeof(float)));
        draw_number(&s, 0, &image);
        assert_same_image(&image, &changed, "without a number");
        brick_image_finish(&image);
        s.scene.mesh_count = 2;
        draw_number(&s, 3, &image);
        assert_true(memcmp(image.rgba, changed.rgba, (size_t)4 * SIZE * SIZE * sizeof(float)));
        brick_image_finish(&image);
        s.scene.mesh_count = 1;
        draw_number(&s, 2, &image); /* no longer there */
        assert_same_image(&image, &changed, "the second number once more");
        brick_image_finish(&image);
        brick_image_finish(&first);
        brick_image_finish(&changed);
    }
    brick_mesh_finish(&spheres[0]);
    brick_mesh_finish(&spheres[1]);
    end(&s);
}

static void refused(void **state)
{
    struct setting s;
    struct brick_image image;
    struct brick_mesh empty = {0};
    const struct vr_mesh none = {&empty, {0, 0, 0}};
    struct brick_error err;
    (void)state;
    begin(&s, same, 100.0);
    assert_int_equal(brick_image_init(&image, SIZE, SIZE, NULL), 0);
    if (s.renderer) {
        s.scene.clip_count = VR_MAX_CLIP_PLANES + 1;
        assert_int_equal(vr_render(s.renderer, &s.scene, &s.quality, &image, NULL, &err), BRICK_ERR_ARGUMENT);
        s.scene.clip_count = 1; /* its normal is zero */
        assert_int_equal(vr_render(s.renderer, &s.scene, &s.quality, &image, NULL, &err), BRICK_ERR_ARGUMENT);
        s.scene.clip_count = 0;
        s.scene.meshes = &none;
        s.scene.mesh_count = 1;
        assert_int_equal(vr_render(s.renderer, &s.scene, &s.quality, &image, NULL, &err), BRICK_ERR_ARGUMENT);
    }
    brick_image_finish(&image);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mesh_depth),     cmocka_unit_test(half_inside), cmocka_unit_test(memory_invariance),
        cmocka_unit_test(changed_meshes), cmocka_unit_test(refused),
    };
    return cmocka_run_group_tests_name("meshes", tests, NULL, NULL);
}
