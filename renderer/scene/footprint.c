/* Bricks' boxes, projected: all pixels of a box lie between those of its corners, if all of these are before
 * the eye. A brick is seen where its cells are, which reach half a voxel beyond the outermost sample where
 * the volume ends; boxes are half a voxel larger everywhere, and rectangles a pixel. */
#include "footprint.h"

#include <math.h>

#include <brick/active.h>

#include "projection.h"

/* False when the point is not before the eye. */
static bool project(const struct vr_projection *p, const double at[3], double pixel[2])
{
    const double d[3] = {at[0] - p->origin[0], at[1] - p->origin[1], at[2] - p->origin[2]};
    double ahead = p->parallel ? 1.0 : vr_dot(p->inverse[2], d);
    if (!(ahead > 0.0))
        return false;
    pixel[0] = vr_dot(p->inverse[0], d) / ahead;
    pixel[1] = vr_dot(p->inverse[1], d) / ahead;
    return true;
}

/* Range of tiles on one axis; empty when first > last. */
static void tile_range(double low, double high, int start, int size, int edge, int *first, int *last)
{
    low = fmax(low - 1.0 - start, 0.0);
    high = fmin(high + 1.0 - start, size - 0.5);
    *first = low >= size ? 1 : (int)low / edge;
    *last = high < 0.0 || low >= size ? 0 : (int)high / edge;
    if (high < 0.0)
        *first = 1;
}

static void mark_box(const struct vr_projection *p, const double low[3], const double high[3],
                     const struct vr_tiles *tiles, uint32_t *flags)
{
    double from[2] = {INFINITY, INFINITY}, to[2] = {-INFINITY, -INFINITY};
    int first[2], last[2];
    for (int corner = 0; corner < 8; corner++) {
        double at[3], pixel[2];
        for (int a = 0; a < 3; a++)
            at[a] = corner >> a & 1 ? high[a] : low[a];
        bool before = project(p, at, pixel);
        for (int a = 0; a < 2; a++) {
            from[a] = before ? fmin(from[a], pixel[a]) : -INFINITY;
            to[a] = before ? fmax(to[a], pixel[a]) : INFINITY;
        }
        if (!before)
            break;
    }
    tile_range(from[0], to[0], tiles->x, tiles->width, tiles->edge, &first[0], &last[0]);
    tile_range(from[1], to[1], tiles->y, tiles->height, tiles->edge, &first[1], &last[1]);
    for (int y = first[1]; y <= last[1]; y++)
        for (int x = first[0]; x <= last[0]; x++)
            flags[y * tiles->across + x] = 1;
}

void vr_footprint(const struct brick_view *view, const struct brick_grid *grid, uint32_t level,
                  const uint8_t *states, const struct vr_tiles *tiles, uint32_t *flags)
{
    const struct brick_level *l = &grid->level[level];
    struct vr_projection p;
    vr_projection_init(&p, view);
    for (int y = 0; y * tiles->edge < tiles->height; y++)
        for (int x = 0; x * tiles->edge < tiles->width; x++)
            flags[y * tiles->across + x] = 0;
    uint64_t b[3];
    for (b[2] = 0; b[2] < l->bricks[2]; b[2]++)
        for (b[1] = 0; b[1] < l->bricks[1]; b[1]++)
            for (b[0] = 0; b[0] < l->bricks[0]; b[0]++) {
                double low[3], high[3];
                if (*states++ < BRICK_STATE_ACTIVE)
                    continue;
                for (int a = 0; a < 3; a++) {
                    double end = fmin((double)(b[a] + 1) * grid->edge, (double)l->dims[a]);
                    low[a] = l->scale[a] * ((double)b[a] * grid->edge - 0.5) + l->offset[a];
                    high[a] = l->scale[a] * (end + 0.5) + l->offset[a];
                }
                mark_box(&p, low, high, tiles, flags);
            }
}
