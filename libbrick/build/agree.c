/* Pure functions of a brick and its place. */
#include "agree.h"

#include <math.h>
#include <string.h>
#include <xxhash.h>

#include "downsample.h"
#include "lossy.h"

size_t agree_face_bytes(const struct brick_grid *grid)
{
    size_t side = grid->edge + 2 * grid->border;
    return side * side * 2 * grid->border * brick_type_bytes(grid->type);
}

/* Copy a box of a brick's stored voxels. */
static size_t copy_box(const struct brick_place *p, size_t width, const unsigned char *voxels,
                       const uint32_t from[3], const uint32_t to[3], unsigned char *out)
{
    size_t row = (to[0] - from[0]) * width, n = 0;
    for (uint32_t z = from[2]; z < to[2]; z++)
        for (uint32_t y = from[1]; y < to[1]; y++, n += row) {
            const unsigned char *line =
                voxels + (((size_t)z * p->stored[1] + y) * p->stored[0] + from[0]) * width;
            /* The thin rows of a face along x: a call to the library costs more than the copy. */
            if (row == 4)
                memcpy(out + n, line, 4);
            else if (row == 8)
                memcpy(out + n, line, 8);
            else if (row == 16)
                memcpy(out + n, line, 16);
            else
                memcpy(out + n, line, row);
        }
    return n;
}

struct agree_face agree_face(const struct brick_grid *grid, const struct brick_place *p, const void *voxels,
                             int axis, bool high, bool with_flat, void *scratch)
{
    size_t width = brick_type_bytes(grid->type);
    uint32_t from[3] = {0}, to[3] = {p->stored[0], p->stored[1], p->stored[2]}, thick = 2 * grid->border;
    from[axis] = high ? p->stored[axis] - thick : 0;
    to[axis] = from[axis] + thick;
    const unsigned char *box = scratch;
    size_t n;
    if (axis == 2) { /* whole slices lie in one piece */
        size_t slice = (size_t)p->stored[0] * p->stored[1] * width;
        box = (const unsigned char *)voxels + from[2] * slice;
        n = thick * slice;
    } else {
        n = copy_box(p, width, voxels, from, to, scratch);
    }
    if (with_flat && memcmp(box, box + width, n - width) == 0)
        return (struct agree_face){XXH3_64bits(box, width), true};
    return (struct agree_face){XXH3_64bits(box, n), false};
}

/* One voxel. */
static bool same(enum brick_type type, size_t width, const unsigned char *a, const unsigned char *b,
                 double tolerance)
{
    bool equal = width == 1 ? *a == *b : width == 2 ? memcmp(a, b, 2) == 0 : memcmp(a, b, 4) == 0;
    return equal || lossy_agree(type, a, b, 1, tolerance);
}

bool agree_edge_repeats(const struct brick_grid *grid, const struct brick_place *p, const void *bytes,
                        double tolerance)
{
    const struct brick_level *level = &grid->level[p->level];
    const unsigned char *voxels = bytes;
    size_t width = brick_type_bytes(grid->type);
    uint32_t lo[3], hi[3]; /* stored voxels inside the volume: [lo, hi] */
    bool inner = true;
    for (int a = 0; a < 3; a++) {
        lo[a] = p->at[a] == 0 ? grid->border : 0;
        hi[a] = p->at[a] + 1 == level->bricks[a] ? p->stored[a] - grid->border - 1 : p->stored[a] - 1;
        /* a short last brick: its neighbour's border also reaches beyond the edge */
        int64_t beyond = p->lo[a] + p->stored[a] - (int64_t)level->dims[a];
        if (beyond > 0)
            hi[a] = p->stored[a] - 1 - (uint32_t)beyond;
        inner = inner && lo[a] == 0 && hi[a] == p->stored[a] - 1;
    }
    if (inner)
        return true;
    size_t line = p->stored[0] * width, slice = line * p->stored[1], middle = (hi[0] - lo[0] + 1) * width;
    for (uint32_t z = 0; z < p->stored[2]; z++)
        for (uint32_t y = 0; y < p->stored[1]; y++) {
            uint32_t cy = y < lo[1]   ? lo[1]
                          : y > hi[1] ? hi[1]
                                      : y,
                     cz = z < lo[2]   ? lo[2]
                          : z > hi[2] ? hi[2]
                                      : z;
            const unsigned char *row = voxels + z * slice + y * line, *core = voxels + cz * slice + cy * line;
            if (row != core && memcmp(row + lo[0] * width, core + lo[0] * width, middle) != 0 &&
                !lossy_agree(grid->type, row + lo[0] * width, core + lo[0] * width, hi[0] - lo[0] + 1,
                             tolerance))
                return false;
            for (uint32_t x = 0; x < lo[0]; x++)
                if (!same(grid->type, width, row + x * width, core + lo[0] * width, tolerance))
                    return false;
            for (uint32_t x = hi[0] + 1; x < p->stored[0]; x++)
                if (!same(grid->type, width, row + x * width, core + hi[0] * width, tolerance))
                    return false;
        }
    return true;
}

const char *agree_ranges(const struct brick_grid *grid, const struct brick_place *p,
                         const struct brick_entry *entry, struct encoder *scratch, void *found,
                         struct brick_entry *own)
{
    size_t cells = (size_t)p->macrocells[0] * p->macrocells[1] * p->macrocells[2];
    const unsigned char *stored = scratch->payload + brick_place_voxel_bytes(grid, p);
    enum brick_type type = grid->type;
    encode_ranges(grid, p, scratch->payload, NULL, NULL, found, scratch, own);
    if (p->level == 0) {
        if (memcmp(stored, found, cells * 2 * brick_type_bytes(type)) != 0)
            return "its macrocell ranges are not those of its voxels";
        if (own->min != entry->min || own->max != entry->max)
            return "its range in the index is not that of its voxels";
        if (own->mask != entry->mask)
            return "its occupancy mask is not that of its voxels";
        return NULL;
    }
    if (entry->nonfinite || (entry->mask == 0) != !(entry->min <= entry->max))
        return "its mask or its count of NaN and Inf is impossible";
    double min = INFINITY, max = -INFINITY;
    for (size_t i = 0; i < cells; i++) {
        double lo = brick_type_load(type, stored, 2 * i), hi = brick_type_load(type, stored, 2 * i + 1);
        if (brick_type_load(type, found, 2 * i) < lo || brick_type_load(type, found, 2 * i + 1) > hi)
            return "a macrocell range is narrower than its voxels";
        min = fmin(min, lo);
        max = fmax(max, hi);
    }
    return min == (double)entry->min && max == (double)entry->max
               ? NULL
               : "its range in the index is not its macrocells'";
}

static void halvings(const struct brick_grid *grid, uint32_t level, bool halved[3])
{
    for (int a = 0; a < 3; a++)
        halved[a] = grid->level[level + 1].scale[a] > grid->level[level].scale[a];
}

struct agree_part agree_part(const struct brick_grid *grid, const struct brick_place *p)
{
    struct agree_part part;
    uint64_t at[3];
    bool halved[3];
    halvings(grid, p->level, halved);
    for (int a = 0; a < 3; a++) {
        at[a] = halved[a] ? p->at[a] / 2 : p->at[a];
        part.lo[a] = halved[a] && p->at[a] % 2 ? grid->edge / 2 : 0;
        part.size[a] = halved[a] ? (p->core[a] + 1) / 2 : p->core[a];
    }
    part.parent = brick_grid_id(grid, p->level + 1, at[0], at[1], at[2]);
    return part;
}

size_t agree_coarse_bytes(const struct brick_grid *grid)
{
    /* The core, and three arrays of what it becomes, which is as large where no axis is halved. */
    return 4 * (size_t)grid->edge * grid->edge * grid->edge * brick_type_bytes(grid->type);
}

void agree_make_part(const struct kernels *kernels, const struct brick_grid *grid,
                     const struct brick_place *p, const void *voxels, bool nearest, void *out, void *scratch)
{
    size_t width = brick_type_bytes(grid->type), array = (size_t)grid->edge * grid->edge * grid->edge * width;
    unsigned char *core = scratch;
    struct agree_part part = agree_part(grid, p);
    uint32_t from[3], to[3];
    bool halved[3];
    uint64_t lo[3];
    halvings(grid, p->level, halved);
    for (int a = 0; a < 3; a++) {
        from[a] = grid->border;
        to[a] = grid->border + p->core[a];
        lo[a] = p->at[a] * grid->edge / (halved[a] ? 2 : 1);
    }
    copy_box(p, width, voxels, from, to, core);
    struct window fine = {.level = &grid->level[p->level],
                          .lo = {p->at[0] * grid->edge, p->at[1] * grid->edge},
                          .size = {p->core[0], p->core[1]},
                          .capacity = grid->edge,
                          .width = width,
                          .voxels = core,
                          .min = core,
                          .max = core};
    struct window coarse = {.level = &grid->level[p->level + 1],
                            .lo = {lo[0], lo[1]},
                            .size = {part.size[0], part.size[1]},
                            .capacity = halved[2] ? grid->edge / 2 : grid->edge,
                            .width = width,
                            .voxels = core + array,
                            .min = core + 2 * array,
                            .max = core + 3 * array};
    for (uint32_t z = 0; z < part.size[2]; z++)
        for (uint32_t y = 0; y < part.size[1]; y++)
            downsample_row(kernels, &fine, &coarse, halved, grid->type, nearest, lo[0], part.size[0],
                           lo[1] + y, lo[2] + z);
    memcpy(out, coarse.voxels, (size_t)part.size[0] * part.size[1] * part.size[2] * width);
}

void agree_take_part(const struct brick_grid *grid, const struct brick_place *parent, const void *voxels,
                     const struct agree_part *part, void *out)
{
    uint32_t from[3], to[3];
    for (int a = 0; a < 3; a++) {
        from[a] = grid->border + part->lo[a];
        to[a] = from[a] + part->size[a];
    }
    copy_box(parent, brick_type_bytes(grid->type), voxels, from, to, out);
}
