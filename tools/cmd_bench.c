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

int cmd_bench(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    if (!strcmp(name, "render"))
        return bench_render(argc - 1, argv + 1);
    if (!strcmp(name, "convert"))
        return bench_convert(argc - 1, argv + 1);
    if (!strcmp(name, "isotrace"))
        return bench_isotrace(argc - 1, argv + 1);
    if (!strcmp(name, "codecs"))
        return bench_codecs(argc - 1, argv + 1);
    if (!strcmp(name, "accuracy"))
        return bench_accuracy(argc - 1, argv + 1);
    if (!strcmp(name, "--help")) {
        puts("usage: brick bench NAME ...\n\n"
             "  render FILE    seconds per frame in the modes dvr, shaded, iso and mip, and of isotrace\n"
             "  accuracy FILE  speed against error of every method, at several steps\n"
             "  isotrace FILE  isosurfaces on the CPU: where the time goes, cores, layouts, hierarchy\n"
             "  convert SRC    conversion against a plain copy of the same file\n"
             "  codecs FILE... every codec's ratio and speed on the bricks of .brick files\n\n"
             "'brick bench NAME --help' lists the options.");
        return TOOL_DONE;
    }
    return tool_misuse("bench", "expected a measurement, render, accuracy, isotrace, convert or codecs%s%s",
                       *name ? ", not " : "", name);
}
