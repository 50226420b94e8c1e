/* Small pieces of an HTML page: text, numbers, colours, pictures. All write to a stream in memory, whose
 * state tells in the end whether memory sufficed. */
#ifndef TOOLS_PAGE_H
#define TOOLS_PAGE_H

#include <stdint.h>
#include <stdio.h>

#include <formats/formats.h>

/* With & < > and quotes escaped, control characters but newlines as spaces, and what is not UTF-8 as U+FFFD.
 */
void page_text(FILE *out, const char *text);

struct page_number {
    char text[48];
};
/* "1,234,567" */
struct page_number page_count(uint64_t n);
/* Up to six digits that matter, thousands separated: "-1,024", "0.9375", "1.5e+09". */
struct page_number page_value(double value);
/* "12.3%"; what is not 0 or all of it never looks like that. */
struct page_number page_percent(double share);

/* t in [0,1], from dark blue over green to yellow; lightness grows with t. */
void page_colour(double t, uint8_t rgb[3]);
/* The same colours for CSS: "#rrggbb,#rrggbb,..." */
void page_colour_stops(FILE *out);

/* "data:image/png;base64,..." */
int page_picture(FILE *out, const struct fmt_samples *samples, struct brick_error *err);

#endif
