/* The commands of the program. Each is one cmd_*.c; argv[0] is the command's name. */
#ifndef TOOLS_COMMAND_H
#define TOOLS_COMMAND_H

enum { TOOL_DONE = 0, TOOL_FAILED = 1, TOOL_USAGE = 2 }; /* exit codes */

int cmd_convert(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_verify(int argc, char **argv);
int cmd_repair(int argc, char **argv);
int cmd_export(int argc, char **argv);
int cmd_render(int argc, char **argv);
int cmd_compare(int argc, char **argv);
int cmd_synth(int argc, char **argv);
int cmd_bench(int argc, char **argv);

#endif
