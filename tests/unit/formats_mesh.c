/* Meshes from files: every spelling of one mesh gives the same mesh, and what is damaged is refused in a
 * line. */
#include "format_files.h"

#include <math.h>

/* A pyramid: a square of the plane z = 0.1 and its top; 6 triangles. */
enum { VERTICES = 5, FACES = 5 };
static const float corner[VERTICES][3] = {
    {-1.5f, -1, 0.1f}, {1, -1.25f, 0.1f}, {1, 1, 0.1f}, {-1, 1e-3f, 0.1f}, {0.3f, 0.2f, 2}};
static const int face[FACES][5] = {{4, 3, 2, 1, 0}, {3, 0, 1, 4}, {3, 1, 2, 4}, {3, 2, 3, 4}, {3, 3, 0, 4}};

static const char header[] = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
                             "element face 5\nproperty list uchar int vertex_indices\nend_header\n";

static size_t append(unsigned char *to, const void *value, size_t n, bool big)
{
    const unsigned char *from = value;
    for (size_t i = 0; i < n; i++)
        to[i] = from[big == (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__) ? i : n - 1 - i];
    return n;
}

static const char *put_binary(bool big, size_t cut)
{
    unsigned char body[512];
    char text[512];
    size_t n = 0;
    for (int v = 0; v < VERTICES; v++)
        for (int i = 0; i < 3; i++)
            n += append(body + n, &corner[v][i], 4, big);
    for (int f = 0; f < FACES; f++) {
        body[n++] = (unsigned char)face[f][0];
        for (int k = 1; k <= face[f][0]; k++)
            n += append(body + n, &face[f][k], 4, big);
    }
    snprintf(text, sizeof text, "ply\nformat binary_%s_endian 1.0\ncomment a pyramid\n%s",
             big ? "big" : "little", header);
    return put_file("m.ply", text, body, n - cut);
}

static const char *put_ascii(const char *end_of_line)
{
    char text[1024], out[1024];
    size_t n = (size_t)snprintf(text, sizeof text, "ply\nformat ascii 1.0\n%s", header), m = 0;
    for (int v = 0; v < VERTICES; v++)
        n += (size_t)snprintf(text + n, sizeof text - n, "%.9g %.9g %.9g\n", (double)corner[v][0],
                              (double)corner[v][1], (double)corner[v][2]);
    for (int f = 0; f < FACES; f++)
        for (int k = 0; k <= face[f][0]; k++)
            n +=
                (size_t)snprintf(text + n, sizeof text - n, "%d%s", face[f][k], k == face[f][0] ? "\n" : " ");
    for (size_t i = 0; i < n; i++)
        m += (size_t)snprintf(out + m, sizeof out - m, text[i] == '\n' ? "%s" : "%.1s",
                              text[i] == '\n' ? end_of_line : &text[i]);
    return put_file("m.ply", out, NULL, 0);
}

static void read_good(struct brick_mesh *mesh, const char *path)
{
    struct brick_error err = {.message = ""};
    if (fmt_mesh_read(mesh, path, &err))
        fail_msg("%s", err.message);
}

/* The pyramid, its positions as floats. */
static void expect_pyramid(const char *path)
{
    static const uint32_t triangles[][3] = {{3, 2, 1}, {3, 1, 0}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
    struct brick_mesh mesh;
    read_good(&mesh, path);
    assert_int_equal(mesh.vertices, VERTICES);
    assert_int_equal(mesh.triangles, 6);
    for (uint32_t t = 0; t < 6; t++)
        for (int k = 0; k < 3; k++) {
            /* Vertices may be in another order. */
            const double *p = mesh.position_mm[mesh.triangle[t][k]];
            for (int i = 0; i < 3; i++)
                assert_true((float)p[i] == corner[triangles[t][k]][i]);
        }
    double low[3], high[3];
    brick_mesh_bounds(&mesh, low, high);
    assert_true((float)low[0] == -1.5f && (float)low[1] == -1.25f && (float)low[2] == 0.1f);
    assert_true(high[0] == 1.0 && high[1] == 1.0 && high[2] == 2.0);
    brick_mesh_finish(&mesh);
}

static void expect_refused(const char *path, int code, const char *says)
{
    struct brick_mesh mesh;
    struct brick_error err = {.message = ""};
    int got = fmt_mesh_read(&mesh, path, &err);
    if (got != code || !strstr(err.message, says) || strchr(err.message, '\n') || !strstr(err.message, path))
        fail_msg("expected %d with '%s', got %d: %s", code, says, got, err.message);
    assert_null(mesh.position_mm);
    assert_null(mesh.triangle);
}

static void ply_in_three_encodings(void **state)
{
    (void)state;
    expect_pyramid(put_binary(false, 0));
    expect_pyramid(put_binary(true, 0));
    expect_pyramid(put_ascii("\n"));
    expect_pyramid(put_ascii("\r\n"));
}

/* Doubles, properties that are not known, an element before the vertices, normals and colours. */
static void ply_with_everything(void **state)
{
    (void)state;
    struct brick_mesh mesh;
    read_good(
        &mesh,
        put_file("m.ply",
                 "ply\nformat ascii 1.0\nelement camera 1\nproperty list int double matrix\nproperty int id\n"
                 "element vertex 3\nproperty double z\nproperty double y\nproperty double x\n"
                 "property float nx\nproperty float ny\nproperty float nz\nproperty list uchar uchar tags\n"
                 "property uchar red\nproperty uchar green\nproperty ushort blue\n"
                 "element face 1\nproperty int flags\nproperty list uchar uint vertex_index\n"
                 "end_header\n2 0.5 0.25 7\n"
                 "0.1 0.2 0.30000000000000004 0 0 5 1 9 0 255 65535\n1 0 0 0 0 0 0 128 0 0\n"
                 "0 1 0 nan 0 0 0 0 0 0\n-1 3 2 1 0",
                 NULL, 0));
    assert_int_equal(mesh.vertices, 3);
    assert_int_equal(mesh.triangles, 1);
    assert_true(mesh.position_mm[0][0] == 0.30000000000000004 && mesh.position_mm[0][2] == 0.1);
    assert_true(mesh.normal[0][2] == 1.0f && mesh.normal[1][2] == 0.0f && mesh.normal[2][0] == 0.0f);
    assert_true(mesh.colour[0][0] == 0.0f && mesh.colour[0][1] == 1.0f && mesh.colour[0][2] == 1.0f);
    assert_true(fabsf(mesh.colour[1][0] - 0.2158605f) < 1e-6f); /* sRGB 128 / 255 */
    assert_int_equal(mesh.triangle[0][0], 2);
    brick_mesh_finish(&mesh);
}

static void ply_damaged(void **state)
{
    (void)state;
    const size_t body = VERTICES * 12 + 4 * 13 + 17;
    for (size_t cut = 1; cut <= body; cut++)
        expect_refused(put_binary(cut & 1, cut), BRICK_ERR_FORMAT, "");
    static const char *const wrong[][3] = {
        {"obj\n", "", "not a PLY"},
        {"ply\nformat ascii 2.0\n", header, "line 2"},
        {"ply\n", header, "makes no sense"},
        {"ply\nformat ascii 1.0\nproperty float x\n", header, "line 3"},
        {"ply\nformat ascii 1.0\nelement rows 5\n", header, "rows of nothing"},
        {"ply\nformat ascii 1.0\nelement vertex 5\n", "", "does not end"},
        {"ply\nformat ascii 1.0\nelement vertex 18446744073709551615\nproperty float x\n",
         "property float y\nproperty float z\nend_header\n0 0 0\n", "do not fit"},
        {"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n",
         "property float y\nproperty float z\nend_header\n0 0 0\n", "do not fit"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n",
         "end_header\n0 0 0\n", "no triangles"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n",
         "end_header\n0 nan 0\n", "vertex 0 is at nan"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n",
         "end_header\n0 1e10 0\n", "within"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n",
         "end_header\n0 zero 0\n", "not a number"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n", "end_header\n0 0\n",
         "no x, y and z"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty char x\nproperty char y\nproperty char z\n"
         "element vertex 1\nproperty char x\nproperty char y\nproperty char z\nproperty char nx\n",
         "property char ny\nproperty char nz\nend_header\n0 0 0 1 0 0 0 0 1\n", "vertex 1 has a normal"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        expect_refused(put_file("m.ply", wrong[i][0], wrong[i][1], strlen(wrong[i][1])), BRICK_ERR_FORMAT,
                       wrong[i][2]);
    static const char *const faces[][2] = {{"3 0 1 5", "vertex 5 of 5"},
                                           {"3 0 1 -1", "-1 where"},
                                           {"3 0 1 0.5", "0.5 where"},
                                           {"2 0 1", "2 corners"},
                                           {"4000000000 0 1 2 3 4", "too early"}};
    for (size_t i = 0; i < sizeof faces / sizeof *faces; i++) {
        char text[512];
        snprintf(
            text, sizeof text,
            "ply\nformat ascii 1.0\nelement vertex 5\nproperty char x\nproperty char y\nproperty char z\n"
            "element face 1\nproperty list uint float vertex_indices\nend_header\n"
            "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1\n%s\n",
            faces[i][0]);
        expect_refused(put_file("m.ply", text, NULL, 0), BRICK_ERR_FORMAT, faces[i][1]);
    }
    expect_refused(in_folder("missing.ply"), BRICK_ERR_IO, "");
    expect_refused(put_file("m.stl", "solid", NULL, 0), BRICK_ERR_UNSUPPORTED, "must end in");
}

/* Triangles of a polygon that is not convex cover it: their areas, signed, sum to its own, and none is
 * turned. */
static void polygons_are_cut_right(void **state)
{
    (void)state;
    static const double star[10][3] = {{0, 0, 10}, {2, 0, 3},   {10, 0, 3},  {4, 0, -1},  {6, 0, -9},
                                       {0, 0, -4}, {-6, 0, -9}, {-4, 0, -1}, {-10, 0, 3}, {-2, 0, 3}};
    for (int turn = 0; turn < 20; turn++) { /* from each corner, both ways round */
        struct brick_mesh mesh = {0};
        uint64_t corners[10];
        double area = 0.0, sum = 0.0;
        for (int v = 0; v < 10; v++) {
            assert_int_equal(brick_mesh_add_vertex(&mesh, star[v], NULL, NULL, NULL), 0);
            corners[v] = (uint64_t)((turn < 10 ? v : 9 - v) + turn) % 10;
        }
        for (int k = 0; k < 10; k++) {
            const double *p = star[corners[k]], *q = star[corners[(k + 1) % 10]];
            area += 0.5 * (p[0] * q[2] - p[2] * q[0]);
        }
        assert_int_equal(brick_mesh_add_polygon(&mesh, corners, 10, NULL), 0);
        assert_int_equal(mesh.triangles, 8);
        for (int t = 0; t < 8; t++) {
            const double *a = star[mesh.triangle[t][0]], *b = star[mesh.triangle[t][1]],
                         *c = star[mesh.triangle[t][2]];
            double part = 0.5 * ((b[0] - a[0]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[0] - a[0]));
            assert_true(part * area > 0.0);
            sum += part;
        }
        assert_true(fabs(sum - area) < 1e-12);
        brick_mesh_finish(&mesh);
    }
    struct brick_mesh mesh = {0};
    const double origin[3] = {0};
    const uint64_t none[4] = {0};
    struct brick_error err;
    assert_int_equal(brick_mesh_add_vertex(&mesh, origin, NULL, NULL, &err), 0);
    assert_int_equal(brick_mesh_add_polygon(&mesh, none, BRICK_MESH_MAX_CORNERS + 1, &err), BRICK_ERR_FORMAT);
    assert_int_equal(brick_mesh_add_polygon(&mesh, none, 4, &err), 0); /* no area, but a polygon */
    assert_int_equal(mesh.triangles, 2);
    brick_mesh_finish(&mesh);
}

#ifdef HAVE_TINYOBJ
static const char *put_obj(bool back, const char *end_of_line, const char *style)
{
    char text[1024];
    size_t n = (size_t)snprintf(text, sizeof text, "# a pyramid%smtllib none.mtl%so it%s", end_of_line,
                                end_of_line, end_of_line);
    for (int v = 0; v < VERTICES; v++)
        n += (size_t)snprintf(text + n, sizeof text - n, "v %.9g %.9g %.9g%s", (double)corner[v][0],
                              (double)corner[v][1], (double)corner[v][2], end_of_line);
    n += (size_t)snprintf(text + n, sizeof text - n, "vt 0 0%svn 0 0 2%susemtl it%s", end_of_line,
                          end_of_line, end_of_line);
    for (int f = 0; f < FACES; f++) {
        n += (size_t)snprintf(text + n, sizeof text - n, "f");
        for (int k = 1; k <= face[f][0]; k++)
            n += (size_t)snprintf(text + n, sizeof text - n, " %d%s",
                                  back ? face[f][k] - VERTICES : face[f][k] + 1, style);
        n += (size_t)snprintf(text + n, sizeof text - n, "%s", end_of_line);
    }
    return put_file("m.obj", text, NULL, 0);
}

static void obj_in_many_spellings(void **state)
{
    (void)state;
    static const char *const styles[] = {"", "/1", "/1/1", "//1", "//-1"};
    for (int s = 0; s < 5; s++)
        for (int back = 0; back < 2; back++) {
            expect_pyramid(put_obj(back, "\n", styles[s]));
            expect_pyramid(put_obj(back, "\r\n", styles[s]));
            struct brick_mesh mesh;
            read_good(&mesh, in_folder("m.obj"));
            assert_true(mesh.normal[2][2] == (s < 2 ? 0.0f : 1.0f));
            brick_mesh_finish(&mesh);
        }
}

static void obj_damaged(void **state)
{
    (void)state;
    static const char *const wrong[][2] = {
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles"},
        {"", "no triangles"},
        {"v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "line 2: not finite"},
        {"v 0 0 0\nv 1 1e999 0\nv 0 1 0\nf 1 2 3\n", "line 2: not finite"},
        {"v 0 0 0\nv 1 zero 0\nv 0 1 0\nf 1 2 3\n", "line 2: not finite"},
        {"v 0 0 0\nv 1 0x10 0\nv 0 1 0\nf 1 2 3\n", "line 2: not finite"},
        {"v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", "line 2: fewer"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "vertex 4 of 3"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "vertex -4 of 3"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "vertex 0 of 3"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf a b c\n", "vertex 0 of 3"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "2 corners"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//2\n", "normal 2 of 1"},
        {"v 0 0 0\nv 1 2e9 0\nv 0 1 0\nf 1 2 3\n", "within"},
        {"v 0 0 0\nvn 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 2: fewer"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        expect_refused(put_file("m.obj", wrong[i][0], NULL, 0), BRICK_ERR_FORMAT, wrong[i][1]);
    expect_refused(put_file("m.obj", "v 0 0 ", "\0\n", 2), BRICK_ERR_FORMAT, "line 1: not text");
    static char line[(1 << 20) + 2];
    memset(line, 'v', sizeof line - 1);
    expect_refused(put_file("m.obj", line, NULL, 0), BRICK_ERR_FORMAT, "line 1: too long");
}
#else
static void obj_needs_a_library(void **state)
{
    (void)state;
    expect_refused(put_file("m.obj", "v 0 0 0\n", NULL, 0), BRICK_ERR_UNSUPPORTED, "libtinyobjloader-dev");
}
#endif

/* Whatever bytes change, reading ends in a mesh that can be drawn or in one line. Seeded. */
static void any_damage_ends_in_a_result(void **state)
{
    (void)state;
    uint32_t seed = 5;
    for (int round = 0; round < 1000; round++) {
        unsigned char bytes[1024];
        const char *path = round % 3 == 0 ? put_ascii("\n") : put_binary(round % 3 == 1, 0);
#ifdef HAVE_TINYOBJ
        if (round % 4 == 0)
            path = put_obj(round % 8 == 0, "\n", "//1");
#endif
        FILE *file = fopen(path, "rb");
        size_t n = fread(bytes, 1, sizeof bytes, file);
        fclose(file);
        for (int times = 0; times < 3; times++) {
            seed = seed * 1664525u + 1013904223u;
            bytes[(seed >> 8) % n] =
                times ? "0123456789-+. \n\r\t\0\xff/ev"[seed % 23] : (unsigned char)(seed >> 24);
        }
        struct brick_mesh mesh;
        struct brick_error err = {.message = ""};
        int code = fmt_mesh_read(&mesh, put_file(strrchr(path, '/') + 1, "", bytes, n), &err);
        assert_true(code <= 0);
        if (code)
            assert_true(err.code == code && *err.message && !strchr(err.message, '\n'));
        for (uint64_t t = 0; t < mesh.triangles; t++)
            for (int k = 0; k < 3; k++)
                assert_true(mesh.triangle[t][k] < mesh.vertices);
        brick_mesh_finish(&mesh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ply_in_three_encodings),
        cmocka_unit_test(ply_with_everything),
        cmocka_unit_test(ply_damaged),
        cmocka_unit_test(polygons_are_cut_right),
#ifdef HAVE_TINYOBJ
        cmocka_unit_test(obj_in_many_spellings),
        cmocka_unit_test(obj_damaged),
#else
        cmocka_unit_test(obj_needs_a_library),
#endif
        cmocka_unit_test(any_damage_ends_in_a_result),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
