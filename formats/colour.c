/* Interpolation of colours in HSV, CIELAB and Moreland's Msh, with the constants that VTK uses (D65 white
 * rounded to 0.9505, 1, 1.089; the sRGB matrix to four digits), so that a map looks as it does in ParaView.
 */
#include "colour.h"

#include <math.h>

#define PI 3.14159265358979323846

static const double white[3] = {0.9505, 1.0, 1.089};

double colour_decode_srgb(double encoded)
{
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

static double encode_srgb(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static double blend(double a, double b, double t)
{
    return (1 - t) * a + t * b;
}

/* Hue in turns, [0, 1). */
static void hsv_from_rgb(const double rgb[3], double hsv[3])
{
    const double max = fmax(rgb[0], fmax(rgb[1], rgb[2])), min = fmin(rgb[0], fmin(rgb[1], rgb[2]));
    const double chroma = max - min;
    double sextant = 0;
    if (chroma > 0) {
        if (max == rgb[0])
            sextant = (rgb[1] - rgb[2]) / chroma;
        else if (max == rgb[1])
            sextant = 2 + (rgb[2] - rgb[0]) / chroma;
        else
            sextant = 4 + (rgb[0] - rgb[1]) / chroma;
    }
    hsv[0] = sextant < 0 ? sextant / 6 + 1 : sextant / 6;
    hsv[1] = max > 0 ? chroma / max : 0;
    hsv[2] = max;
}

static void rgb_from_hsv(const double hsv[3], double rgb[3])
{
    for (int i = 0; i < 3; i++) {
        /* Distance on the hue circle, in sextants, from where this component is full. */
        double away = 6 * fabs(hsv[0] - i / 3.0);
        away = away > 3 ? 6 - away : away;
        const double pure = fmin(fmax(2 - away, 0), 1);
        rgb[i] = hsv[2] * (1 - hsv[1] * (1 - pure));
    }
}

static void interpolate_hsv(const double from[3], const double to[3], double t, int wrap, double rgb[3])
{
    double a[3], b[3], hsv[3];
    hsv_from_rgb(from, a);
    hsv_from_rgb(to, b);
    if (wrap && fabs(a[0] - b[0]) > 0.5) {
        if (a[0] > b[0])
            a[0] -= 1;
        else
            b[0] -= 1;
    }
    for (int i = 0; i < 3; i++)
        hsv[i] = blend(a[i], b[i], t);
    if (hsv[0] < 0)
        hsv[0] += 1;
    rgb_from_hsv(hsv, rgb);
}

static void lab_from_rgb(const double rgb[3], double lab[3])
{
    static const double to_xyz[3][3] = {
        {0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};
    double f[3];
    for (int i = 0; i < 3; i++) {
        double v = 0;
        for (int j = 0; j < 3; j++)
            v += to_xyz[i][j] * colour_decode_srgb(rgb[j]);
        v /= white[i];
        f[i] = v > 0.008856 ? cbrt(v) : 7.787 * v + 16.0 / 116;
    }
    lab[0] = 116 * f[1] - 16;
    lab[1] = 500 * (f[0] - f[1]);
    lab[2] = 200 * (f[1] - f[2]);
}

static void rgb_from_lab(const double lab[3], double rgb[3])
{
    static const double from_xyz[3][3] = {
        {3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}};
    const double y = (lab[0] + 16) / 116, f[3] = {y + lab[1] / 500, y, y - lab[2] / 200};
    double xyz[3], max = 1;
    for (int i = 0; i < 3; i++) {
        const double cube = f[i] * f[i] * f[i];
        xyz[i] = white[i] * (cube > 0.008856 ? cube : (f[i] - 16.0 / 116) / 7.787);
    }
    for (int i = 0; i < 3; i++) {
        rgb[i] = encode_srgb(from_xyz[i][0] * xyz[0] + from_xyz[i][1] * xyz[1] + from_xyz[i][2] * xyz[2]);
        max = fmax(max, rgb[i]);
    }
    for (int i = 0; i < 3; i++) /* out of gamut: dimmed to fit, then cut */
        rgb[i] = fmax(rgb[i] / max, 0);
}

static void interpolate_lab(const double from[3], const double to[3], double t, double rgb[3])
{
    double a[3], b[3], lab[3];
    lab_from_rgb(from, a);
    lab_from_rgb(to, b);
    for (int i = 0; i < 3; i++)
        lab[i] = blend(a[i], b[i], t);
    rgb_from_lab(lab, rgb);
}

/* Msh: CIELAB in polar form: magnitude, saturation angle, hue angle. */
struct msh {
    double m, s, h;
};

#define UNSATURATED 0.05

static struct msh msh_from_rgb(const double rgb[3])
{
    double lab[3];
    struct msh msh = {0, 0, 0};
    lab_from_rgb(rgb, lab);
    msh.m = sqrt(lab[0] * lab[0] + lab[1] * lab[1] + lab[2] * lab[2]);
    if (msh.m > 0.001)
        msh.s = acos(lab[0] / msh.m);
    if (msh.s > 0.001)
        msh.h = atan2(lab[2], lab[1]);
    return msh;
}

/* The hue an unsaturated colour should have for the change from the saturated one to look even. */
static double spun_hue(struct msh saturated, double unsaturated_m)
{
    if (saturated.m >= unsaturated_m - 0.1)
        return saturated.h;
    const double spin = saturated.s * sqrt(unsaturated_m * unsaturated_m - saturated.m * saturated.m) /
                        (saturated.m * sin(saturated.s));
    return saturated.h > -0.3 * PI ? saturated.h + spin : saturated.h - spin; /* away from purple */
}

static void interpolate_diverging(const double from[3], const double to[3], double t, double rgb[3])
{
    struct msh a = msh_from_rgb(from), b = msh_from_rgb(to);
    const double apart = fabs(remainder(a.h - b.h, 2 * PI));
    if (a.s > UNSATURATED && b.s > UNSATURATED &&
        apart > 0.33 * PI) { /* two distinct colours: white between */
        const struct msh middle = {fmax(88, fmax(a.m, b.m)), 0, 0};
        if (t < 0.5) {
            b = middle;
            t = 2 * t;
        } else {
            a = middle;
            t = 2 * t - 1;
        }
    }
    if (a.s < UNSATURATED && b.s > UNSATURATED)
        a.h = spun_hue(b, a.m);
    else if (b.s < UNSATURATED && a.s > UNSATURATED)
        b.h = spun_hue(a, b.m);
    const struct msh msh = {blend(a.m, b.m, t), blend(a.s, b.s, t), blend(a.h, b.h, t)};
    const double lab[3] = {msh.m * cos(msh.s), msh.m * sin(msh.s) * cos(msh.h),
                           msh.m * sin(msh.s) * sin(msh.h)};
    rgb_from_lab(lab, rgb);
}

void colour_interpolate(enum colour_space space, const double from[3], const double to[3], double t,
                        double rgb[3])
{
    switch (space) {
    case COLOUR_RGB:
        for (int i = 0; i < 3; i++)
            rgb[i] = blend(from[i], to[i], t);
        break;
    case COLOUR_STEP:
        for (int i = 0; i < 3; i++)
            rgb[i] = to[i];
        break;
    case COLOUR_HSV:
    case COLOUR_HSV_WRAP:
        interpolate_hsv(from, to, t, space == COLOUR_HSV_WRAP, rgb);
        break;
    case COLOUR_LAB:
        interpolate_lab(from, to, t, rgb);
        break;
    case COLOUR_DIVERGING:
        interpolate_diverging(from, to, t, rgb);
        break;
    }
    for (int i = 0; i < 3; i++)
        rgb[i] = fmin(fmax(rgb[i], 0), 1);
}
