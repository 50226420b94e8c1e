/* Why: `brick repair`: a damaged file becomes a whole one, and what could not be had back is said brick by
 * brick. */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include <brick/repair.h>
#include <cjson/cJSON.h>

#include "building.h"
#include "command.h"
#include "message.h"
#include "options.h"
#include "progress.h"

struct output {
    bool json;
    cJSON *losses;
};

static void lost(void *context, const struct brick_loss *loss)
{
    const struct output *output = context;
    if (output->json) {
        cJSON *object = cJSON_CreateObject();
        const double at[3] = {(double)loss->at[0], (double)loss->at[1], (double)loss->at[2]};
        cJSON_AddNumberToObject(object, "brick", (double)loss->brick);
        cJSON_AddItemToObject(object, "at", cJSON_CreateDoubleArray(at, 3));
        cJSON_AddNumberToObject(object, "voxels", loss->voxels);
        cJSON_AddNumberToObject(object, "from_neighbours", loss->from_neighbours);
        cJSON_AddNumberToObject(object, "from_level", loss->from_level);
        cJSON_AddItemToArray(output->losses, object);
        return;
    }
    printf("brick %llu (%llu,%llu,%llu) is lost: ", (unsigned long long)loss->brick,
           (unsigned long long)loss->at[0], (unsigned long long)loss->at[1], (unsigned long long)loss->at[2]);
    if (loss->from_neighbours)
        printf("%u of its %u voxels are in its neighbours' borders, ", loss->from_neighbours, loss->voxels);
    if (loss->from_neighbours == loss->voxels)
        printf("so nothing is missing\n");
    else if (loss->from_level)
        printf("%s from level %u\n", loss->from_neighbours ? "the others" : "all are", loss->from_level);
    else
        printf("%s unknown\n", loss->from_neighbours ? "the others" : "all are");
}

static const char *const parts[] = {"header", "level table", "index", "statistics", "provenance"};

static void print_text(const char *path, const char *to, const struct brick_repair_report *r)
{
    const struct brick_damage *d = &r->damage;
    const bool damaged[] = {d->header, d->levels, d->index, d->stats, d->provenance};
    char list[128] = "";
    for (size_t i = 0; i < TOOL_COUNT(parts); i++)
        if (damaged[i]) {
            strcat(list, *list ? ", " : "");
            strcat(list, parts[i]);
        }
    fprintf(stderr,
            "%s: %s; %llu bricks: %llu of level 0 lost, %llu of coarser levels made again -> %s, %s\n", path,
            *list ? list : "tables whole", (unsigned long long)r->bricks, (unsigned long long)r->lost,
            (unsigned long long)r->rebuilt, to, tool_size_text(r->output_bytes).text);
    if (r->unconfirmed)
        tool_note("repair",
                  "%llu bricks of level 0 were found without their checksums; they agree with what is "
                  "around them",
                  (unsigned long long)r->unconfirmed);
}

static void print_notes(const char *to, const struct brick_repair_report *r)
{
    if (r->guessed_downsample)
        tool_note("repair",
                  "coarser levels are made as means; if these are labels, repair again with --downsample "
                  "nearest");
    if (r->tolerance > r->tolerance_was)
        tool_note("repair", "%s: bricks made again may be off by %g, twice the tolerance of the file", to,
                  r->tolerance);
}

static int print_json(const struct brick_repair_report *r, cJSON *losses)
{
    const struct brick_damage *d = &r->damage;
    const bool damaged[] = {d->header, d->levels, d->index, d->stats, d->provenance};
    cJSON *json = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(json, "damaged");
    for (size_t i = 0; i < TOOL_COUNT(parts); i++)
        if (damaged[i])
            cJSON_AddItemToArray(list, cJSON_CreateString(parts[i]));
    cJSON_AddNumberToObject(json, "bricks", (double)r->bricks);
    cJSON_AddNumberToObject(json, "bricks_lost", (double)r->lost);
    cJSON_AddNumberToObject(json, "bricks_rebuilt", (double)r->rebuilt);
    cJSON_AddNumberToObject(json, "bricks_unconfirmed", (double)r->unconfirmed);
    cJSON_AddNumberToObject(json, "tolerance", r->tolerance);
    cJSON_AddNumberToObject(json, "output_bytes", (double)r->output_bytes);
    cJSON_AddItemToObject(json, "lost", losses);
    return tool_json_print("repair", json);
}

static bool same_file(const char *a, const char *b)
{
    struct stat sa, sb;
    return !stat(a, &sa) && !stat(b, &sb) && sa.st_dev == sb.st_dev && sa.st_ino == sb.st_ino;
}

static int repair(const char *path, const char *to, struct brick_repair_params *params, bool json, bool quiet)
{
    struct output output = {.json = json, .losses = json ? cJSON_CreateArray() : NULL};
    struct tool_progress progress;
    struct brick_repair_report report;
    struct brick_error err = {0};
    tool_progress_init(&progress, "repair", 0, quiet);
    params->lost = lost;
    params->lost_context = &output;
    params->progress = tool_progress_update;
    params->progress_context = &progress;
    int code = brick_repair(path, to, params, &report, &err);
    tool_progress_finish(&progress);
    if (code) {
        cJSON_Delete(output.losses);
        return tool_fail("repair", &err);
    }
    if (!quiet)
        print_text(path, to, &report);
    print_notes(to, &report);
    if (json && (code = print_json(&report, output.losses)))
        return code;
    if (!report.lost && !report.damage.provenance)
        return TOOL_DONE;
    if (report.lost)
        brick_fail(&err, BRICK_ERR_CHECKSUM, "%s: %llu bricks of level 0 are lost%s; %s has all the others",
                   path, (unsigned long long)report.lost,
                   report.damage.provenance ? ", and the provenance" : "", to);
    else
        brick_fail(&err, BRICK_ERR_CHECKSUM, "%s: the provenance is lost; %s has everything else", path, to);
    return tool_fail("repair", &err);
}

int cmd_repair(int argc, char **argv)
{
    static const char *const downsample[] = {"found", "mean", "nearest", NULL};
    struct brick_repair_params params = {.memory_bytes = brick_build_defaults.memory_bytes};
    const char *to = NULL;
    bool json = false, quiet = false;
    int first = 0, how = 0;
    const struct tool_option options[] = {
        {"output", .letter = 'o', .value = "OUT.brick", .parse = tool_parse_text, .target = &to,
         .required = true, .help = "the file to write (required)"},
        {"downsample", .value = "HOW", .parse = tool_parse_choice, .target = &how,
         .limits = {.choices = downsample},
         .help = "how coarser levels are made where they are lost: mean,\nnearest (labels), or as found in "
                 "what is "
                 "left (default)"},
        {"memory", .value = "SIZE", .parse = tool_parse_bytes, .target = &params.memory_bytes,
         .help = "budget of the buffers, such as 512M"},
        TOOL_OPTION_THREADS(&params.threads),
        TOOL_OPTION_JSON(&json),
        TOOL_OPTION_QUIET(&quiet)};
    const struct tool_usage usage = {
        .command = "repair",
        .arguments = "FILE -o OUT.brick [OPTIONS]",
        .summary =
            "Make a whole file of a damaged one: tables and coarser levels are made again from level 0.\n"
            "Bricks of level 0 that are lost are listed, and the exit code is then 1.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1, "one FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    if (!tool_ends_in(to, ".brick"))
        return tool_misuse("repair", "the output '%s' does not end in .brick", to);
    if (same_file(argv[first], to))
        return tool_misuse("repair", "the output is the damaged file itself, the only copy of what is left");
    params.downsample = (enum brick_downsample)how;
    return repair(argv[first], to, &params, json, quiet);
}
