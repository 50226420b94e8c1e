/* A scene as another program reads it: voxels in a raw file, the rest in JSON. */
#ifndef TOOLS_PEERS_PEER_SCENE_H
#define TOOLS_PEERS_PEER_SCENE_H

#include <brick/volume.h>
#include <renderer/renderer.h>

struct cJSON;

/* Level 0 as a raw file in which all axes ascend in the world, written slab by slab. Spacing and origin: of
 * that file. BRICK_ERR_UNSUPPORTED when its axes are not the world's, or values fall while stored ones rise.
 */
int peer_scene_write_volume(const struct brick_volume *volume, const char *path, double spacing[3],
                            double origin[3], struct brick_error *err);
/* The first line that peers/vtk_peer.py reads. NULL when memory ran out. */
struct cJSON *peer_scene_json(const struct brick_volume *volume, const struct vr_scene *scene, double step_mm,
                              const char *volume_path, const double spacing[3], const double origin[3],
                              const struct brick_camera *cameras, size_t count);

#endif
