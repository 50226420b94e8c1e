/* A measurement's folder: CSV tables, and plots drawn by gnuplot where it is installed. */
#ifndef TOOLS_FIGURE_H
#define TOOLS_FIGURE_H

#include <stdbool.h>
#include <stdio.h>

#include <brick/error.h>

/* Make the folder unless it is there. */
int tool_folder_make(const char *folder, struct brick_error *err);

/* Begin folder/name; finish checks that all of it was written, and closes. */
int tool_file_begin(FILE **file, const char *folder, const char *name, struct brick_error *err);
int tool_file_finish(FILE **file, const char *folder, const char *name, struct brick_error *err);

/* Run gnuplot on folder/script, in the folder. *drawn: false where it is not installed. */
int tool_gnuplot(const char *folder, const char *script, bool *drawn, struct brick_error *err);

#endif
