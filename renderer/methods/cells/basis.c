/* From tetrahedra to fans.
 *
 * Along a ray the barycentric coordinates of a tetrahedron's vertices change at constant rates that sum to 0.
 * Their signs are the projection class, and they are the intersection parameters: the four projected points
 * fall into those with a rate above 0 and those below, and the two sets' hulls meet in one point, the thick
 * vertex. Its ray enters where the coordinates with rates above 0 are 0, and leaves where those below are,
 * after 1 / (sum of the rates above 0). One against three: a vertex inside the triangle of the others, class
 * 1. Two against two: crossing edges, class 2. With a rate of 0 the same in fewer dimensions: a vertex on an
 * edge, class 3; two vertices in one point, class 4. So one formula does what the paper has four cross
 * products and up to two segment intersections for. */
#include "basis.h"

#include <math.h>
#include <string.h>

/* Rasterisers round corners to 1/256 pixel. A face no wider than a few of those is one seen edge on: as a
 * triangle of a fan it may fall on the wrong side of its own outline and count twice, or leave a gap where
 * the tetrahedron is thickest. Left out of the fans of both its tetrahedra, their outlines meet. Lengths and
 * scalars of a ray are then those of one that much beside it. (In views on which faces are seen so, this
 * takes the error from 1e-1 to 1e-3; fewer leave some of it in some, more cost more than they bring.) Where
 * voxels are hardly larger, a part of the face's length counts. */
#define EDGE_ON_PIXELS (4.0 / 256.0)
#define EDGE_ON_PART   0.05
#define NO_WIDTH       1e-9

static double place(int corner, int axis, const int side[3])
{
    double at = corner >> axis & 1 ? 1.0 : 0.0;
    if ((at == 0.0 && side[axis] < 0) || (at == 1.0 && side[axis] > 0))
        return 0.5;
    return at;
}

/* Rates of the barycentric coordinates in a mm of a ray. */
static void find_rates(const double vertex[4][3], const double direction[3], double rate[4])
{
    for (int v = 0; v < 4; v++) {
        const double *o = vertex[(v + 1) & 3], *a = vertex[(v + 2) & 3], *b = vertex[(v + 3) & 3];
        double normal[3], height = 0.0, along = 0.0;
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            normal[i] = (a[j] - o[j]) * (b[k] - o[k]) - (a[k] - o[k]) * (b[j] - o[j]);
        }
        for (int i = 0; i < 3; i++) {
            height += normal[i] * (vertex[v][i] - o[i]);
            along += normal[i] * direction[i];
        }
        rate[v] = along / height;
    }
}

static int vertices_with(const double rate[4], int sign, int list[4])
{
    int n = 0;
    for (int v = 0; v < 4; v++)
        if ((rate[v] > 0.0) - (rate[v] < 0.0) == sign)
            list[n++] = v;
    return n;
}

/* The fan around the thick vertex, from the vertices with rates above, below and at 0. */
static void make_fan(struct vr_basis_tetrahedron *t, const double rate[4])
{
    int above[4], below[4], flat[4];
    int a = vertices_with(rate, 1, above), b = vertices_with(rate, -1, below);
    vertices_with(rate, 0, flat);
    const int *pair = a > b ? above : below; /* or three; the other set, when alone, is the thick vertex */
    int single = a > b ? below[0] : above[0];
    int *r = t->around;
    t->anchor = single;
    if (a == 2 && b == 2) {
        t->projection_class = 2;
        t->triangles = 4;
        r[0] = above[0], r[1] = below[0], r[2] = above[1], r[3] = below[1];
        t->anchor = 0;
    } else if (a + b == 4) {
        t->projection_class = 1;
        t->triangles = 3;
        r[0] = pair[0], r[1] = pair[1], r[2] = pair[2], r[3] = pair[0];
    } else if (a + b == 3) {
        t->projection_class = 3;
        t->triangles = 2;
        r[0] = pair[0], r[1] = flat[0], r[2] = pair[1], r[3] = VR_BASIS_THICK;
    } else {
        t->projection_class = 4;
        t->triangles = 1;
        r[0] = flat[0], r[1] = flat[1], r[2] = r[3] = VR_BASIS_THICK;
    }
}

/* Is the face opposite a vertex seen edge on? place: of the vertices, in pixels. At the volume's surface only
 * where it has no width: there is no neighbour to leave it out as well, and a ray may run along it for long.
 */
static bool edge_on(const double place[4][3], int vertex, bool at_surface)
{
    double longest = 0.0, twice_area = 0.0;
    for (int i = 1; i < 4; i++) {
        const double *a = place[(vertex + i) & 3], *b = place[(vertex + i % 3 + 1) & 3];
        longest = fmax(longest, hypot(b[0] - a[0], b[1] - a[1]));
        twice_area += a[0] * b[1] - a[1] * b[0];
    }
    double width = at_surface ? NO_WIDTH * longest : fmin(EDGE_ON_PIXELS, EDGE_ON_PART * longest);
    return fabs(twice_area) <= width * longest;
}

/* Does the face opposite a vertex lie in the volume's own surface? */
static bool at_surface(const int corner[4], const int side[3], int vertex)
{
    bool found = false;
    for (int a = 0; a < 3; a++) {
        bool all = side[a] != 0;
        for (int i = 1; i < 4; i++)
            all = all && (corner[(vertex + i) & 3] >> a & 1) == (side[a] > 0);
        found = found || all;
    }
    return found;
}

/* Rates of faces seen edge on to 0, unless that left nothing to enter or to leave by. */
static void drop_flat_faces(const int corner[4], const int side[3], const double place[4][3], double rate[4])
{
    double dropped[4];
    bool above = false, below = false;
    for (int v = 0; v < 4; v++) {
        dropped[v] = edge_on(place, v, at_surface(corner, side, v)) ? 0.0 : rate[v];
        above = above || dropped[v] > 0.0;
        below = below || dropped[v] < 0.0;
    }
    if (above && below)
        memcpy(rate, dropped, sizeof dropped);
}

/* rate: returned for the order. */
static void project(const struct vr_projection *projection, const int side[3], struct vr_basis_tetrahedron *t,
                    double rate[4])
{
    const double *const rows[3] = {projection->column, projection->row, projection->depth};
    double vertex[4][3], seen[4][3], in = 0.0, out = 0.0;
    for (int v = 0; v < 4; v++) {
        for (int i = 0; i < 3; i++)
            vertex[v][i] = place(t->corner[v], i, side);
        for (int r = 0; r < 3; r++)
            seen[v][r] = rows[r][0] * vertex[v][0] + rows[r][1] * vertex[v][1] + rows[r][2] * vertex[v][2];
    }
    find_rates(vertex, projection->direction, rate);
    drop_flat_faces(t->corner, side, seen, rate);
    for (int v = 0; v < 4; v++) {
        in += fmax(-rate[v], 0.0);
        out += fmax(rate[v], 0.0);
    }
    for (int v = 0; v < 4; v++) {
        t->front[v] = fmax(-rate[v], 0.0) / in;
        t->back[v] = fmax(rate[v], 0.0) / out;
    }
    t->length_mm = 2.0 / (in + out);
    make_fan(t, rate);
    for (int r = 0; r < 3; r++) {
        t->offset[r] = 0.0;
        for (int v = 0; v < 4; v++)
            t->offset[r] += t->front[v] * (seen[v][r] - seen[t->anchor][r]);
    }
    if (t->projection_class != 2) /* a vertex of the lattice, and so exactly where its neighbours have it */
        t->offset[0] = t->offset[1] = 0.0;
}

/* The corners of the tetrahedra; returns how many. */
static int split(const int side[3], int odd, int corner[6][4])
{
    int outside = 0, axis = 0, count = 0;
    for (int a = 0; a < 3; a++)
        if (side[a])
            outside++, axis = a;
    if (outside == 1) {
        /* Two prisms, from triangles of the inner face to the outer one; corner o of an outer triangle is
         * across from corner i of the inner one. */
        int inner = side[axis] < 0 ? 1 << axis : 0, across = 1 << axis;
        int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
        const int face[4] = {inner, inner | u | v, inner | u, inner | v};
        int even = (__builtin_popcount((unsigned)inner) & 1) == odd ? 0 : 2;
        for (int prism = 0; prism < 2; prism++) {
            int p = face[even], q = face[even + 1], r = face[2 - even + prism];
            const int three[3][4] = {{p, q, r, r ^ across},
                                     {p, q, q ^ across, r ^ across},
                                     {p, p ^ across, q ^ across, r ^ across}};
            memcpy(corner[count], three, sizeof three);
            count += 3;
        }
        return count;
    }
    /* Corners 1, 2, 4 and 7 are at odd voxels, or else at even ones: the other four then are. */
    static const int outer[4] = {1, 2, 4, 7};
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++)
            corner[i][j] = j == 3 ? outer[i] ^ odd : outer[i] ^ odd ^ 1 << j;
        corner[4][i] = outer[i] ^ odd ^ 1;
    }
    return 5;
}

/* Is a behind b, with a face between them? Rays go from b to a where a's coordinate of the vertex that is not
 * b's ascends. */
static bool is_behind(const struct vr_basis_tetrahedron *a, const double rate[4],
                      const struct vr_basis_tetrahedron *b)
{
    int shared = 0, alone = 0;
    for (int i = 0; i < 4; i++) {
        bool found = false;
        for (int j = 0; j < 4; j++)
            found = found || a->corner[i] == b->corner[j];
        shared += found;
        if (!found)
            alone = i;
    }
    return shared == 3 && rate[alone] > 0.0;
}

/* A ray goes from one tetrahedron of a cell into the next through a face that they share, so an order that
 * keeps to "behind" across faces keeps to it along every ray. Neither split has cycles. */
void vr_basis_cell(const struct vr_projection *projection, const int side[3], int odd,
                   struct vr_basis_cell *cell)
{
    struct vr_basis_tetrahedron t[6];
    int corner[6][4];
    double rate[6][4];
    bool placed[6] = {false};
    cell->count = 0;
    int count = split(side, odd, corner);
    for (int i = 0; i < count; i++) {
        memcpy(t[i].corner, corner[i], sizeof t[i].corner);
        project(projection, side, &t[i], rate[i]);
    }
    while (cell->count < count) {
        int next = 0;
        for (bool free = false; !free; next++) {
            free = !placed[next];
            for (int j = 0; j < count && free; j++)
                free = placed[j] || !is_behind(&t[j], rate[j], &t[next]);
        }
        placed[next - 1] = true;
        cell->tetrahedron[cell->count++] = t[next - 1];
    }
}

/* One vertex of a fan. Thin ones are on both sides the vertex itself. */
static void write_vertex(const struct vr_basis_tetrahedron *t, int fan_vertex, float *out)
{
    int vertex = fan_vertex == VR_BASIS_THICK ? VR_BASIS_THICK : t->around[fan_vertex], code = 0,
        anchor = vertex;
    memset(out, 0, VR_BASIS_TEXELS * 4 * sizeof *out);
    if (vertex == VR_BASIS_THICK) {
        anchor = t->anchor;
        for (int v = 0; v < 4; v++) {
            out[v] = (float)t->front[v];
            out[4 + v] = (float)t->back[v];
        }
        for (int i = 0; i < 3; i++)
            out[8 + i] = (float)t->offset[i];
        out[12] = (float)t->length_mm;
    } else {
        out[vertex] = out[4 + vertex] = 1.0f;
    }
    for (int v = 0; v < 4; v++)
        code |= t->corner[v] << 3 * v;
    out[11] = (float)(code | t->corner[anchor] << 12);
}

void vr_basis_table(const struct vr_projection *projection, float *table, int triangles[VR_BASIS_SLOTS])
{
    const size_t stride = VR_BASIS_TEXELS * 4, slot_floats = VR_BASIS_FAN * stride;
    memset(table, 0, VR_BASIS_TABLE_FLOATS * sizeof *table);
    memset(triangles, 0, VR_BASIS_SLOTS * sizeof *triangles);
    for (int s = 0; s < 27; s++)
        for (int odd = 0; odd < 2; odd++) {
            const int side[3] = {s % 3 - 1, s / 3 % 3 - 1, s / 9 - 1};
            struct vr_basis_cell cell;
            vr_basis_cell(projection, side, odd, &cell);
            for (int i = 0; i < cell.count; i++) {
                int slot = i % VR_BASIS_SLOTS, kind = vr_basis_kind(side, odd, i / VR_BASIS_SLOTS);
                float *out = table + (size_t)(kind * VR_BASIS_SLOTS + slot) * slot_floats;
                for (int v = 0; v < VR_BASIS_FAN; v++)
                    write_vertex(&cell.tetrahedron[i], v, out + (size_t)v * stride);
                if (cell.tetrahedron[i].triangles > triangles[slot])
                    triangles[slot] = cell.tetrahedron[i].triangles;
            }
        }
}
