/* Why: convert and synth differ only in where the voxels come from. */
#include "building.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include <brick/threads.h>
#include <brick/volume.h>
#include <cjson/cJSON.h>

#include "message.h"
#include "progress.h"

const char *const tool_downsample_names[] = {"mean", "nearest", NULL};

void tool_building_init(struct tool_building *building)
{
    *building = (struct tool_building){.params = brick_build_defaults,
                                       .downsample = brick_build_defaults.nearest ? 1 : 0,
                                       .codec_level = (uint32_t)brick_build_defaults.codec_level};
}

int tool_building_check(const char *command, const struct tool_building *building)
{
    const struct brick_build_params *params = &building->params;
    if (brick_codec_is_lossy(params->codec) && !(params->tolerance > 0))
        return tool_misuse(command, "--codec %s needs --tolerance E", brick_codec_name(params->codec));
    if (!brick_codec_is_lossy(params->codec) && params->tolerance > 0)
        return tool_misuse(command, "--tolerance goes with --codec zfp; codec %s changes no value",
                           brick_codec_name(params->codec));
    return -1;
}

static int print_json(const char *command, const struct brick_build_report *report)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "input_bytes", (double)report->input_bytes);
    cJSON_AddNumberToObject(json, "output_bytes", (double)report->output_bytes);
    cJSON_AddNumberToObject(json, "bricks", (double)report->bricks);
    cJSON_AddNumberToObject(json, "bricks_empty", (double)report->bricks_constant);
    cJSON_AddNumberToObject(json, "bricks_kept", (double)report->bricks_kept);
    cJSON_AddNumberToObject(json, "bricks_decoded", (double)report->bricks_decoded);
    cJSON_AddNumberToObject(json, "source_bytes_read", (double)report->source_bytes);
    cJSON_AddNumberToObject(json, "seconds", report->seconds);
    cJSON_AddNumberToObject(json, "bytes_per_second",
                            report->seconds > 0 ? (double)report->input_bytes / report->seconds : 0);
    cJSON_AddNumberToObject(json, "memory_bytes", (double)report->memory_bytes);
    cJSON_AddNumberToObject(json, "peak_rss_bytes", (double)brick_peak_rss_bytes());
    return tool_json_print(command, json);
}

static void print_summary(const char *path, const struct brick_build_report *report)
{
    fprintf(stderr, "%s: %s -> %s, %llu bricks (%llu constant", path,
            tool_size_text(report->input_bytes).text, tool_size_text(report->output_bytes).text,
            (unsigned long long)report->bricks, (unsigned long long)report->bricks_constant);
    if (report->bricks_kept)
        fprintf(stderr, ", %llu kept", (unsigned long long)report->bricks_kept);
    fprintf(stderr, "), %.2f s", report->seconds);
    if (report->seconds > 0)
        fprintf(stderr, ", %.0f MB/s", (double)report->input_bytes / report->seconds * 1e-6);
    fputc('\n', stderr);
}

/* Said even with --quiet: the user may not know that all pictures will be empty. */
static int note_if_empty(const char *command, const char *path)
{
    struct brick_volume *volume = NULL;
    struct brick_error err = {0};
    if (brick_volume_open(&volume, path, &err))
        return tool_fail(command, &err);
    const struct brick_stats *stats = brick_volume_stats(volume);
    if (!stats->count)
        tool_note(command, "%s: no voxel is finite (%llu are NaN or Inf), nothing in it can be seen", path,
                  (unsigned long long)stats->nonfinite);
    brick_volume_close(&volume);
    return 0;
}

static void show(void *context, uint64_t slices_done, uint64_t slices, enum brick_build_stage limit)
{
    struct tool_progress *progress = context;
    progress->limit = brick_build_stage_name(limit);
    tool_progress_update(progress, slices_done, slices);
}

int tool_build(const char *command, struct tool_building *building, struct brick_source *source,
               const char *path)
{
    struct brick_build_report report = {0};
    struct brick_error err = {0};
    struct tool_progress progress;
    const char *type = brick_type_name(source->type);
    const uint64_t *dims = source->geometry.dims;

    building->params.nearest = building->downsample == 1;
    building->params.codec_level = (int)building->codec_level;
    building->params.progress = show;
    building->params.progress_context = &progress;
    tool_progress_init(&progress, command, dims[0] * dims[1] * dims[2] * brick_type_bytes(source->type),
                       building->quiet);
    int code = brick_build(source, path, &building->params, &report, &err);
    tool_progress_finish(&progress);
    if (code)
        return tool_fail(command, &err);
    if (report.converted)
        tool_note(command, "%s values are stored as f32%s", type,
                  building->params.round_to_f32 ? ", rounded where f32 cannot hold them"
                                                : ", all of them exactly");
    code = note_if_empty(command, path);
    if (code)
        return code;
    if (!building->quiet)
        print_summary(path, &report);
    return building->json ? print_json(command, &report) : 0;
}

bool tool_ends_in(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    return n > m && !strcasecmp(path + n - m, ending);
}
