#include "gl_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

struct vr_renderer *renderer_of(const struct brick_volume *volume, const struct vr_renderer_params *params)
{
    struct brick_error err = {0};
    struct vr_renderer *renderer = NULL;
    int result = vr_renderer_create(&renderer, volume, params, &err);
    if (result == BRICK_ERR_UNSUPPORTED)
        print_message("%s\n", err.message);
    else if (result)
        fail_msg("%s", err.message);
    return renderer;
}

struct vr_renderer *try_renderer(const struct brick_volume *volume, enum vr_context_kind kind)
{
    struct vr_renderer_params params = vr_renderer_defaults;
    params.context = kind;
    return renderer_of(volume, &params);
}

uint64_t slots_bytes(const struct brick_volume *volume, uint64_t bricks)
{
    const struct brick_grid *grid = brick_volume_grid(volume);
    uint64_t stored = grid->edge + 2 * grid->border;
    return bricks * stored * stored * stored * brick_type_bytes(grid->type);
}

void set_way(int way, struct vr_scene *scene, struct vr_quality *quality)
{
    scene->mode = (enum brick_mode)(way % 4);
    quality->classification = way < 4 ? VR_CLASSIFY_POST : VR_CLASSIFY_PREINTEGRATED;
}

struct brick_volume *volume_of(struct memory_source *source, uint32_t edge)
{
    char name[64];
    struct brick_build_params params = brick_build_defaults;
    params.edge = edge;
    snprintf(name, sizeof name, "edge%u.brick", edge);
    return build_and_open(source, name, &params);
}

struct brick_transfer *transfer_of(const struct brick_transfer_point *points, size_t count)
{
    struct brick_error err = {0};
    struct brick_transfer *transfer = NULL;
    const struct brick_transfer_spec spec = {.points = (struct brick_transfer_point *)points,
                                             .count = count,
                                             .unit = 1.0,
                                             .unit_of = BRICK_UNIT_MM};
    if (brick_transfer_create(&transfer, &spec, 1.0, (const double[2]){0, 1}, &err))
        fail_msg("%s", err.message);
    return transfer;
}

void render(struct vr_renderer *renderer, const struct vr_scene *scene, const struct vr_quality *quality,
            struct brick_image *image, struct vr_report *report)
{
    struct brick_error err = {0};
    assert_int_equal(brick_image_init(image, scene->width, scene->height, &err), 0);
    if (vr_render(renderer, scene, quality, image, report, &err))
        fail_msg("%s", err.message);
}

void end_or_skip(struct vr_renderer **renderer, struct brick_transfer **transfer,
                 struct brick_volume **volume)
{
    const bool none = !*renderer;
    vr_renderer_destroy(renderer);
    if (transfer)
        brick_transfer_destroy(transfer);
    brick_volume_close(volume);
    if (none)
        skip();
}

void assert_same_image(const struct brick_image *a, const struct brick_image *b, const char *what)
{
    struct brick_image_difference d;
    if (memcmp(a->rgba, b->rgba, (size_t)a->width * a->height * 4 * sizeof *a->rgba) == 0)
        return;
    brick_image_compare(a, b, &d, NULL);
    fail_msg("%s: %llu pixels differ, most by %g at %u,%u channel %u", what,
             (unsigned long long)d.pixels_differing, d.max_abs, d.max_x, d.max_y, d.max_channel);
}
