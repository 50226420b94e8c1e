/* Meshes: what a reader finds is checked as it is added, so that a mesh is always one that can be drawn.
 *
 * Room grows by doubling, with what was read: a number in a file takes no memory by itself. */
#include <brick/mesh.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define FIRST_ROOM 256

static bool grow(void *array, uint64_t room, size_t item_bytes)
{
    void **at = array;
    void *bigger = room > SIZE_MAX / item_bytes ? NULL : realloc(*at, (size_t)room * item_bytes);
    if (bigger)
        *at = bigger;
    return bigger;
}

static int no_room(const char *what, struct brick_error *err)
{
    return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the mesh's %s", what);
}

static int check_room(uint64_t count, const char *what, struct brick_error *err)
{
    return count < BRICK_MESH_MAX ? BRICK_OK
                                  : brick_fail(err, BRICK_ERR_UNSUPPORTED, "a mesh of more than %llu %s",
                                               (unsigned long long)BRICK_MESH_MAX, what);
}

static int more_vertices(struct brick_mesh *mesh, bool normals, bool colours, struct brick_error *err)
{
    uint64_t room = mesh->vertex_room ? 2 * mesh->vertex_room : FIRST_ROOM;
    int result = check_room(mesh->vertices, "vertices", err);
    if (result)
        return result;
    if (!grow(&mesh->position_mm, room, sizeof *mesh->position_mm) ||
        (normals && !grow(&mesh->normal, room, sizeof *mesh->normal)) ||
        (colours && !grow(&mesh->colour, room, sizeof *mesh->colour)))
        return no_room("vertices", err);
    mesh->vertex_room = room;
    return BRICK_OK;
}

int brick_mesh_add_vertex(struct brick_mesh *mesh, const double position_mm[3], const double normal[3],
                          const double colour[3], struct brick_error *err)
{
    const uint64_t v = mesh->vertices;
    for (int i = 0; i < 3; i++)
        if (!(fabs(position_mm[i]) <= BRICK_MESH_MAX_MM))
            return brick_fail(err, BRICK_ERR_FORMAT, "vertex %llu is at %g, not within %g mm",
                              (unsigned long long)v, position_mm[i], BRICK_MESH_MAX_MM);
    if (v && (!normal != !mesh->normal || !colour != !mesh->colour))
        return brick_fail(err, BRICK_ERR_FORMAT,
                          "vertex %llu has a normal or a colour where those before it have none, or none "
                          "where they have one",
                          (unsigned long long)v);
    if (v == mesh->vertex_room) {
        int result = more_vertices(mesh, normal, colour, err);
        if (result)
            return result;
    }
    memcpy(mesh->position_mm[v], position_mm, sizeof mesh->position_mm[v]);
    if (normal) {
        double length = hypot(hypot(normal[0], normal[1]), normal[2]);
        for (int i = 0; i < 3; i++)
            mesh->normal[v][i] = length > 0.0 && isfinite(length) ? (float)(normal[i] / length) : 0.0f;
    }
    if (colour)
        for (int i = 0; i < 3; i++)
            mesh->colour[v][i] = (float)fmin(fmax(colour[i], 0.0), 1.0);
    mesh->vertices++;
    return BRICK_OK;
}

static int add_triangle(struct brick_mesh *mesh, uint64_t a, uint64_t b, uint64_t c, struct brick_error *err)
{
    if (mesh->triangles == mesh->triangle_room) {
        uint64_t room = mesh->triangle_room ? 2 * mesh->triangle_room : FIRST_ROOM;
        int result = check_room(mesh->triangles, "triangles", err);
        if (result)
            return result;
        if (!grow(&mesh->triangle, room, sizeof *mesh->triangle))
            return no_room("triangles", err);
        mesh->triangle_room = room;
    }
    uint32_t *triangle = mesh->triangle[mesh->triangles++];
    triangle[0] = (uint32_t)a;
    triangle[1] = (uint32_t)b;
    triangle[2] = (uint32_t)c;
    return BRICK_OK;
}

/* A polygon seen along the axis that its normal is nearest to, counter-clockwise. */
struct flat {
    double x[BRICK_MESH_MAX_CORNERS], y[BRICK_MESH_MAX_CORNERS];
};

static void flatten(const struct brick_mesh *mesh, const uint64_t *corners, uint64_t count, struct flat *flat)
{
    double normal[3] = {0}; /* Newell's: twice the areas seen along the axes */
    for (uint64_t k = 0; k < count; k++) {
        const double *p = mesh->position_mm[corners[k]], *q = mesh->position_mm[corners[(k + 1) % count]];
        for (int i = 0; i < 3; i++) {
            int u = (i + 1) % 3, v = (i + 2) % 3;
            normal[i] += (p[u] - q[u]) * (p[v] + q[v]);
        }
    }
    int axis = fabs(normal[0]) > fabs(normal[1]) ? 0 : 1;
    if (fabs(normal[2]) > fabs(normal[axis]))
        axis = 2;
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (uint64_t k = 0; k < count; k++) {
        flat->x[k] = mesh->position_mm[corners[k]][normal[axis] < 0.0 ? v : u];
        flat->y[k] = mesh->position_mm[corners[k]][normal[axis] < 0.0 ? u : v];
    }
}

static double area(const struct flat *f, uint32_t a, uint32_t b, uint32_t c)
{
    return (f->x[b] - f->x[a]) * (f->y[c] - f->y[a]) - (f->y[b] - f->y[a]) * (f->x[c] - f->x[a]);
}

/* Can the corner at `at` be cut off: is it convex, with no other corner in its triangle? */
static bool is_ear(const struct flat *f, const uint32_t *ring, uint32_t left, uint32_t at)
{
    uint32_t a = ring[(at + left - 1) % left], b = ring[at], c = ring[(at + 1) % left];
    if (!(area(f, a, b, c) > 0.0))
        return false;
    for (uint32_t k = 0; k < left; k++) {
        uint32_t p = ring[k];
        if (p != a && p != b && p != c && area(f, a, b, p) >= 0.0 && area(f, b, c, p) >= 0.0 &&
            area(f, c, a, p) >= 0.0)
            return false;
    }
    return true;
}

int brick_mesh_add_polygon(struct brick_mesh *mesh, const uint64_t *corners, uint64_t count,
                           struct brick_error *err)
{
    struct flat flat;
    uint32_t ring[BRICK_MESH_MAX_CORNERS], left = (uint32_t)count;
    int result = BRICK_OK;
    if (count < 3 || count > BRICK_MESH_MAX_CORNERS)
        return brick_fail(err, BRICK_ERR_FORMAT, "a face of %llu corners; 3 to %d are possible",
                          (unsigned long long)count, BRICK_MESH_MAX_CORNERS);
    for (uint64_t k = 0; k < count; k++)
        if (corners[k] >= mesh->vertices)
            return brick_fail(err, BRICK_ERR_FORMAT, "a face has vertex %llu of %llu",
                              (unsigned long long)corners[k], (unsigned long long)mesh->vertices);
    if (left > 3)
        flatten(mesh, corners, count, &flat);
    for (uint32_t k = 0; k < left; k++)
        ring[k] = k;
    while (left > 3 && !result) {
        uint32_t ear = 1;
        while (ear < left && !is_ear(&flat, ring, left, ear))
            ear++;
        if (ear ==
            left) /* none but perhaps the first; a polygon that crosses itself or has no area has none */
            ear = 0;
        result = add_triangle(mesh, corners[ring[(ear + left - 1) % left]], corners[ring[ear]],
                              corners[ring[(ear + 1) % left]], err);
        left--;
        memmove(ring + ear, ring + ear + 1, (left - ear) * sizeof *ring);
    }
    return result ? result : add_triangle(mesh, corners[ring[0]], corners[ring[1]], corners[ring[2]], err);
}

void brick_mesh_bounds(const struct brick_mesh *mesh, double low_mm[3], double high_mm[3])
{
    for (int i = 0; i < 3; i++) {
        low_mm[i] = INFINITY;
        high_mm[i] = -INFINITY;
        for (uint64_t v = 0; v < mesh->vertices; v++) {
            low_mm[i] = fmin(low_mm[i], mesh->position_mm[v][i]);
            high_mm[i] = fmax(high_mm[i], mesh->position_mm[v][i]);
        }
    }
}

void brick_mesh_finish(struct brick_mesh *mesh)
{
    free(mesh->position_mm);
    free(mesh->normal);
    free(mesh->colour);
    free(mesh->triangle);
    *mesh = (struct brick_mesh){0};
}
