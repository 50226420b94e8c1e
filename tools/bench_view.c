/* Why: what one measurement says of a picture is to be held against what another says of the same. */
#include "bench_view.h"

#include <math.h>

void bench_view_scene(const struct bench_view *view, const struct brick_volume *volume,
                      struct vr_scene *scene)
{
    double range[2];
    brick_volume_value_range(volume, range);
    *scene = vr_scene_defaults;
    scene->width = view->size[0];
    scene->height = view->size[1];
    scene->isovalue = view->has_iso ? view->iso : (range[0] + range[1]) / 2;
    brick_camera_orbit(&scene->camera, brick_volume_grid(volume), view->orbit[0], view->orbit[1], 0,
                       view->ortho_mm, (double)scene->width / scene->height);
}

double bench_view_diagonal_mm(const struct brick_volume *volume)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    double spacing[3], diagonal = 0.0;
    brick_grid_spacing_mm(grid, spacing);
    for (int a = 0; a < 3; a++)
        diagonal = hypot(diagonal, spacing[a] * (double)grid->dims[a]);
    return diagonal;
}
