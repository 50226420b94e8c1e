/* Why: parsing, messages and --help come from the same rows, so they cannot disagree. Usage errors are one
 * line on stderr and exit code 2. */
#include "options.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "message.h"

#define MAX_OPTIONS 64

static void print_row(const struct tool_option *option)
{
    char left[64];
    snprintf(left, sizeof left, "%c%c%c --%s%s%s", option->letter ? '-' : ' ',
             option->letter ? option->letter : ' ', option->letter ? ',' : ' ', option->name,
             option->value ? " " : "", option->value ? option->value : "");
    printf("  %-34s", left);
    if (strlen(left) > 33)
        printf("\n  %-34s", "");
    for (const char *p = option->help; *p; p++)
        if (*p == '\n')
            printf("\n  %-34s", "");
        else
            putchar(*p);
    putchar('\n');
}

static void print_help(const struct tool_usage *usage)
{
    printf("usage: brick %s %s\n\n%s\n\n", usage->command, usage->arguments, usage->summary);
    for (size_t i = 0; i < usage->options.count; i++)
        print_row(&usage->options.row[i]);
    printf("      --help\n");
}

static int apply(const struct tool_usage *usage, const struct tool_option *option, const char *text)
{
    if (option->given)
        *option->given = true;
    if (!option->parse) {
        *(bool *)option->target = true;
        return -1;
    }
    const char *wrong = option->parse(text, option->target, &option->limits);
    if (!wrong)
        return -1;
    return tool_misuse(usage->command, "--%s takes %s; '%s' %s", option->name, option->value, text, wrong);
}

int tool_options(const struct tool_usage *usage, int argc, char **argv, int *first)
{
    struct option rows[MAX_OPTIONS + 2] = {0};
    char letters[2 * MAX_OPTIONS + 2] =
        ":"; /* a leading colon tells a missing value from an unknown option */
    size_t n = usage->options.count, letter_end = 1;
    bool seen[MAX_OPTIONS] = {false};
    const int help = 1000 + MAX_OPTIONS;

    for (size_t i = 0; i < n; i++) {
        const struct tool_option *option = &usage->options.row[i];
        rows[i] = (struct option){option->name, option->value ? required_argument : no_argument, NULL,
                                  1000 + (int)i};
        if (option->letter) {
            letters[letter_end++] = option->letter;
            if (option->value)
                letters[letter_end++] = ':';
        }
    }
    rows[n] = (struct option){"help", no_argument, NULL, help};

    opterr = 0;
    optind = 0; /* glibc: start over, also for a second table in one process */
    for (;;) {
        int c = getopt_long(argc, argv, letters, rows, NULL);
        if (c == -1)
            break;
        if (c == help) {
            print_help(usage);
            return TOOL_DONE;
        }
        if (c == ':')
            return tool_misuse(usage->command, "%s needs a value", argv[optind - 1]);
        const struct tool_option *option = NULL;
        for (size_t i = 0; i < n; i++)
            if (c == 1000 + (int)i || (c != '?' && c == usage->options.row[i].letter))
                option = &usage->options.row[i];
        if (!option)
            return tool_misuse(usage->command, "unknown or ambiguous option, or a flag with a value: %s",
                               argv[optind > 1 ? optind - 1 : 1]);
        seen[option - usage->options.row] = true;
        int code = apply(usage, option, optarg);
        if (code >= 0)
            return code;
    }
    int positional = argc - optind;
    if (positional < usage->positional.min)
        return tool_misuse(usage->command, "expected %s", usage->positional.what);
    if (positional > usage->positional.max)
        return tool_misuse(usage->command, "expected %s, and '%s' is one too many", usage->positional.what,
                           argv[optind + usage->positional.max]);
    for (const struct tool_option *row = usage->options.row; row < usage->options.row + n; row++)
        if (row->required && !seen[row - usage->options.row])
            return tool_misuse(usage->command, row->letter ? "no %s: -%.1s %s" : "no %s: --%s %s", row->name,
                               row->letter ? &row->letter : row->name, row->value);
    *first = optind;
    return -1;
}
