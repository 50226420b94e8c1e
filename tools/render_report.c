/* Why: a film's frames are told one by one and in sum, by the same names. */
#include "render_report.h"

#include <brick/threads.h>
#include <cjson/cJSON.h>

#include "message.h"

struct vr_report tool_render_sum(const struct vr_report *reports, size_t count)
{
    struct vr_report sum = reports[count - 1];
    for (size_t i = 0; i + 1 < count; i++) {
        sum.passes += reports[i].passes;
        sum.bricks_loaded += reports[i].bricks_loaded;
        sum.bricks_read += reports[i].bricks_read;
        sum.bytes_read += reports[i].bytes_read;
        sum.samples += reports[i].samples;
        sum.tetrahedra += reports[i].tetrahedra;
        sum.seconds_setup += reports[i].seconds_setup;
        sum.seconds_draw += reports[i].seconds_draw;
        sum.seconds_frame += reports[i].seconds_frame;
    }
    sum.seconds_frame /= (double)count;
    sum.seconds_setup /= (double)count;
    sum.seconds_draw /= (double)count;
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
    if (report->tetrahedra) {
        cJSON_AddNumberToObject(json, "tetrahedra", (double)report->tetrahedra);
        cJSON_AddNumberToObject(json, "seconds_setup", report->seconds_setup);
        cJSON_AddNumberToObject(json, "seconds_draw", report->seconds_draw);
    }
}

int tool_render_json(const struct vr_report *reports, size_t count, bool final, double seconds)
{
    const struct vr_report sum = tool_render_sum(reports, count);
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
