/* Mesh formats: what mesh_registry.c asks of a format. */
#ifndef FORMATS_MESH_FORMATS_H
#define FORMATS_MESH_FORMATS_H

#include <brick/io.h>
#include <brick/mesh.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Add what the file holds to an empty mesh, which the caller finishes whatever happens. */
int fmt_mesh_ply_read(struct brick_mesh *mesh, const struct brick_io *io, struct brick_error *err);
int fmt_mesh_obj_read(struct brick_mesh *mesh, const struct brick_io *io, struct brick_error *err);

/* What the mesh itself refuses, with the file's name before it. */
int fmt_mesh_place(const struct brick_io *io, int result, const struct brick_error *inner,
                   struct brick_error *err);

#ifdef __cplusplus
}
#endif
#endif
