/* `brick info --report`: one self-contained HTML page, and the sections it is made of. */
#ifndef TOOLS_REPORT_H
#define TOOLS_REPORT_H

#include <stdio.h>

#include "inventory.h"
#include "survey.h"

/* Write the page to path, which appears when it is complete. Same bytes for every number of threads. */
int report_write(const struct inventory *inventory, const char *path, unsigned threads, bool quiet,
                 struct brick_error *err);

void report_style(FILE *out);
void report_facts(FILE *out, const struct inventory *inventory);
int report_planes(FILE *out, const struct inventory *inventory, const struct survey *survey,
                  struct brick_error *err);
int report_charts(FILE *out, const struct inventory *inventory, const struct survey *survey,
                  struct brick_error *err);
void report_levels(FILE *out, const struct inventory *inventory);
void report_heaviest(FILE *out, const struct inventory *inventory);

#endif
