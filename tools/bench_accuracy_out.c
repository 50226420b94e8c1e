/* Why: rows of speed against error as a table, as CSV, and as one log-log plot: a line a variant, the Pareto
 * front marked. */
#include "bench_accuracy.h"

#include <math.h>
#include <stdio.h>

#include "figure.h"

void bench_accuracy_mark(struct bench_accuracy_row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        rows[i].pareto = true;
        for (size_t j = 0; j < count; j++) {
            double faster = rows[i].seconds.median - rows[j].seconds.median;
            double nearer = rows[i].trilinear.rmse - rows[j].trilinear.rmse;
            if (faster >= 0 && nearer >= 0 && (faster > 0 || nearer > 0))
                rows[i].pareto = false;
        }
    }
}

double bench_accuracy_order(const struct bench_accuracy_row *rows, size_t count,
                            const struct bench_variant *variant)
{
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (size_t i = 0; i < count; i++)
        if (rows[i].variant == variant && rows[i].own.rmse > 0) {
            double u = log2(rows[i].step), v = log2(rows[i].own.rmse);
            n++, x += u, y += v, xx += u * u, xy += u * v;
        }
    return n < 2 || !variant->steps ? NAN : (n * xy - x * y) / (n * xx - x * x);
}

void bench_accuracy_print(const struct bench_accuracy_row *rows, size_t count)
{
    printf("%-34s %6s %9s %10s %10s %10s %10s %12s\n", "", "step", "seconds", "max_abs", "rmse", "trilinear",
           "psnr", "samples");
    for (size_t i = 0; i < count; i++) {
        const struct bench_accuracy_row *r = &rows[i];
        printf("%-34s ", r->variant->name);
        if (r->variant->steps)
            printf("%6g ", r->step);
        else
            printf("%6s ", "-");
        printf("%9.4f %10.3g %10.3g %10.3g %10.2f %12llu%s\n", r->seconds.median, r->own.max_abs, r->own.rmse,
               r->trilinear.rmse, r->trilinear.psnr_db, (unsigned long long)r->report.samples,
               r->pareto ? " *" : "");
        if (i + 1 == count || rows[i + 1].variant != r->variant) {
            double order = bench_accuracy_order(rows, count, r->variant);
            if (!isnan(order) && r->variant->order > 0)
                printf("%-34s order %.2f, by theory %g\n", "", order, r->variant->order);
            else if (!isnan(order))
                printf("%-34s order %.2f\n", "", order);
        }
    }
    printf("max_abs, rmse: to the exact picture of the variant's own field; trilinear: rmse to that of the "
           "trilinear field.\n"
           "* no other row is both faster and nearer to the trilinear field's picture\n");
}

static void write_csv(FILE *file, const struct bench_accuracy_row *rows, size_t count)
{
    fputs("variant,step,seconds,seconds_min,seconds_max,max_abs,rmse,psnr,max_abs_trilinear,rmse_trilinear,"
          "psnr_trilinear,samples,bytes_read,pareto,order,order_theory\n",
          file);
    for (size_t i = 0; i < count; i++) {
        const struct bench_accuracy_row *r = &rows[i];
        fprintf(file, "\"%s\",%g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%llu,%llu,%d,%.3g,%g\n",
                r->variant->name, r->variant->steps ? r->step : 0.0, r->seconds.median, r->seconds.min,
                r->seconds.max, r->own.max_abs, r->own.rmse, r->own.psnr_db, r->trilinear.max_abs,
                r->trilinear.rmse, r->trilinear.psnr_db, (unsigned long long)r->report.samples,
                (unsigned long long)r->report.bytes_read, r->pareto,
                bench_accuracy_order(rows, count, r->variant), r->variant->order);
    }
}

static void write_points(FILE *file, const struct bench_accuracy_row *rows, size_t count,
                         const struct bench_variant *variant)
{
    for (size_t i = 0; i < count; i++)
        if ((variant ? rows[i].variant == variant : rows[i].pareto) && rows[i].trilinear.rmse > 0)
            fprintf(file, "%.6g %.6g\n", rows[i].seconds.median, rows[i].trilinear.rmse);
}

/* Data in the script itself, one block a line of the plot. */
static void write_script(FILE *file, const struct bench_accuracy_row *rows, size_t count, const char *title)
{
    fputs("$front << end\n", file);
    write_points(file, rows, count, NULL);
    fputs("end\n", file);
    int lines = 0;
    for (size_t i = 0; i < count; i++)
        if (!i || rows[i].variant != rows[i - 1].variant) {
            fprintf(file, "$line%d << end\n", lines++);
            write_points(file, rows, count, rows[i].variant);
            fputs("end\n", file);
        }
    fprintf(file,
            "set title \"%s\" noenhanced\nset logscale xy\nset xlabel \"seconds a frame\"\n"
            "set ylabel \"RMSE to the exact picture\"\nset grid\nset key outside right noenhanced\n"
            "set format xy \"%%g\"\n",
            title);
    fputs("plot_all = \"plot $front with points pt 6 ps 2.2 lc rgb '#999999' title 'Pareto front'", file);
    lines = 0;
    for (size_t i = 0; i < count; i++)
        if (!i || rows[i].variant != rows[i - 1].variant) {
            fprintf(file, ", $line%d with linespoints lw 1.5 pt %d title '%s'", lines, 1 + lines % 15,
                    rows[i].variant->name);
            lines++;
        }
    fputs("\"\nset terminal svg size 1100,700\nset output \"accuracy.svg\"\n@plot_all\n"
          "set terminal pngcairo size 1100,700\nset output \"accuracy.png\"\n@plot_all\n",
          file);
}

int bench_accuracy_write(const struct bench_accuracy_row *rows, size_t count, const char *title,
                         const char *folder, bool *drawn, struct brick_error *err)
{
    FILE *file;
    int code = tool_file_begin(&file, folder, "accuracy.csv", err);
    if (code)
        return code;
    write_csv(file, rows, count);
    if ((code = tool_file_finish(&file, folder, "accuracy.csv", err)) ||
        (code = tool_file_begin(&file, folder, "accuracy.gp", err)))
        return code;
    write_script(file, rows, count, title);
    if ((code = tool_file_finish(&file, folder, "accuracy.gp", err)))
        return code;
    return tool_gnuplot(folder, "accuracy.gp", drawn, err);
}
