/* The cameras of a film: a turntable, or a path from a JSON file. */
#ifndef TOOLS_CAMERAS_H
#define TOOLS_CAMERAS_H

#include <stddef.h>

#include <brick/camera.h>

struct tool_cameras {
    struct brick_camera *item; /* owned */
    size_t count;
};

/* Where a camera that names neither comes from. */
struct tool_view {
    double azimuth, elevation;       /* degrees */
    double fov_deg, ortho_height_mm; /* 0: the default opening; no parallel projection */
    double aspect;
};

/* n >= 1 cameras around the vertical axis, from the view's azimuth on. */
int tool_cameras_turntable(struct tool_cameras *cameras, const struct brick_grid *grid,
                           const struct tool_view *view, uint32_t n, struct brick_error *err);
/* [{"azimuth": A, "elevation": E}, {"eye": [X,Y,Z], "look": [X,Y,Z], "up": [X,Y,Z]}, ...], each with "fov" or
 * "ortho" if it likes; what is left out is the view's, or for look and up the box's centre and 0,0,1.
 * BRICK_ERR_IO; BRICK_ERR_FORMAT with the number of the camera that makes no sense. */
int tool_cameras_load(struct tool_cameras *cameras, const char *path, const struct brick_grid *grid,
                      const struct tool_view *view, struct brick_error *err);
void tool_cameras_finish(struct tool_cameras *cameras);

#endif
