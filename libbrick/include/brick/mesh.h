/* Opaque triangle meshes in the volume's world. */
#ifndef BRICK_MESH_H
#define BRICK_MESH_H

#include <stdint.h>

#include <brick/error.h>

#ifdef __cplusplus
extern "C" {
#endif

#define BRICK_MESH_MAX         ((uint64_t)1 << 28) /* vertices; triangles */
#define BRICK_MESH_MAX_CORNERS 1024                /* of a polygon */
#define BRICK_MESH_MAX_MM      1e9                 /* a coordinate's magnitude */

/* Plain data. A mesh of zeros is empty; the arrays are its own and grow as it is added to. */
struct brick_mesh {
    double (*position_mm)[3]; /* patient axes LPS, finite */
    float (*normal)[3];       /* a vertex's, of length 1, or 0 for none; NULL: none has any */
    float (*colour)[3];       /* a vertex's, linear, in [0,1]; NULL: none has any */
    uint32_t (*triangle)[3];  /* vertices, each below `vertices` */
    uint64_t vertices, triangles;
    uint64_t vertex_room, triangle_room;
};

/* normal (of any length) and colour: each NULL for all vertices or for none. BRICK_ERR_FORMAT where that is
 * not so, and for numbers that are not finite or too large; BRICK_ERR_MEMORY. */
int brick_mesh_add_vertex(struct brick_mesh *mesh, const double position_mm[3], const double normal[3],
                          const double colour[3], struct brick_error *err);

/* A simple polygon of 3 to BRICK_MESH_MAX_CORNERS vertices that are there already, convex or not, as
 * triangles. BRICK_ERR_FORMAT for another number or a vertex that is not there. */
int brick_mesh_add_polygon(struct brick_mesh *mesh, const uint64_t *corners, uint64_t count,
                           struct brick_error *err);

/* Of all vertices; of an empty mesh low > high. */
void brick_mesh_bounds(const struct brick_mesh *mesh, double low_mm[3], double high_mm[3]);
void brick_mesh_finish(struct brick_mesh *mesh);

#ifdef __cplusplus
}
#endif
#endif
