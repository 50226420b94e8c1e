/* Why: the program `brick` is this table; each command is one file. */
#include <stdio.h>
#include <string.h>

#include "command.h"

static const struct command {
    const char *name;
    const char *summary;
    int (*run)(int argc, char **argv);
} commands[] = {
    {"convert", "turn a volume into a .brick file", cmd_convert},
    {"info", "say what is in a .brick file", cmd_info},
    {"verify", "check every checksum, range and border of a .brick file", cmd_verify},
    {"repair", "make a whole .brick file of a damaged one", cmd_repair},
    {"export", "write a .brick file's voxels as raw, NRRD or MetaImage", cmd_export},
    {"render", "make a picture of a .brick file", cmd_render},
    {"compare", "measure the difference of two pictures", cmd_compare},
    {"synth", "make a test volume of any size", cmd_synth},
    {"bench", "measure rendering and conversion", cmd_bench},
};
#define COMMANDS (sizeof commands / sizeof *commands)

static void print_help(FILE *out)
{
    fprintf(out, "usage: brick COMMAND [OPTIONS]\n\n");
    for (size_t i = 0; i < COMMANDS; i++)
        fprintf(out, "  %-10s%s\n", commands[i].name, commands[i].summary);
    fprintf(out, "\n'brick COMMAND --help' lists a command's options. 'brick --version' prints the version.\n"
                 "Exit codes: 0 done, 1 failed, 2 wrong usage.\n");
}

static const struct command *find(const char *name)
{
    for (size_t i = 0; i < COMMANDS; i++)
        if (!strcmp(name, commands[i].name))
            return &commands[i];
    return NULL;
}

static int unknown(const char *name)
{
    const char *near = NULL; /* the longest same start: most slips are at the end */
    size_t alike = 1;
    for (size_t i = 0; i < COMMANDS; i++) {
        size_t n = 0;
        while (name[n] && name[n] == commands[i].name[n])
            n++;
        if (n > alike) {
            alike = n;
            near = commands[i].name;
        }
    }
    if (near)
        fprintf(stderr, "brick: unknown command '%s'; did you mean '%s'? See 'brick help'\n", name, near);
    else
        fprintf(stderr, "brick: unknown command '%s'; see 'brick help'\n", name);
    return TOOL_USAGE;
}

static int run(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : NULL;
    if (!name) {
        print_help(stderr);
        return TOOL_USAGE;
    }
    if (!strcmp(name, "--version")) {
        printf("brick %s\n", BRICK_VERSION);
        return TOOL_DONE;
    }
    if (!strcmp(name, "help") || !strcmp(name, "--help") || !strcmp(name, "-h")) {
        const struct command *of = argc > 2 ? find(argv[2]) : NULL;
        if (argc > 2 && !of)
            return unknown(argv[2]);
        if (of)
            return of->run(2, (char *[]){argv[2], (char[]){"--help"}, NULL});
        print_help(stdout);
        return TOOL_DONE;
    }
    const struct command *command = find(name);
    return command ? command->run(argc - 1, argv + 1) : unknown(name);
}

int main(int argc, char **argv)
{
    int code = run(argc, argv);
    /* A full disk or a closed pipe behind stdout is a failure too. */
    if ((fflush(stdout) || ferror(stdout)) && code == TOOL_DONE) {
        perror("brick: cannot write to stdout");
        code = TOOL_FAILED;
    }
    return code;
}
