/* Speed against error: rows of variant x step (bench_accuracy.c measures them, bench_accuracy_out.c shows
 * them). */
#ifndef TOOLS_BENCH_ACCURACY_H
#define TOOLS_BENCH_ACCURACY_H

#include <stdbool.h>
#include <stddef.h>

#include <brick/image.h>
#include <renderer/renderer.h>

#include "bench.h"

/* A way to draw, measured at several steps. */
struct bench_variant {
    const char *name;
    struct vr_quality quality; /* all but the step */
    enum vr_filter filter;
    bool cpu;            /* without OpenGL */
    enum vr_field field; /* what it converges to */
    double order;        /* of convergence, by theory; 0: none is promised */
    bool steps;          /* has a step; otherwise it is one row */
};

struct bench_accuracy_row {
    const struct bench_variant *variant;
    double step;
    struct bench_spread seconds;
    struct brick_image_difference own,
        trilinear; /* to the exact picture of its own field, and of the trilinear one */
    struct vr_report report;
    bool pareto; /* no other row is both faster and nearer to the trilinear field's picture */
};

/* Mark the rows that no other row beats. */
void bench_accuracy_mark(struct bench_accuracy_row *rows, size_t count);
/* Measured order of a variant: the slope of log rmse (own field) over log step, least squares; NaN below two
 * steps. */
double bench_accuracy_order(const struct bench_accuracy_row *rows, size_t count,
                            const struct bench_variant *variant);

void bench_accuracy_print(const struct bench_accuracy_row *rows, size_t count);
/* accuracy.csv, accuracy.gp and, by gnuplot, accuracy.svg and accuracy.png. *drawn: gnuplot was there. */
int bench_accuracy_write(const struct bench_accuracy_row *rows, size_t count, const char *title,
                         const char *folder, bool *drawn, struct brick_error *err);

#endif
