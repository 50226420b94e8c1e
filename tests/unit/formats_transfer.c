/* Transfer functions from JSON: this project's form, strict, and ParaView's colour maps against closed forms.
 */
#include "format_files.h"

#include <math.h>

static struct brick_transfer_spec read_text(const char *text)
{
    struct brick_transfer_spec spec;
    struct brick_error err = {.message = ""};
    if (fmt_transfer_read(&spec, put_file("t.json", text, NULL, 0), &err))
        fail_msg("%s", err.message);
    return spec;
}

/* Linear between control points; at a jump the side asked for. Components 0..3: r g b A. */
static double component(const struct brick_transfer_point *p, int c)
{
    return c == 0 ? p->r : c == 1 ? p->g : c == 2 ? p->b : p->a;
}

static double eval(const struct brick_transfer_spec *spec, double x, bool right, int c)
{
    size_t i = 0;
    while (i < spec->count && (spec->points[i].value < x || (right && spec->points[i].value == x)))
        i++;
    if (i == 0)
        return component(&spec->points[0], c);
    if (i == spec->count)
        return component(&spec->points[i - 1], c);
    const struct brick_transfer_point *a = &spec->points[i - 1], *b = &spec->points[i];
    const double t = (x - a->value) / (b->value - a->value);
    return (1 - t) * component(a, c) + t * component(b, c);
}

static double linear(double s)
{
    return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

static void expect_near(double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%.12g is not %.12g within %g", got, want, tolerance);
}

/* What was read can be used. */
static void expect_usable(struct brick_transfer_spec *spec, bool continuous)
{
    struct brick_transfer *transfer = NULL;
    struct brick_error err = {.message = ""};
    const double range[2] = {0, 1};
    if (brick_transfer_create(&transfer, spec, 1, range, &err))
        fail_msg("%s", err.message);
    assert_int_equal(transfer->continuous, continuous);
    brick_transfer_destroy(&transfer);
    brick_transfer_spec_finish(spec);
}

static void own_form(void **state)
{
    (void)state;
    struct brick_transfer_spec spec = read_text(
        "{\"unit\": 2.5, \"values\": \"physical\", \"points\": [[-100, 0, 0.25, 1, 0], [50.5, 1, 1, 1, 0.5],"
        " [50.5, 0, 0, 0, 1], [3e3, 0, 0, 0, 1]]}");
    assert_true(spec.unit == 2.5 && spec.unit_of == BRICK_UNIT_MM && !spec.range_values);
    assert_int_equal(spec.count, 4);
    assert_true(spec.points[0].value == -100 && spec.points[0].g == 0.25 && spec.points[0].b == 1);
    assert_true(spec.points[1].value == 50.5 && spec.points[1].a == 0.5 && spec.points[3].value == 3000);
    expect_usable(&spec, false);
    spec = read_text(
        "{\"points\": [[0, 1, 1, 1, 0], [1, 1, 1, 1, 0.1]], \"unit\": \"voxel\", \"values\": \"range\"}");
    assert_true(spec.unit == 1 && spec.unit_of == BRICK_UNIT_VOXEL && spec.range_values);
    expect_usable(&spec, true);
    spec = read_text(" {\"points\": [[7, 1, 1, 1, 0.5]]}\n");
    assert_true(spec.unit == 1 && spec.unit_of == BRICK_UNIT_MM && !spec.range_values);
    expect_usable(&spec, true);
}

static void refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
        int code;
    } cases[] = {
        {"", "not JSON", BRICK_ERR_FORMAT},
        {"{\"points\": [[0, 1, 1, 1, 0]]", "not JSON", BRICK_ERR_FORMAT},
        {"{\"points\": [[0, 1, 1, 1, 0]]} x", "not JSON, from byte", BRICK_ERR_FORMAT},
        {"{\"points\": [[NaN, 1, 1, 1, 0]]}", "not JSON", BRICK_ERR_FORMAT},
        {"17", "no JSON object", BRICK_ERR_FORMAT},
        {"{}", "neither \"points\"", BRICK_ERR_FORMAT},
        {"{\"Points\": []}", "unknown key \"Points\"", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,0]], \"gamma\": 2}", "unknown key \"gamma\"", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,0]], \"points\": [[0,1,1,1,0]]}", "\"points\" is there twice",
         BRICK_ERR_FORMAT},
        {"{\"points\": []}", "must be a list", BRICK_ERR_FORMAT},
        {"{\"points\": 3}", "must be a list", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,0], 4]}", "point 1 is not a list", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,0], [1,1,1,1]]}", "point 1 has 4 numbers", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,0,0]]}", "point 0 has 6 numbers", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,\"x\"]]}", "point 0: its entry 4", BRICK_ERR_FORMAT},
        {"{\"points\": [[1e999,1,1,1,0]]}", "point 0: its entry 0 is not a finite", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,0],[1,1,1.5,1,0]]}", "point 1: g is 1.5", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,-0.1]]}", "point 0: A is -0.1", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,0],[-1,1,1,1,0]]}", "point 1: value -1 is below", BRICK_ERR_FORMAT},
        {"{\"points\": [[0,1,1,1,0],[0,1,1,1,0],[0,1,1,1,0]]}", "point 2: a third", BRICK_ERR_FORMAT},
        {"{\"unit\": 0, \"points\": [[0,1,1,1,0]]}", "\"unit\" must be", BRICK_ERR_FORMAT},
        {"{\"unit\": 1e999, \"points\": [[0,1,1,1,0]]}", "\"unit\" must be", BRICK_ERR_FORMAT},
        {"{\"unit\": \"mm\", \"points\": [[0,1,1,1,0]]}", "\"unit\" must be", BRICK_ERR_FORMAT},
        {"{\"values\": \"HU\", \"points\": [[0,1,1,1,0]]}", "\"values\" must be", BRICK_ERR_FORMAT},
        {"[]", "a list of 0", BRICK_ERR_FORMAT},
        {"[{\"RGBPoints\": [0,0,0,0]}, {\"RGBPoints\": [0,0,0,0]}]", "a list of 2", BRICK_ERR_FORMAT},
        {"[{\"Name\": \"x\"}]", "without \"RGBPoints\"", BRICK_ERR_UNSUPPORTED},
        {"{\"RGBPoints\": [0,0,0,0,1]}", "has 5 numbers", BRICK_ERR_FORMAT},
        {"{\"RGBPoints\": [0,0,0,0,1,0,0,255]}", "point 1: 255 is outside", BRICK_ERR_FORMAT},
        {"{\"RGBPoints\": [0,0,0,0,-1,0,0,0]}", "point 1: value -1 is below", BRICK_ERR_FORMAT},
        {"{\"RGBPoints\": [0,0,0,0,null,0,0,0]}", "point 1: not a finite", BRICK_ERR_FORMAT},
        {"{\"RGBPoints\": [0,0,0,0], \"ColorSpace\": \"Prolab\"}", "ColorSpace Prolab",
         BRICK_ERR_UNSUPPORTED},
        {"{\"RGBPoints\": [0,0,0,0], \"ColorSpace\": 3}", "ColorSpace", BRICK_ERR_UNSUPPORTED},
        {"{\"RGBPoints\": [0,0,0,0], \"UseLogScale\": 1}", "log scale", BRICK_ERR_UNSUPPORTED},
        {"{\"RGBPoints\": [0,0,0,0], \"Points\": [0,1,0.5]}", "\"Points\" has 3", BRICK_ERR_FORMAT},
        {"{\"RGBPoints\": [0,0,0,0], \"Points\": [0,1,2,0]}", "\"Points\": point 0: 2 is", BRICK_ERR_FORMAT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct brick_transfer_spec spec;
        struct brick_error err = {.message = ""};
        const char *path = put_file("bad.json", cases[i].text, NULL, 0);
        const int got = fmt_transfer_read(&spec, path, &err);
        if (got != cases[i].code || !strstr(err.message, cases[i].says) || !strstr(err.message, path) ||
            strchr(err.message, '\n'))
            fail_msg("%s: expected '%s', got %d: %s", cases[i].text, cases[i].says, got, err.message);
        assert_null(spec.points);
    }
}

static void refused_files(void **state)
{
    (void)state;
    struct brick_transfer_spec spec;
    struct brick_error err = {.message = ""};
    assert_int_equal(fmt_transfer_read(&spec, in_folder("missing.json"), &err), BRICK_ERR_IO);
    assert_int_equal(fmt_transfer_read(&spec, folder, &err), BRICK_ERR_IO);
    /* A zero byte does not end the text. */
    const char *path = put_file("zero.json", "{\"points\": [[0,1,1,1,0]]}", "\0", 1);
    assert_int_equal(fmt_transfer_read(&spec, path, &err), BRICK_ERR_FORMAT);
    path = put_file("large.json", "", NULL, 0);
    assert_int_equal(truncate(path, (16 << 20) + 1), 0);
    assert_int_equal(fmt_transfer_read(&spec, path, &err), BRICK_ERR_FORMAT);
    assert_non_null(strstr(err.message, "16 MiB"));
    char *deep = malloc(100001); /* nesting must not use up the stack */
    assert_non_null(deep);
    memset(deep, '[', 100000);
    deep[100000] = 0;
    assert_int_equal(fmt_transfer_read(&spec, put_file("deep.json", deep, NULL, 0), &err), BRICK_ERR_FORMAT);
    free(deep);
}

static void paraview_rgb(void **state)
{
    (void)state;
    struct brick_transfer_spec spec = read_text(
        "[{\"Name\": \"x\", \"NanColor\": [1,1,0], \"ColorSpace\": \"RGB\", \"Creator\": {\"a\": []},"
        " \"RGBPoints\": [-10, 0, 0.2, 1, 0, 0.5, 0.2, 0, 30, 1, 0.2, 0.5],"
        " \"Points\": [-20, 0, 0.5, 0, 10, 0.5, 0.5, 0, 40, 1, 0.5, 0]}]");
    assert_true(spec.unit == 1 && spec.unit_of == BRICK_UNIT_VOXEL && !spec.range_values);
    assert_true(spec.count >= 256);
    for (double x = -25; x <= 45; x += 0.37) {
        const double t = x < 0 ? fmin(fmax((x + 10) / 10, 0), 1) : fmin(x / 30, 1);
        const double want[3] = {x < 0 ? linear(0.5 * t) : linear(0.5 + 0.5 * t), linear(0.2),
                                x < 0 ? linear(1 - t) : linear(0.5 * t)};
        const double a = x <= -20 ? 0 : x < 10 ? 0.5 * (x + 20) / 30 : x < 40 ? 0.5 + 0.5 * (x - 10) / 30 : 1;
        /* Chords of s^2.4 over pieces of 1/256: below 3.4 / 8 / 256^2. */
        for (int c = 0; c < 3; c++)
            expect_near(eval(&spec, x, true, c), want[c], 7e-6);
        expect_near(eval(&spec, x, true, 3), a, 1e-12);
    }
    expect_usable(&spec, true);
    spec = read_text("{\"RGBPoints\": [0, 1, 0, 0, 1, 0, 0, 1]}"); /* no Points: opaque */
    expect_near(eval(&spec, 0.5, true, 3), 1, 0);
    expect_usable(&spec, true);
    spec = read_text("{\"RGBPoints\": [0, 0, 0, 0, 1, 1, 1, 1, 1, 0, 0, 0, 2, 1, 1, 1]}"); /* a jump */
    expect_near(eval(&spec, 1, false, 0), 1, 0);
    expect_near(eval(&spec, 1, true, 0), 0, 0);
    expect_usable(&spec, false);
}

static void paraview_spaces(void **state)
{
    (void)state;
    /* HSV: half-way from red to green is yellow; from red to blue the long way round, through green, unless
     * wrapped (magenta). */
    struct brick_transfer_spec spec = read_text(
        "{\"ColorSpace\": \"HSV\", \"RGBPoints\": [0, 1, 0, 0, 1, 0, 1, 0, 2, 1, 0, 0, 3, 0, 0, 1]}");
    const double yellow[3] = {1, 1, 0}, green[3] = {0, 1, 0}, magenta[3] = {1, 0, 1};
    for (int c = 0; c < 3; c++) {
        expect_near(eval(&spec, 0.5, true, c), yellow[c], 1e-12);
        expect_near(eval(&spec, 2.5, true, c), green[c], 1e-12);
    }
    expect_usable(&spec, true);
    spec = read_text("{\"ColorSpace\": \"HSV\", \"HSVWrap\": 1, \"RGBPoints\": [0, 1, 0, 0, 1, 0, 0, 1]}");
    for (int c = 0; c < 3; c++)
        expect_near(eval(&spec, 0.5, true, c), magenta[c], 1e-12);
    expect_usable(&spec, true);
    /* Lab: half-way from black to white has L* = 50, so Y = ((50 + 16) / 116)^3; VTK's rounded matrices
     * spread the channels by parts in a thousand. */
    spec = read_text("{\"ColorSpace\": \"Lab\", \"RGBPoints\": [0, 0, 0, 0, 1, 1, 1, 1]}");
    for (int c = 0; c < 3; c++)
        expect_near(eval(&spec, 0.5, true, c), pow(66.0 / 116, 3), 3e-4);
    expect_usable(&spec, true);
    /* Diverging: the well-known cool to warm map has (0.865, 0.865, 0.865) in its middle. */
    spec = read_text("{\"ColorSpace\": \"Diverging\", \"RGBPoints\": [0, 0.231373, 0.298039, 0.752941,"
                     " 1, 0.705882, 0.0156863, 0.14902]}");
    for (int c = 0; c < 3; c++)
        expect_near(eval(&spec, 0.5, true, c), linear(0.865), 1e-3);
    expect_near(eval(&spec, 0, true, 2), linear(0.752941), 0);
    expect_near(eval(&spec, 1, true, 0), linear(0.705882), 0);
    expect_usable(&spec, true);
    /* Step: the colour of the segment's end, all along it. */
    spec = read_text("{\"ColorSpace\": \"Step\", \"RGBPoints\": [0, 1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1]}");
    expect_near(eval(&spec, -1, true, 0), 1, 0);
    expect_near(eval(&spec, 0, true, 1), 1, 0);
    expect_near(eval(&spec, 0.9, true, 1), 1, 0);
    expect_near(eval(&spec, 1.1, true, 2), 1, 0);
    expect_near(eval(&spec, 9, true, 2), 1, 0);
    expect_usable(&spec, false);
}

static void paraview_opacity(void **state)
{
    (void)state;
    /* Midpoint 1/4, no sharpness; then a step at 1/2; then sharpness 1/2. */
    struct brick_transfer_spec spec = read_text(
        "{\"RGBPoints\": [0, 1, 1, 1], \"Points\": [0, 0.1, 0.25, 0, 1, 0.3, 0.5, 1, 2, 0.8, 0.5, 0.5,"
        " 3, 0.2, 0.5, 0]}");
    expect_near(eval(&spec, 0.125, true, 3), 0.15, 1e-12);
    expect_near(eval(&spec, 0.25, true, 3), 0.2, 1e-12);
    expect_near(eval(&spec, 0.625, true, 3), 0.25, 1e-12);
    expect_near(eval(&spec, 1.49, true, 3), 0.3, 0);
    expect_near(eval(&spec, 1.5, false, 3), 0.3, 0);
    expect_near(eval(&spec, 1.5, true, 3), 0.8, 0);
    /* At a quarter: s = 0.5 * 0.5^6, then VTK's Hermite basis h1..h4 with tangents (1 - sharpness) * slope.
     */
    const double s = 0.5 * pow(0.5, 6), slope = 0.2 - 0.8, tangent = 0.5 * slope;
    const double h1 = 2 * s * s * s - 3 * s * s + 1, h2 = -2 * s * s * s + 3 * s * s;
    const double h3 = s * s * s - 2 * s * s + s, h4 = s * s * s - s * s;
    expect_near(eval(&spec, 2.25, true, 3), h1 * 0.8 + h2 * 0.2 + h3 * tangent + h4 * tangent, 1e-12);
    expect_near(eval(&spec, 2.5, true, 3), 0.5, 1e-12);
    expect_near(eval(&spec, 3, false, 3), 0.2, 0);
    size_t jumps = 0;
    for (size_t i = 1; i < spec.count; i++)
        jumps += spec.points[i].value == spec.points[i - 1].value;
    assert_int_equal(jumps, 1);
    expect_usable(&spec, false);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(own_form),     cmocka_unit_test(refused),         cmocka_unit_test(refused_files),
        cmocka_unit_test(paraview_rgb), cmocka_unit_test(paraview_spaces), cmocka_unit_test(paraview_opacity),
    };
    (void)empty_folder;
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
