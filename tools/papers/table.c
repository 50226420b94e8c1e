/* Why: the papers' machines are gone, so seconds tell little; ratios within a table do. Each is measured in
 * one run, and stands beside the paper's. */
#include "table.h"

#include <math.h>
#include <string.h>

#include "../figure.h"

struct paper_row *paper_row_add(struct paper_table *table, const char *label)
{
    struct paper_row *row = &table->row[table->rows < PAPER_ROWS ? table->rows++ : PAPER_ROWS - 1];
    snprintf(row->label, sizeof row->label, "%s", label);
    for (size_t c = 0; c < PAPER_COLUMNS; c++)
        row->value[c] = NAN;
    return row;
}

void paper_table_print(const struct paper_table *table, FILE *file)
{
    fprintf(file, "\n%s\n%-34s", table->title, "");
    for (size_t c = 0; c < table->columns; c++)
        fprintf(file, " %13s", table->column[c]);
    fputc('\n', file);
    for (size_t r = 0; r < table->rows; r++) {
        fprintf(file, "%-34s", table->row[r].label);
        for (size_t c = 0; c < table->columns; c++)
            if (isnan(table->row[r].value[c]))
                fprintf(file, " %13s", "-");
            else
                fprintf(file, " %13.4g", table->row[r].value[c]);
        fputc('\n', file);
    }
    if (table->note)
        fprintf(file, "%s\n", table->note);
}

static void write_csv(const struct paper_table *table, FILE *file)
{
    fputs("row", file);
    for (size_t c = 0; c < table->columns; c++)
        fprintf(file, ",\"%s\"", table->column[c]);
    fputc('\n', file);
    for (size_t r = 0; r < table->rows; r++) {
        fprintf(file, "\"%s\"", table->row[r].label);
        for (size_t c = 0; c < table->columns; c++)
            if (isnan(table->row[r].value[c]))
                fputc(',', file);
            else
                fprintf(file, ",%.6g", table->row[r].value[c]);
        fputc('\n', file);
    }
}

/* Bars in pairs: ours and the paper's. */
static void write_script(const struct paper_table *table, FILE *file)
{
    fputs("$ratios << end\n", file);
    for (size_t r = 0; r < table->rows; r++) {
        const double ours = table->row[r].value[table->ours], paper = table->row[r].value[table->paper];
        if (!isnan(ours) || !isnan(paper))
            fprintf(file, "\"%s\" %g %g\n", table->row[r].label, ours, paper);
    }
    fprintf(file,
            "end\nset title \"%s\" noenhanced\nset ylabel \"%s\" noenhanced\nset style data histograms\n"
            "set style fill solid 0.7\nset xtics rotate by -30 noenhanced\nset grid ytics\nset yrange [0:*]\n"
            "set key top left noenhanced\nset datafile missing 'nan'\n"
            "plot_all = \"plot $ratios using 2:xtic(1) title 'here', '' using 3 title 'paper'\"\n"
            "set terminal svg size 900,500\nset output \"%s.svg\"\n@plot_all\n"
            "set terminal pngcairo size 900,500\nset output \"%s.png\"\n@plot_all\n",
            table->title, table->column[table->ours], table->name, table->name);
}

static int write_file(const struct paper_table *table, const char *folder, const char *ending,
                      void (*write)(const struct paper_table *, FILE *), struct brick_error *err)
{
    char name[128];
    FILE *file;
    snprintf(name, sizeof name, "%s.%s", table->name, ending);
    int code = tool_file_begin(&file, folder, name, err);
    if (code)
        return code;
    write(table, file);
    return tool_file_finish(&file, folder, name, err);
}

int paper_table_write(const struct paper_table *table, const char *folder, struct brick_error *err)
{
    char script[128];
    bool drawn;
    int code = write_file(table, folder, "csv", write_csv, err);
    if (code || table->ours == table->paper)
        return code;
    snprintf(script, sizeof script, "%s.gp", table->name);
    code = write_file(table, folder, "gp", write_script, err);
    return code ? code : tool_gnuplot(folder, script, &drawn, err);
}
