/* A paper's table again: figures measured here beside the paper's. */
#ifndef TOOLS_PAPERS_TABLE_H
#define TOOLS_PAPERS_TABLE_H

#include <stddef.h>
#include <stdio.h>

#include <brick/error.h>

enum { PAPER_COLUMNS = 12, PAPER_ROWS = 64 };

struct paper_row {
    char label[64];
    double value[PAPER_COLUMNS]; /* NaN: there is none */
};

struct paper_table {
    const char *name;                  /* of its files: "scharsach-1" */
    const char *title, *note;          /* note: lines below the table; may be NULL */
    const char *column[PAPER_COLUMNS]; /* headings */
    size_t columns;
    int ours, paper; /* columns of ratios that a plot shows beside each other; equal: no plot */
    struct paper_row row[PAPER_ROWS];
    size_t rows;
};

/* The next row, all of whose values are NaN. The last one again when the table is full. */
struct paper_row *paper_row_add(struct paper_table *table, const char *label);

void paper_table_print(const struct paper_table *table, FILE *file);
/* folder/NAME.csv and, where there are ratios to show and gnuplot is installed, NAME.svg and NAME.png. */
int paper_table_write(const struct paper_table *table, const char *folder, struct brick_error *err);

#endif
