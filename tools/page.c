/* Why: everything in a report is either a number for people, a name from a file (never trusted), or a
 * picture. */
#include "page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bytes of the UTF-8 character at s, or 0 when there is none. */
static size_t utf8_bytes(const unsigned char *s)
{
    size_t n = s[0] < 0x80 ? 1 : s[0] >= 0xc2 && s[0] < 0xe0 ? 2 : s[0] >= 0xe0 && s[0] < 0xf0 ? 3 : 4;
    if (n == 4 && (s[0] < 0xf0 || s[0] > 0xf4))
        return 0;
    for (size_t i = 1; i < n; i++)
        if ((s[i] & 0xc0) != 0x80)
            return 0;
    if ((s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f) || (s[0] == 0xf0 && s[1] < 0x90) ||
        (s[0] == 0xf4 && s[1] > 0x8f))
        return 0; /* overlong, a surrogate, or past the last one */
    return n;
}

void page_text(FILE *out, const char *text)
{
    const unsigned char *s = (const unsigned char *)text;
    while (*s) {
        size_t n = utf8_bytes(s);
        if (!n)
            fputs("\xef\xbf\xbd", out);
        else if (*s == '&')
            fputs("&amp;", out);
        else if (*s == '<')
            fputs("&lt;", out);
        else if (*s == '>')
            fputs("&gt;", out);
        else if (*s == '"')
            fputs("&quot;", out);
        else if (*s == '\'')
            fputs("&#39;", out);
        else if ((*s < 0x20 && *s != '\n') || *s == 0x7f)
            fputc(' ', out);
        else
            fwrite(s, 1, n, out);
        s += n ? n : 1;
    }
}

/* Commas between groups of three of the digits that text starts with (after a sign). */
static struct page_number group(const char *text)
{
    struct page_number number;
    size_t digits, at = 0;
    if (*text == '-')
        number.text[at++] = *text++;
    digits = strspn(text, "0123456789");
    for (size_t i = 0; text[i] && at + 2 < sizeof number.text; i++) {
        if (i && i < digits && (digits - i) % 3 == 0)
            number.text[at++] = ',';
        number.text[at++] = text[i];
    }
    number.text[at] = 0;
    return number;
}

struct page_number page_count(uint64_t n)
{
    char text[24];
    snprintf(text, sizeof text, "%llu", (unsigned long long)n);
    return group(text);
}

struct page_number page_value(double value)
{
    char text[32];
    snprintf(text, sizeof text, fabs(value) < 1e15 && value == trunc(value) ? "%.0f" : "%.6g",
             value == 0 ? 0 : value);
    return group(text);
}

struct page_number page_percent(double share)
{
    struct page_number number;
    double percent = 100 * share;
    if (percent > 0 && percent < 0.05)
        snprintf(number.text, sizeof number.text, "< 0.1%%");
    else if (percent < 100 && percent >= 99.95)
        snprintf(number.text, sizeof number.text, "> 99.9%%");
    else
        snprintf(number.text, sizeof number.text, "%.1f%%", percent);
    return number;
}

static const uint8_t ramp[][3] = {
    {70, 60, 134}, {52, 104, 164}, {36, 146, 134}, {142, 198, 76}, {252, 232, 96}};
#define RAMP_LAST (sizeof ramp / sizeof *ramp - 1)

void page_colour(double t, uint8_t rgb[3])
{
    double place = t > 0 ? fmin(t, 1) * RAMP_LAST : 0;
    size_t i = place < RAMP_LAST ? (size_t)place : RAMP_LAST - 1;
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(ramp[i][c] + (place - (double)i) * (ramp[i + 1][c] - ramp[i][c]) + 0.5);
}

void page_colour_stops(FILE *out)
{
    for (size_t i = 0; i <= RAMP_LAST; i++)
        fprintf(out, "%s#%02x%02x%02x", i ? "," : "", ramp[i][0], ramp[i][1], ramp[i][2]);
}

static void base64(FILE *out, const unsigned char *data, size_t bytes)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < bytes; i += 3) {
        uint32_t bits = (uint32_t)data[i] << 16;
        bits |= i + 1 < bytes ? (uint32_t)data[i + 1] << 8 : 0;
        bits |= i + 2 < bytes ? data[i + 2] : 0u;
        const char text[4] = {digits[bits >> 18], digits[bits >> 12 & 63],
                              i + 1 < bytes ? digits[bits >> 6 & 63] : '=',
                              i + 2 < bytes ? digits[bits & 63] : '='};
        fwrite(text, 1, 4, out);
    }
}

int page_picture(FILE *out, const struct fmt_samples *samples, struct brick_error *err)
{
    void *png = NULL;
    size_t bytes = 0;
    int code = fmt_png_encode(samples, &png, &bytes, err);
    if (code)
        return code;
    fputs("data:image/png;base64,", out);
    base64(out, png, bytes);
    free(png);
    return 0;
}
