/* Why: pictures and entropy need voxels, and a volume may be far larger than memory. So a picture comes from
 * the finest level at which it fits SURVEY_PICTURE_MAX, and a map samples the bricks of one layer such that
 * what is read stays below READ_BYTES. Invariants: results do not depend on the number of threads; each
 * worker holds one brick. */
#include "survey.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <brick/threads.h>

#define READ_BYTES   (UINT64_C(4) << 30)   /* of decoded bricks, for all maps */
#define WORKER_BYTES (UINT64_C(512) << 20) /* of bricks and payloads, for all workers */
#define MAP_MAX      256                   /* bricks on a side */
#define BATCH        256                   /* bricks between two calls of progress */

struct worker {
    void *brick;
    struct brick_scratch scratch;
    uint32_t *counts; /* 65536 */
};

struct work {
    const struct brick_volume *volume;
    struct survey_plane *plane;
    struct worker *worker;
    unsigned char *voxels; /* of a picture, in the file's order */
    uint64_t first;        /* cell of the map that a batch starts with */
    void (*progress)(void *context, uint64_t done, uint64_t total);
    void *context;
    uint64_t done; /* bricks of maps */
};

static uint64_t ceil_div(uint64_t a, uint64_t b)
{
    return (a + b - 1) / b;
}

/* Heads up, the patient's right on the left, as radiologists hang pictures. */
static void choose_axes(struct survey_plane *plane, const struct brick_grid *grid, int normal)
{
    static const char rank[] = "LRPASI"; /* the higher one runs downwards */
    char axes[4];
    brick_affine_axes(grid->affine, axes);
    int a = (normal + 1) % 3, b = (normal + 2) % 3;
    bool swap = strchr(rank, axes[a]) > strchr(rank, axes[b]);
    plane->normal = normal;
    plane->across = swap ? b : a;
    plane->down = swap ? a : b;
    plane->across_turned = strchr("RAS", axes[plane->across]) != NULL;
    plane->down_turned = strchr("RAS", axes[plane->down]) != NULL;
}

static void choose_level(struct survey_plane *plane, const struct brick_grid *grid)
{
    uint32_t l = 0; /* the last level fits one brick, which is smaller than a picture */
    while (grid->level[l].dims[plane->across] > SURVEY_PICTURE_MAX ||
           grid->level[l].dims[plane->down] > SURVEY_PICTURE_MAX)
        l++;
    const struct brick_level *level = &grid->level[l];
    plane->level = l;
    plane->width = (uint32_t)level->dims[plane->across];
    plane->height = (uint32_t)level->dims[plane->down];
    plane->voxel = level->dims[plane->normal] / 2;
    plane->layer = grid->dims[plane->normal] / 2 / grid->edge;
}

/* One stride for all maps, the least that keeps them small and quickly read. */
static void choose_stride(struct survey *survey, const struct brick_grid *grid)
{
    const uint64_t *bricks = grid->level[0].bricks, bytes = brick_grid_max_payload_bytes(grid);
    uint64_t longest = bricks[0] > bricks[1] ? bricks[0] : bricks[1], cells;
    uint64_t stride = ceil_div(longest > bricks[2] ? longest : bricks[2], MAP_MAX) - 1;
    do {
        stride++;
        cells = 0;
        for (int i = 0; i < 3; i++) {
            struct survey_plane *plane = &survey->plane[i];
            uint64_t columns = ceil_div(bricks[plane->across], stride);
            uint64_t rows = ceil_div(bricks[plane->down], stride);
            cells += columns * rows;
            plane->stride = stride;
            plane->columns = (uint32_t)columns;
            plane->rows = (uint32_t)rows;
        }
    } while (cells > 3 && cells > READ_BYTES / bytes);
    survey->bricks_mapped = cells;
}

static double entropy(const struct brick_grid *grid, const struct brick_place *place, struct worker *worker)
{
    size_t width = brick_type_bytes(grid->type), row = place->stored[0];
    const unsigned char *brick = worker->brick;
    size_t kinds = width == 1 ? 256 : 65536;
    memset(worker->counts, 0, kinds * sizeof *worker->counts);
    for (size_t z = 0; z < place->core[2]; z++)
        for (size_t y = 0; y < place->core[1]; y++) {
            size_t first = ((z + grid->border) * place->stored[1] + y + grid->border) * row + grid->border;
            const unsigned char *voxel = brick + first * width;
            for (size_t x = 0; x < place->core[0]; x++, voxel += width) {
                uint32_t bits = *voxel;
                if (width == 2) {
                    uint16_t half;
                    memcpy(&half, voxel, 2);
                    bits = half;
                } else if (width == 4) {
                    memcpy(&bits, voxel, 4);
                    bits >>= 16;
                }
                worker->counts[bits]++;
            }
        }
    double n = (double)place->core[0] * place->core[1] * place->core[2], sum = 0;
    for (size_t i = 0; i < kinds; i++)
        if (worker->counts[i])
            sum += worker->counts[i] * log2(worker->counts[i]);
    return fmax(0, log2(n) - sum / n);
}

static int survey_brick(void *context, uint64_t item, unsigned index, struct brick_error *err)
{
    struct work *work = context;
    item += work->first;
    struct survey_plane *plane = work->plane;
    struct survey_cell *cell = &plane->cell[item];
    const struct brick_grid *grid = brick_volume_grid(work->volume);
    uint64_t column = item % plane->columns, row = item / plane->columns, at[3];
    at[plane->normal] = plane->layer;
    at[plane->across] = plane->stride * (plane->across_turned ? plane->columns - 1 - column : column);
    at[plane->down] = plane->stride * (plane->down_turned ? plane->rows - 1 - row : row);
    uint64_t id = brick_grid_id(grid, 0, at[0], at[1], at[2]);
    const struct brick_entry *entry = brick_volume_entry(work->volume, id);
    if (entry->flags & BRICK_FLAG_CONSTANT) {
        *cell = (struct survey_cell){.constant = true};
        return 0;
    }
    struct brick_place place;
    struct worker *worker = &work->worker[index];
    brick_grid_place(grid, id, &place);
    int code = brick_volume_read(work->volume, id, worker->brick, &worker->scratch, err);
    if (code)
        return code;
    cell->entropy = (float)entropy(grid, &place, worker);
    cell->size = (float)((double)entry->bytes / (double)brick_place_payload_bytes(grid, &place));
    return 0;
}

/* One row of bricks of a picture: the slower of its axes is cut, so that each row is one run of memory. */
static int survey_row(void *context, uint64_t item, unsigned index, struct brick_error *err)
{
    (void)index;
    struct work *work = context;
    const struct survey_plane *plane = work->plane;
    const struct brick_grid *grid = brick_volume_grid(work->volume);
    const uint64_t *dims = grid->level[plane->level].dims;
    int slow = plane->across > plane->down ? plane->across : plane->down;
    int fast = plane->across + plane->down - slow;
    uint64_t lo[3] = {0, 0, 0}, hi[3] = {dims[0], dims[1], dims[2]};
    lo[plane->normal] = plane->voxel;
    hi[plane->normal] = plane->voxel + 1;
    lo[slow] = item * grid->edge;
    hi[slow] = lo[slow] + grid->edge < dims[slow] ? lo[slow] + grid->edge : dims[slow];
    size_t offset = (size_t)(lo[slow] * dims[fast]) * brick_type_bytes(grid->type);
    return brick_volume_read_box(work->volume, plane->level, lo, hi, work->voxels + offset, err);
}

static void expose(const struct survey *survey, const struct work *work)
{
    struct survey_plane *plane = work->plane;
    const struct brick_grid *grid = brick_volume_grid(work->volume);
    double black = survey->window[0], white = survey->window[1];
    for (uint32_t y = 0; y < plane->height; y++)
        for (uint32_t x = 0; x < plane->width; x++) {
            size_t a = plane->across_turned ? plane->width - 1 - x : x;
            size_t d = plane->down_turned ? plane->height - 1 - y : y;
            size_t i = plane->across < plane->down ? d * plane->width + a : a * plane->height + d;
            double value = grid->slope * brick_type_load(grid->type, work->voxels, i) + grid->intercept;
            double t = (value - black) / (white - black);
            plane->gray[(size_t)y * plane->width + x] =
                (uint8_t)(isfinite(t) && t > 0 ? 255 * fmin(t, 1) + 0.5 : 0);
        }
}

static int survey_map(const struct survey *survey, struct work *work, struct brick_pool *pool,
                      struct brick_error *err)
{
    uint64_t cells = (uint64_t)work->plane->columns * work->plane->rows;
    int code = 0;
    for (work->first = 0; work->first < cells && !code; work->first += BATCH) {
        uint64_t n = cells - work->first < BATCH ? cells - work->first : BATCH;
        code = brick_pool_run(pool, n, survey_brick, work, err);
        work->done += n;
        work->progress(work->context, work->done, survey->bricks_mapped);
    }
    return code;
}

static int survey_plane(struct survey *survey, struct work *work, struct brick_pool *pool,
                        struct brick_error *err)
{
    struct survey_plane *plane = work->plane;
    const struct brick_grid *grid = brick_volume_grid(work->volume);
    size_t pixels = (size_t)plane->width * plane->height, cells = (size_t)plane->columns * plane->rows;
    uint32_t slow = plane->across > plane->down ? plane->width : plane->height;
    plane->gray = malloc(pixels);
    plane->cell = calloc(cells, sizeof *plane->cell);
    work->voxels = malloc(pixels * brick_type_bytes(grid->type));
    int code = plane->gray && plane->cell && work->voxels
                   ? 0
                   : brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory for a picture of %zu pixels",
                                brick_volume_path(work->volume), pixels);
    if (!code)
        code = brick_pool_run(pool, ceil_div(slow, grid->edge), survey_row, work, err);
    if (!code) {
        expose(survey, work);
        code = survey_map(survey, work, pool, err);
    }
    for (size_t i = 0; i < cells && !code; i++)
        survey->entropy_max = fmax(survey->entropy_max, (double)plane->cell[i].entropy);
    free(work->voxels);
    work->voxels = NULL;
    return code;
}

static int create_workers(struct work *work, unsigned threads, struct brick_error *err)
{
    size_t bytes = brick_grid_max_payload_bytes(brick_volume_grid(work->volume));
    bool ok = (work->worker = calloc(threads, sizeof *work->worker)) != NULL;
    for (unsigned i = 0; ok && i < threads; i++) {
        work->worker[i].brick = malloc(bytes);
        work->worker[i].counts = malloc(65536 * sizeof *work->worker[i].counts);
        ok = work->worker[i].brick && work->worker[i].counts;
    }
    return ok ? 0 : brick_fail(err, BRICK_ERR_MEMORY, "no memory for %u bricks of %zu bytes", threads, bytes);
}

static void destroy_workers(struct work *work, unsigned threads)
{
    for (unsigned i = 0; work->worker && i < threads; i++) {
        free(work->worker[i].brick);
        free(work->worker[i].counts);
        brick_scratch_finish(&work->worker[i].scratch);
    }
    free(work->worker);
}

static void choose_window(struct survey *survey, const struct brick_volume *volume)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    const struct brick_stats *stats = brick_volume_stats(volume);
    for (int i = 0; i < 2; i++)
        survey->window[grid->slope < 0 ? 1 - i : i] =
            grid->slope * brick_stats_percentile(stats, grid->type, i ? 0.995 : 0.005) + grid->intercept;
    if (!(survey->window[0] < survey->window[1]))
        brick_volume_value_range(volume, survey->window);
    if (!(survey->window[0] < survey->window[1])) /* one value: middle gray */
        survey->window[0] -= 1, survey->window[1] += 1;
}

int survey_init(struct survey *survey, const struct brick_volume *volume, unsigned threads,
                void (*progress)(void *context, uint64_t done, uint64_t total), void *context,
                struct brick_error *err)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    struct work work = {.volume = volume, .progress = progress, .context = context};
    struct brick_pool *pool = NULL;
    /* A brick and its payload, and those of a picture's row. */
    uint64_t most = WORKER_BYTES / (4 * brick_grid_max_payload_bytes(grid));
    if (!threads)
        threads = brick_cores();
    if (threads > most)
        threads = most ? (unsigned)most : 1;

    choose_window(survey, volume);
    for (int i = 0; i < 3; i++) {
        choose_axes(&survey->plane[i], grid, i);
        choose_level(&survey->plane[i], grid);
    }
    choose_stride(survey, grid);
    int code = create_workers(&work, threads, err);
    if (!code)
        code = brick_pool_create(&pool, threads, err);
    for (int i = 0; i < 3 && !code; i++) {
        work.plane = &survey->plane[i];
        code = survey_plane(survey, &work, pool, err);
    }
    brick_pool_destroy(&pool);
    destroy_workers(&work, threads);
    return code;
}

void survey_finish(struct survey *survey)
{
    for (int i = 0; i < 3; i++) {
        free(survey->plane[i].gray);
        free(survey->plane[i].cell);
    }
    *survey = (struct survey){0};
}
