/* The basis hexahedron: a cell in tetrahedra, each projected to a fan of triangles around its thick vertex
 * (Maximo et al. 2008, sections 3 and 4.1; the classes are those of figure 1, after Shirley and Tuchman
 * 1990).
 *
 * A cell inside the volume is five tetrahedra: one whose vertices are the four voxels with an even sum of
 * indices, and four around it, each at an odd voxel. So the split alternates from cell to cell, and the
 * diagonals of faces coincide. At the volume's rim, half a voxel wide, the field is constant outwards. A cell
 * that is outside on one axis is there six tetrahedra, for five would lay the other diagonal through its
 * outer face; outside on two or three axes any split has the same field. */
#ifndef RENDERER_CELLS_BASIS_H
#define RENDERER_CELLS_BASIS_H

#include "lattice.h"

#define VR_BASIS_SLOTS  5 /* tetrahedra that are drawn as one piece; a cell of six is two pieces */
#define VR_BASIS_FAN    5 /* vertices of a fan: four around, and the thick one */
#define VR_BASIS_THICK  4 /* the thick one's number */
#define VR_BASIS_KINDS  (27 * 2 * 2)
#define VR_BASIS_TEXELS 4 /* of four floats, a vertex of a fan in the shader's table */

/* The kind of a piece: on which side of the volume (-1 low, 0 inside, 1 high) the cell is on each axis;
 * whether the sum of its indices is odd; which piece of the cell. */
static inline int vr_basis_kind(const int side[3], int odd, int piece)
{
    return ((((side[2] + 1) * 3 + side[1] + 1) * 3 + side[0] + 1) * 2 + odd) * 2 + piece;
}

struct vr_basis_tetrahedron {
    int corner[4];            /* of the cell: bit a is set on axis a's upper side */
    int projection_class;     /* 1 to 4 */
    int triangles;            /* (thick, around[i], around[i + 1]), around[4] being around[0] */
    int around[4];            /* vertices, 0 to 3; VR_BASIS_THICK where the fan has no more */
    double front[4], back[4]; /* the thick vertex's ray enters and leaves at these mixtures of the vertices:
                                 the paper's intersection parameters */
    int anchor;               /* the thick vertex is at this vertex of the picture ... */
    double offset[3];         /* ... plus that, in pixels right and down and, for where its ray enters, mm */
    double length_mm;         /* the thickness l */
};

struct vr_basis_cell {
    int count; /* 5 or 6, farthest first */
    struct vr_basis_tetrahedron tetrahedron[6];
};

/* The projection of all cells of one kind. The order holds along every ray: of two tetrahedra that a ray
 * passes the one behind comes first. */
void vr_basis_cell(const struct vr_lattice *lattice, const int side[3], int odd, struct vr_basis_cell *cell);

/* What shaders/cells_fan.vert.glsl reads: for each kind, slot and vertex of a fan VR_BASIS_TEXELS texels,
 * (front weights), (back weights), (offset right, down, mm; code), (length, 0, 0, 0), with code = corners in
 * 3 bits each + anchor << 12. Empty slots are points. triangles: how many each slot's fan has at most. */
void vr_basis_table(const struct vr_lattice *lattice, float *table, int triangles[VR_BASIS_SLOTS]);
/* Floats of it. */
#define VR_BASIS_TABLE_FLOATS (VR_BASIS_KINDS * VR_BASIS_SLOTS * VR_BASIS_FAN * VR_BASIS_TEXELS * 4)

#endif
