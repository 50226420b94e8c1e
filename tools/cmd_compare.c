/* Why: `brick compare`: how far apart two pictures are, in numbers. A difference is an answer, not a failure.
 */
#include <math.h>
#include <stdio.h>

#include <brick/image.h>
#include <cjson/cJSON.h>
#include <formats/formats.h>

#include "command.h"
#include "message.h"
#include "options.h"

/* JSON has no infinity: a null PSNR means that the pictures are equal. */
static int print_json(const struct brick_image_difference *difference, const struct brick_image *image)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "max_abs", difference->max_abs);
    cJSON_AddNumberToObject(json, "rmse", difference->rmse);
    cJSON_AddNumberToObject(json, "psnr", difference->psnr_db);
    cJSON_AddNumberToObject(json, "max_x", difference->max_x);
    cJSON_AddNumberToObject(json, "max_y", difference->max_y);
    cJSON_AddNumberToObject(json, "max_channel", difference->max_channel);
    cJSON_AddNumberToObject(json, "pixels_differing", (double)difference->pixels_differing);
    cJSON_AddNumberToObject(json, "covered_only_a", (double)difference->covered_only_a);
    cJSON_AddNumberToObject(json, "covered_only_b", (double)difference->covered_only_b);
    cJSON_AddNumberToObject(json, "width", image->width);
    cJSON_AddNumberToObject(json, "height", image->height);
    return tool_json_print("compare", json);
}

static void print_text(const struct brick_image_difference *difference, const struct brick_image *image)
{
    printf("max_abs  %.9g", difference->max_abs);
    if (difference->pixels_differing)
        printf("  (pixel %u,%u, channel %c)", difference->max_x, difference->max_y,
               "RGBA"[difference->max_channel & 3]);
    printf("\nrmse     %.9g\n", difference->rmse);
    if (isinf(difference->psnr_db))
        printf("psnr     infinite\n");
    else
        printf("psnr     %.2f dB\n", difference->psnr_db);
    printf("pixels   %llu of %llu differ\n", (unsigned long long)difference->pixels_differing,
           (unsigned long long)image->width * image->height);
    printf("covered  %llu only in the first, %llu only in the second\n",
           (unsigned long long)difference->covered_only_a, (unsigned long long)difference->covered_only_b);
}

static int compare(const char *path_a, const char *path_b, bool json)
{
    struct brick_image a = {0}, b = {0};
    struct brick_image_difference difference;
    struct brick_error err = {0};

    int code = fmt_image_read(&a, path_a, &err);
    if (!code)
        code = fmt_image_read(&b, path_b, &err);
    if (!code)
        code = brick_image_compare(&a, &b, &difference, &err);
    if (code)
        code = tool_fail("compare", &err);
    else if (json)
        code = print_json(&difference, &a);
    else
        print_text(&difference, &a);
    brick_image_finish(&a);
    brick_image_finish(&b);
    return code;
}

int cmd_compare(int argc, char **argv)
{
    bool json = false;
    int first = 0;
    const struct tool_option options[] = {TOOL_OPTION_JSON(&json)};
    const struct tool_usage usage = {
        .command = "compare",
        .arguments = "A.exr B.exr [OPTIONS]",
        .summary = "Measure the difference of two pictures over premultiplied linear RGBA.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {2, 2, "two pictures"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    return code >= 0 ? code : compare(argv[first], argv[first + 1], json);
}
