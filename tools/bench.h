/* The measurements of `brick bench`; argv[0] is the measurement's name. */
#ifndef TOOLS_BENCH_H
#define TOOLS_BENCH_H

#include <stddef.h>

int bench_render(int argc, char **argv);
int bench_hits(int argc, char **argv);
int bench_features(int argc, char **argv);
int bench_isotrace(int argc, char **argv);
int bench_convert(int argc, char **argv);
int bench_codecs(int argc, char **argv);
int bench_bricks(int argc, char **argv);
int bench_accuracy(int argc, char **argv);
int bench_peers(int argc, char **argv);
int bench_papers(int argc, char **argv);

#define BENCH_REPEAT_MAX 1000
/* Sorts the n >= 1 values. */
struct bench_spread {
    double median, min, max;
};
struct bench_spread bench_spread(double *values, size_t n);

#endif
