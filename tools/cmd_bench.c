/* Why: `brick bench`: the project's own measurements, so that a figure in the documents is one command away.
 * What is compared is measured in turns in one run, and the median is reported. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "command.h"
#include "message.h"

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct bench_spread bench_spread(double *values, size_t n)
{
    qsort(values, n, sizeof *values, ascending);
    return (struct bench_spread){
        .median = (values[(n - 1) / 2] + values[n / 2]) / 2, .min = values[0], .max = values[n - 1]};
}

static const struct {
    const char *name, *help;
    int (*run)(int argc, char **argv);
} measurements[] = {
    {"render", "FILE    seconds per frame in the modes dvr, shaded, iso and mip, and of isotrace",
     bench_render},
    {"accuracy", "FILE  speed against error of every method, at several steps", bench_accuracy},
    {"features", "FILE  what features of the raycaster cost a frame, and multipass, in turns",
     bench_features},
    {"hits", "FILE      isosurface hits of the raycaster against exact ones", bench_hits},
    {"papers", "         the tables of the five papers again", bench_papers},
    {"peers", "FILE     the same pictures by VTK's ways, frame by frame in turns", bench_peers},
    {"isotrace", "FILE  isosurfaces on the CPU: where the time goes, cores, layouts, hierarchy",
     bench_isotrace},
    {"convert", "SRC    conversion against a plain copy of the same file", bench_convert},
    {"bricks", "SRC     what the brick's edge costs, from conversion to pictures", bench_bricks},
    {"codecs", "FILE... every codec's ratio and speed on the bricks of .brick files", bench_codecs},
};

int cmd_bench(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    for (size_t i = 0; i < sizeof measurements / sizeof *measurements; i++)
        if (!strcmp(name, measurements[i].name))
            return measurements[i].run(argc - 1, argv + 1);
    if (!strcmp(name, "--help")) {
        puts("usage: brick bench NAME ...\n");
        for (size_t i = 0; i < sizeof measurements / sizeof *measurements; i++)
            printf("  %s %s\n", measurements[i].name, measurements[i].help);
        puts("\n'brick bench NAME --help' lists the options.");
        return TOOL_DONE;
    }
    return tool_misuse("bench", "expected the name of a measurement%s%s", *name ? ", not " : "", name);
}
