/* Why: `brick info`: the inventory for people at a terminal. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "inventory.h"
#include "message.h"

#define BAR_WIDTH      40
#define HISTOGRAM_ROWS 16

static void print_levels(const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    printf("\nlevel  %-20s %10s %10s %12s %7s\n", "voxels", "bricks", "constant", "bytes", "ratio");
    for (uint32_t l = 0; l < grid->levels; l++) {
        const uint64_t *dims = grid->level[l].dims;
        char size[72];
        snprintf(size, sizeof size, "%llu x %llu x %llu", (unsigned long long)dims[0],
                 (unsigned long long)dims[1], (unsigned long long)dims[2]);
        printf("%5u  %-20s %10llu %10llu %12llu ", l, size, (unsigned long long)inventory->level[l].bricks,
               (unsigned long long)inventory->level[l].constant,
               (unsigned long long)inventory->level[l].payload_bytes);
        if (inventory->level[l].payload_bytes)
            printf("%7.2f\n",
                   (double)inventory->level[l].voxel_bytes / (double)inventory->level[l].payload_bytes);
        else
            printf("%7s\n", "-");
    }
}

static void print_histogram(const struct inventory *inventory, bool log_scale)
{
    struct histogram rows;
    histogram_init(&rows, inventory->volume, HISTOGRAM_ROWS);
    double peak = 0, voxels = (double)brick_volume_stats(inventory->volume)->count;
    for (uint32_t i = 0; i < rows.parts; i++)
        peak = fmax(peak, rows.count[i]);
    printf("\nhistogram%s\n", log_scale ? ", bars logarithmic" : "");
    for (uint32_t i = 0; i < rows.parts; i++) {
        double n = rows.count[i], length = log_scale ? log1p(n) / log1p(peak) : n / peak;
        char bar[BAR_WIDTH + 1] = "";
        memset(bar, '#', (size_t)lround(length * BAR_WIDTH));
        printf("%12.6g %8.4f%% %s\n", rows.low + i * rows.width, 100 * n / voxels, bar);
    }
}

static void print_values(const struct inventory *inventory, bool log_scale)
{
    const struct brick_stats *stats = brick_volume_stats(inventory->volume);
    printf("not finite  %llu of %llu voxels\n", (unsigned long long)stats->nonfinite,
           (unsigned long long)(stats->count + stats->nonfinite));
    if (!stats->count)
        return;
    printf("range       %.7g .. %.7g\nmean        %.7g, standard deviation %.7g\npercentiles",
           inventory->range[0], inventory->range[1], inventory->mean, inventory->deviation);
    for (int i = 0; i < INVENTORY_PERCENTILES; i++)
        printf("%s %g%%: %.6g", i ? "," : " ", 100 * inventory_shares[i], inventory->percentile[i]);
    printf("\ncrossed     ");
    for (int i = 1; i < 8; i++) {
        int sample = i * (INVENTORY_SAMPLES - 1) / 8;
        printf("%s%.5g: %.1f%%", i > 1 ? ", " : "", inventory->active.value[sample],
               100 * inventory->active.crossed[sample]);
    }
    printf(" of level 0's bricks, by isovalue\n");
    print_histogram(inventory, log_scale);
}

static void print_sizes(const struct inventory *inventory)
{
    if (!inventory->size.count)
        return;
    printf("payloads    %u .. %u bytes, mean %.0f; percentiles", inventory->size.smallest,
           inventory->size.largest, inventory->size.mean);
    for (int i = 0; i < INVENTORY_PERCENTILES; i++)
        printf("%s %g%%: %u", i ? "," : "", 100 * inventory_shares[i], inventory->size.percentile[i]);
    putchar('\n');
}

static void print_bricks(const struct inventory *inventory)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    printf("\n%10s %5s %6s %6s %6s %14s %10s %-14s %14s %14s %10s\n", "brick", "level", "x", "y", "z",
           "offset", "bytes", "codec", "min", "max", "not finite");
    for (uint64_t id = 0; id < grid->bricks; id++) {
        const struct brick_entry *entry = brick_volume_entry(inventory->volume, id);
        struct brick_place place;
        double lo = NAN, hi = NAN;
        brick_grid_place(grid, id, &place);
        brick_volume_physical_range(inventory->volume, id, &lo, &hi);
        printf("%10llu %5u %6llu %6llu %6llu %14llu %10u %-14s %14.7g %14.7g %10u\n", (unsigned long long)id,
               place.level, (unsigned long long)place.at[0], (unsigned long long)place.at[1],
               (unsigned long long)place.at[2], (unsigned long long)entry->offset, entry->bytes,
               entry->flags & BRICK_FLAG_CONSTANT ? "const"
                                                  : brick_codec_name((enum brick_codec)entry->codec),
               lo, hi, entry->nonfinite);
    }
}

void inventory_print_text(const struct inventory *inventory, bool bricks, bool log_scale)
{
    const struct brick_grid *grid = brick_volume_grid(inventory->volume);
    uint64_t file_bytes = brick_volume_file_bytes(inventory->volume);
    const char *provenance = brick_volume_provenance(inventory->volume);

    printf("file        %s, %s\n", brick_volume_path(inventory->volume), tool_size_text(file_bytes).text);
    printf("size        %llu x %llu x %llu voxels of %s, %s, ratio %.2f\n", (unsigned long long)grid->dims[0],
           (unsigned long long)grid->dims[1], (unsigned long long)grid->dims[2], brick_type_name(grid->type),
           tool_size_text(inventory->level[0].voxel_bytes).text,
           (double)inventory->level[0].voxel_bytes / (double)file_bytes);
    printf("spacing     %.7g x %.7g x %.7g mm, axes %s\n", inventory->spacing_mm[0], inventory->spacing_mm[1],
           inventory->spacing_mm[2], inventory->axes);
    for (int row = 0; row < 3; row++)
        printf("%-11s %12.7g %12.7g %12.7g %12.7g\n", row ? "" : "affine", grid->affine[row][0],
               grid->affine[row][1], grid->affine[row][2], grid->affine[row][3]);
    printf("values      %.9g * stored + %.9g\n", grid->slope, grid->intercept);
    printf("bricks      %llu, %llu constant (%.1f%%); core %u, border %u, macrocell %u; codec",
           (unsigned long long)grid->bricks, (unsigned long long)inventory->constant,
           100 * (double)inventory->constant / (double)grid->bricks, grid->edge, grid->border,
           grid->macrocell);
    bool any = false;
    for (int codec = 0; codec < BRICK_CODEC_COUNT; codec++)
        if (inventory->codec_used[codec]) {
            printf(" %s", brick_codec_name((enum brick_codec)codec));
            any = true;
        }
    printf("%s", any ? "" : " none");
    double tolerance = brick_volume_tolerance(inventory->volume);
    if (tolerance > 0)
        printf(", no value off by more than %.9g", tolerance);
    putchar('\n');
    const struct brick_active_summary *seen = &inventory->tf_active;
    if (inventory->tf)
        printf("visible     %llu of %llu bricks of level 0 (%.1f%%) with %s\n",
               (unsigned long long)seen->bricks_active, (unsigned long long)seen->bricks,
               100 * (double)seen->bricks_active / (double)seen->bricks, inventory->tf);
    if (inventory->tf && seen->bricks_interval != seen->bricks_active)
        printf("            %llu by their range alone, without the mask\n",
               (unsigned long long)seen->bricks_interval);
    if (inventory->macrocells)
        printf("            %llu of %llu macrocells (%.1f%%), in %llu bricks; read %llu bytes to see them\n",
               (unsigned long long)seen->macrocells_active, (unsigned long long)seen->macrocells,
               100 * (double)seen->macrocells_active / (double)seen->macrocells,
               (unsigned long long)seen->bricks_macrocells, (unsigned long long)seen->bytes_read);
    print_sizes(inventory);
    print_values(inventory, log_scale);
    print_levels(inventory);
    if (provenance && *provenance)
        printf("\nprovenance\n%s%s", provenance, provenance[strlen(provenance) - 1] == '\n' ? "" : "\n");
    if (bricks)
        print_bricks(inventory);
}
