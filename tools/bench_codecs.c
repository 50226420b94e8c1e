/* Why: which codec is worth its time is a matter of the data, so every codec encodes and decodes the same
 * bricks of the given files, in turns, in one thread, from memory to memory. What is measured is what a
 * payload is: voxels with borders, and macrocell ranges. Constant bricks have none and are left out. Time is
 * the thread's own on its core, not the clock's on the wall: other programs then disturb little. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <brick/threads.h>
#include <brick/volume.h>
#include <cjson/cJSON.h>

#include "bench.h"
#include "message.h"
#include "options.h"

#define COMMAND "bench codecs"

enum { REPEAT_MAX = 100, ROWS_MAX = 64 };

/* A codec at a level; a lossy one at a tolerance. */
struct row {
    enum brick_codec codec;
    int level;        /* of a lossy one: of what stands in for it */
    double tolerance; /* lossy, physical */
    uint64_t encoded_bytes;
    double encode_s[REPEAT_MAX], decode_s[REPEAT_MAX];
};

struct sample {
    struct brick_codec_shape shape;
    unsigned char *payload;
    unsigned char *encoded;
    size_t encoded_bytes;
    enum brick_codec codec; /* that encoded it */
};

struct bench {
    const struct brick_grid *grid;
    struct sample *samples;
    size_t count;
    uint64_t bytes;                 /* of all payloads */
    unsigned char *scratch, *lossy; /* room for the largest payload each */
    struct row rows[ROWS_MAX];
    size_t row_count;
};

static void list_rows(struct bench *b, double range)
{
    static const int levels[] = {1, 3, 5, 7, 9};
    static const double shares[] = {1e-4, 1e-3, 1e-2};
    const double least = brick_type_is_integer(b->grid->type) ? 1 : 1e-300;
    for (int c = 0; c < BRICK_CODEC_COUNT; c++) {
        enum brick_codec codec = (enum brick_codec)c;
        bool lossy = brick_codec_is_lossy(codec);
        size_t n = codec == BRICK_CODEC_NONE ? 1 : lossy ? TOOL_COUNT(shares) : TOOL_COUNT(levels);
        for (size_t i = 0; i < n && brick_codec_is_built(codec); i++) {
            double tolerance = lossy ? range * shares[i] : 0;
            /* Where no stored value may move, the lossy codec is not used. */
            if (!lossy || brick_codec_tolerance(b->grid->type, b->grid->slope, tolerance) >= least)
                b->rows[b->row_count++] =
                    (struct row){.codec = codec, .level = lossy ? 1 : levels[i], .tolerance = tolerance};
        }
    }
}

/* Every n-th brick with a payload, so that all of them together are at most about limit_bytes. */
static int take_samples(struct bench *b, const struct brick_volume *volume, uint64_t limit_bytes,
                        struct brick_error *err)
{
    struct brick_scratch scratch = {0};
    uint64_t whole = 0, wanted = 0;
    size_t most = brick_grid_max_payload_bytes(b->grid);
    int code = 0;
    for (uint64_t id = 0; id < b->grid->bricks; id++)
        whole += brick_volume_entry(volume, id)->flags & BRICK_FLAG_CONSTANT ? 0 : most;
    uint64_t step = 1 + whole / (limit_bytes + 1);
    b->samples = calloc(b->grid->bricks / step + 1, sizeof *b->samples);
    b->scratch = malloc(most);
    b->lossy = malloc(most);
    for (uint64_t id = 0; !code && b->samples && b->scratch && b->lossy && id < b->grid->bricks; id++) {
        if (brick_volume_entry(volume, id)->flags & BRICK_FLAG_CONSTANT || wanted++ % step)
            continue;
        struct sample *s = &b->samples[b->count++];
        struct brick_place place;
        brick_grid_place(b->grid, id, &place);
        s->shape = brick_codec_shape(b->grid, &place);
        s->payload = malloc(s->shape.bytes);
        s->encoded = malloc(brick_codec_bound(BRICK_CODEC_ZSTD, s->shape.bytes));
        if (!s->payload || !s->encoded)
            code = brick_fail(err, BRICK_ERR_MEMORY, "no memory for %zu bricks", b->count);
        else
            code = brick_volume_read(volume, id, s->payload, &scratch, err);
        b->bytes += s->shape.bytes;
    }
    brick_scratch_finish(&scratch);
    if (!code && (!b->samples || !b->scratch || !b->lossy))
        code = brick_fail(err, BRICK_ERR_MEMORY, "no memory for a list of bricks");
    if (!code && !b->count)
        code = brick_fail(err, BRICK_ERR_ARGUMENT, "%s: all bricks are constant", brick_volume_path(volume));
    return code;
}

/* A lossy codec as brick_build uses it: where folded differences are smaller, they are taken. */
static int encode(const struct bench *b, const struct row *row, struct sample *s, struct brick_error *err)
{
    bool lossy = brick_codec_is_lossy(row->codec);
    size_t room = brick_codec_bound(BRICK_CODEC_ZSTD_DELTA, s->shape.bytes), written = 0,
           ranges = s->shape.bytes - s->shape.voxel_bytes;
    s->codec = lossy ? BRICK_CODEC_ZSTD_DELTA : row->codec;
    int code = brick_codec_encode(s->codec, row->level, &s->shape, s->payload, s->encoded, room,
                                  &s->encoded_bytes, err);
    if (code || !lossy || s->encoded_bytes <= ranges)
        return code;
    double tolerance = brick_codec_tolerance(b->grid->type, b->grid->slope, row->tolerance);
    memcpy(b->scratch, s->payload, s->shape.voxel_bytes);
    code = brick_codec_encode_lossy(row->codec, tolerance, &s->shape, b->scratch, b->lossy,
                                    s->encoded_bytes - ranges, &written, err);
    if (!code && written) {
        s->codec = row->codec;
        memcpy(s->encoded, b->lossy, written);
        memcpy(s->encoded + written, s->payload + s->shape.voxel_bytes, ranges);
        s->encoded_bytes = written + ranges;
    }
    return code;
}

static int run_row(const struct bench *b, struct row *row, uint32_t turn, struct brick_error *err)
{
    int code = 0;
    row->encoded_bytes = 0;
    const uint64_t start = brick_thread_ns();
    for (size_t i = 0; i < b->count && !code; i++) {
        code = encode(b, row, &b->samples[i], err);
        row->encoded_bytes += b->samples[i].encoded_bytes;
    }
    const uint64_t middle = brick_thread_ns();
    for (size_t i = 0; i < b->count && !code; i++) {
        const struct sample *s = &b->samples[i];
        code = brick_codec_decode(s->codec, &s->shape, s->encoded, s->encoded_bytes, b->scratch, err);
    }
    row->encode_s[turn] = 1e-9 * (double)(middle - start);
    row->decode_s[turn] = 1e-9 * (double)(brick_thread_ns() - middle);
    return code;
}

static cJSON *report(struct bench *b, const struct brick_volume *volume, uint32_t repeat, bool json)
{
    cJSON *list = json ? cJSON_CreateArray() : NULL;
    if (!json)
        printf("%s: %s in %zu bricks, median of %u\n%-15s %10s %8s %12s %14s\n", brick_volume_path(volume),
               tool_size_text(b->bytes).text, b->count, repeat, "codec", "level", "ratio", "encode MB/s",
               "decode MB/s");
    for (size_t i = 0; i < b->row_count; i++) {
        struct row *row = &b->rows[i];
        bool lossy = brick_codec_is_lossy(row->codec);
        double ratio = (double)b->bytes / (double)row->encoded_bytes,
               encode_rate = (double)b->bytes / bench_spread(row->encode_s, repeat).median,
               decode_rate = (double)b->bytes / bench_spread(row->decode_s, repeat).median;
        char level[32];
        snprintf(level, sizeof level, lossy ? "E %.4g" : "%.0f", lossy ? row->tolerance : (double)row->level);
        if (!json) {
            printf("%-15s %10s %8.3f %12.0f %14.0f\n", brick_codec_name(row->codec), level, ratio,
                   1e-6 * encode_rate, 1e-6 * decode_rate);
            continue;
        }
        cJSON *one = cJSON_CreateObject();
        cJSON_AddStringToObject(one, "codec", brick_codec_name(row->codec));
        if (lossy)
            cJSON_AddNumberToObject(one, "tolerance", row->tolerance);
        else
            cJSON_AddNumberToObject(one, "level", row->level);
        cJSON_AddNumberToObject(one, "ratio", ratio);
        cJSON_AddNumberToObject(one, "encode_bytes_per_second", encode_rate);
        cJSON_AddNumberToObject(one, "decode_bytes_per_second", decode_rate);
        cJSON_AddItemToArray(list, one);
    }
    return list;
}

static int measure(const char *path, uint64_t limit_bytes, uint32_t repeat, cJSON *json,
                   struct brick_error *err)
{
    struct brick_volume *volume = NULL;
    struct bench *b = calloc(1, sizeof *b);
    int code = b ? brick_volume_open(&volume, path, err) : brick_fail(err, BRICK_ERR_MEMORY, "no memory");
    if (!code) {
        double range[2];
        brick_volume_value_range(volume, range);
        b->grid = brick_volume_grid(volume);
        list_rows(b, range[1] - range[0]);
        code = take_samples(b, volume, limit_bytes, err);
    }
    for (uint32_t turn = 0; turn < repeat && !code; turn++)
        for (size_t i = 0; i < b->row_count && !code; i++)
            code = run_row(b, &b->rows[i], turn, err);
    if (!code) {
        cJSON *list = report(b, volume, repeat, json != NULL);
        if (json)
            cJSON_AddItemToObject(json, path, list);
    }
    for (size_t i = 0; b && i < b->count; i++) {
        free(b->samples[i].payload);
        free(b->samples[i].encoded);
    }
    if (b) {
        free(b->samples);
        free(b->scratch);
        free(b->lossy);
    }
    free(b);
    brick_volume_close(&volume);
    return code;
}

int bench_codecs(int argc, char **argv)
{
    uint32_t repeat = 3;
    uint64_t limit_bytes = UINT64_C(16) << 20;
    bool json = false;
    int first = 0;
    const struct tool_option options[] = {
        {"repeat", .value = "N", .parse = tool_parse_u32, .target = &repeat,
         .limits = {.min = 1, .max = REPEAT_MAX}, .help = "turns to take the median of (default 3)"},
        {"limit", .value = "SIZE", .parse = tool_parse_bytes, .target = &limit_bytes,
         .help = "bricks to take from a file, in decoded bytes\n(default 16M), spread over all of it"},
        TOOL_OPTION_JSON(&json),
    };
    const struct tool_usage usage = {
        .command = COMMAND,
        .arguments = "FILE... [OPTIONS]",
        .summary = "Every codec and level on the bricks of .brick files: ratio, speed of one thread.",
        .options = {options, TOOL_COUNT(options)},
        .positional = {1, 1000, "a FILE"},
    };
    int code = tool_options(&usage, argc, argv, &first);
    if (code >= 0)
        return code;
    struct brick_error err = {0};
    cJSON *report_json = json ? cJSON_CreateObject() : NULL;
    for (int i = first; i < argc; i++) {
        if (i > first && !json)
            putchar('\n');
        if (measure(argv[i], limit_bytes, repeat, report_json, &err)) {
            cJSON_Delete(report_json);
            return tool_fail(COMMAND, &err);
        }
    }
    return json ? tool_json_print(COMMAND, report_json) : 0;
}
