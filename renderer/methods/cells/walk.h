/* Which cells of a brick are drawn, in the traversal order (Maximo et al. 2008, section 4.3). */
#ifndef RENDERER_CELLS_WALK_H
#define RENDERER_CELLS_WALK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <brick/grid.h>

/* A piece of a cell as the shaders know it: its place in the brick + 1 on each axis, in 9 bits each, and the
 * piece's number << 27 (basis.h). Where cells are not taken to pieces, that is 1 for a cell of six
 * tetrahedra.
 */
#define VR_CELL_PIECE_BIT 27

/* Boxes in the level's index space; false: nothing of it is in the picture. */
typedef bool vr_cell_box_test(const void *context, const double low[3], const double high[3]);

struct vr_cell_walk {
    const struct brick_level *level;
    uint32_t macrocell;        /* its edge */
    double eye[3];             /* in the level's index space; parallel rays: infinite, from where they come */
    bool whole;                /* cells are not taken to pieces */
    const uint32_t *active;    /* bits of the brick's macrocells; NULL: all of them */
    uint32_t macro_strides[2]; /* bit = x + y strides[0] + z strides[1] */
    vr_cell_box_test *visible;
    const void *visible_context;
    int64_t first[3]; /* the brick's first voxel */
    uint32_t core[3], macrocells[3];
};

/* level, macrocell, first, core and macrocells, for a brick of the grid; the others are the caller's, active
 * and macro_strides as struct vr_macrocells has them. */
void vr_cell_walk_init(struct vr_cell_walk *walk, const struct brick_grid *grid,
                       const struct brick_place *place);

/* Macrocells of the brick, 0 to walk's product, in the order of the traversal: append the pieces of the cells
 * of macrocell number `turn` to entries. Returns how many; at most vr_cell_walk_most. */
size_t vr_cell_walk_macrocell(const struct vr_cell_walk *walk, uint32_t turn, uint32_t *entries);
size_t vr_cell_walk_most(const struct vr_cell_walk *walk);

/* Tetrahedra that a level's cells are made of. */
uint64_t vr_cell_tetrahedra(const struct brick_level *level);

#endif
