/* Why: what one or several pictures took, told on a line and as JSON. */
#include "render_report.h"

#include <stdio.h>

#include <brick/threads.h>
#include <cjson/cJSON.h>

#include "message.h"

/* What is counted, over all frames; what is a state, of the last; seconds_frame: of a frame, on average. */
static struct vr_report sum_reports(const struct vr_report *reports, size_t count)
{
    struct vr_report sum = reports[count - 1];
    for (size_t i = 0; i + 1 < count; i++) {
        sum.passes += reports[i].passes;
        sum.bricks_loaded += reports[i].bricks_loaded;
        sum.bricks_read += reports[i].bricks_read;
        sum.bytes_read += reports[i].bytes_read;
        sum.samples += reports[i].samples;
        sum.seconds_frame += reports[i].seconds_frame;
    }
    sum.seconds_frame /= (double)count;
    return sum;
}

/* What a frame and a film have in common. */
static void add_counts(cJSON *json, const struct vr_report *report)
{
    cJSON_AddNumberToObject(json, "seconds_frame", report->seconds_frame);
    cJSON_AddNumberToObject(json, "passes", (double)report->passes);
    cJSON_AddNumberToObject(json, "bricks_loaded", (double)report->bricks_loaded);
    cJSON_AddNumberToObject(json, "bricks_read", (double)report->bricks_read);
    cJSON_AddNumberToObject(json, "bytes_read", (double)report->bytes_read);
    cJSON_AddNumberToObject(json, "samples", (double)report->samples);
}

int tool_render_json(const struct vr_report *reports, size_t count, bool final, double seconds)
{
    const struct vr_report sum = sum_reports(reports, count);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "seconds_total", seconds);
    cJSON_AddBoolToObject(json, "final", final);
    add_counts(json, &sum);
    cJSON_AddNumberToObject(json, "bricks_total", (double)sum.bricks_total);
    cJSON_AddNumberToObject(json, "bricks_active", (double)sum.bricks_active);
    cJSON_AddNumberToObject(json, "gpu_cache_bytes", (double)sum.gpu_cache_bytes);
    cJSON_AddNumberToObject(json, "gpu_cache_peak_bytes", (double)sum.gpu_cache_peak_bytes);
    cJSON_AddNumberToObject(json, "host_cache_peak_bytes", (double)sum.host_cache_peak_bytes);
    cJSON_AddStringToObject(json, "gl_renderer", sum.gl_renderer);
    cJSON_AddNumberToObject(json, "peak_rss_bytes", (double)brick_peak_rss_bytes());
    cJSON *frames = cJSON_AddArrayToObject(json, "frames");
    for (size_t i = 0; frames && i < count; i++) {
        cJSON *frame = cJSON_CreateObject();
        if (frame)
            add_counts(frame, &reports[i]);
        cJSON_AddItemToArray(frames, frame);
    }
    return tool_json_print("render", json);
}

void tool_render_summary(const char *output, const char *mode, const struct vr_report *reports, size_t count,
                         bool final, double seconds)
{
    const struct vr_report sum = sum_reports(reports, count);
    fprintf(stderr, "%s: %s, %llu of %llu bricks visible, frame %.3f s, all %.3f s%s%s%s\n", output, mode,
            (unsigned long long)sum.bricks_active, (unsigned long long)sum.bricks_total, sum.seconds_frame,
            seconds, final ? "" : ", not final", sum.gl_renderer[0] ? ", " : "", sum.gl_renderer);
}
